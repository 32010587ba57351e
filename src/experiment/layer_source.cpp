#include "experiment/layer_source.h"

#include <chrono>
#include <utility>

#include "truth/audit.h"
#include "truth/exact.h"
#include "truth/geodesic_exact.h"
#include "truth/geodesic_fast.h"

namespace truescatter {
namespace {

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

template <typename Point>
std::vector<Point> chosen_of(const std::vector<Point>& points, std::span<const std::uint32_t> chosen) {
  std::vector<Point> result;
  for (const std::uint32_t i : chosen) result.push_back(points[i]);
  return result;
}

class EuclideanSource : public LayerSource {
 public:
  EuclideanSource(const Surface& surface, const FastEngine& engine, const ViewPoints& points)
      : surface_(surface), engine_(engine), points_(points) {}

  std::vector<ComputedLayer> compute(std::span<const TruthLayer> layers,
                                     const std::function<void(std::size_t)>& advance) const override {
    std::vector<ComputedLayer> computed;
    for (const TruthLayer& layer : layers) {
      const Stopwatch watch;
      TruthValues values = engine_.convolve(points_.on_surface, std::span(&layer, 1), advance);
      computed.push_back({std::move(values.front()), watch.seconds()});
    }
    return computed;
  }
  TruthValues audit_values(std::span<const std::uint32_t> chosen,
                           std::span<const TruthLayer> layers) const override {
    return ExactEngine(surface_, audit_reach_std_devs(engine_.tolerance()))
        .convolve(chosen_of(points_.on_surface, chosen), layers);
  }
  double tail_bound() const override { return engine_.tail_bound(); }
  double largest_irradiance() const override { return surface_.largest_irradiance(); }

 private:
  const Surface& surface_;
  const FastEngine& engine_;
  const ViewPoints& points_;
};

class GeodesicSource : public LayerSource {
 public:
  GeodesicSource(const GeodesicSurface& surface, double tolerance, const ViewPoints& points)
      : surface_(surface), engine_(surface, tolerance), points_(points) {}

  std::vector<ComputedLayer> compute(std::span<const TruthLayer> layers,
                                     const std::function<void(std::size_t)>& advance) const override {
    const Stopwatch watch;
    TruthValues values = engine_.convolve(points_.on_mesh, layers, advance);
    const double seconds = watch.seconds() / static_cast<double>(layers.size());
    std::vector<ComputedLayer> computed;
    for (std::vector<Vec4d>& layer : values) computed.push_back({std::move(layer), seconds});
    return computed;
  }
  TruthValues audit_values(std::span<const std::uint32_t> chosen,
                           std::span<const TruthLayer> layers) const override {
    return GeodesicExactEngine(surface_, audit_reach_std_devs(engine_.tolerance()))
        .convolve(chosen_of(points_.on_mesh, chosen), layers);
  }
  double tail_bound() const override { return engine_.tail_bound(); }
  double largest_irradiance() const override { return surface_.largest_irradiance(); }

 private:
  const GeodesicSurface& surface_;
  GeodesicFastEngine engine_;
  const ViewPoints& points_;
};

}  // namespace

LayerKind kind_of(const OwnTarget& target) {
  return target.geodesic ? LayerKind::geodesic : LayerKind::euclidean;
}

std::unique_ptr<LayerSource> euclidean_source(const Surface& surface, const FastEngine& engine,
                                              const ViewPoints& points) {
  return std::make_unique<EuclideanSource>(surface, engine, points);
}

std::unique_ptr<LayerSource> geodesic_source(const GeodesicSurface& surface, double tolerance,
                                             const ViewPoints& points) {
  return std::make_unique<GeodesicSource>(surface, tolerance, points);
}

}  // namespace truescatter
