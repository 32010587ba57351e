#include "experiment/layer_source.h"

#include <cassert>
#include <utility>

#include "core/stopwatch.h"
#include "truth/audit.h"
#include "truth/exact.h"
#include "truth/fast.h"
#include "truth/geodesic_exact.h"
#include "truth/geodesic_fast.h"

namespace truescatter {
namespace {

// To be raised with every change that may change a bit of an engine's results: cached truths are found by it.
constexpr int kFastEngineVersion = 4;
constexpr int kGeodesicFastEngineVersion = 3;

void append_engine(ContentHash& hash, const std::string& name, int version, double tolerance) {
  hash.append(name);
  hash.append(version);
  hash.append(std::string(TRUESCATTER_COMPILER " " TRUESCATTER_BUILD_TYPE " " TRUESCATTER_ARCH));
  hash.append(tolerance);
}

template <typename Point>
std::vector<Point> chosen_of(const std::vector<Point>& points, std::span<const std::uint32_t> chosen) {
  std::vector<Point> result;
  for (const std::uint32_t i : chosen) result.push_back(points[i]);
  return result;
}

class EuclideanSource : public LayerSource {
 public:
  EuclideanSource(const Surface& surface, double tolerance, double largest_irradiance,
                  const ViewPoints& points)
      : surface_(surface),
        engine_(surface, tolerance),
        largest_irradiance_(largest_irradiance),
        points_(points) {}

  std::vector<ComputedLayer> compute(std::span<const TruthLayer> layers,
                                     const std::function<void(std::size_t)>& advance) const override {
    std::vector<ComputedLayer> computed;
    for (const TruthLayer& layer : layers) {
      if (surface_.triangles.empty()) {
        computed.push_back({std::vector<Vec4d>(points_.size(), Vec4d::Zero())});
        advance(points_.size());
        continue;
      }
      const Stopwatch watch;
      TruthValues values = engine_.convolve(points_.on_surface, std::span(&layer, 1), advance);
      computed.push_back({std::move(values.front()), watch.seconds()});
    }
    return computed;
  }
  TruthValues audit_values(std::span<const std::uint32_t> chosen,
                           std::span<const TruthLayer> layers) const override {
    if (surface_.triangles.empty())
      return TruthValues(layers.size(), std::vector<Vec4d>(chosen.size(), Vec4d::Zero()));
    return ExactEngine(surface_, audit_reach_std_devs(engine_.tolerance()))
        .convolve(chosen_of(points_.on_surface, chosen), layers);
  }
  double tail_bound() const override { return engine_.tail_bound(); }
  double largest_irradiance() const override { return largest_irradiance_; }
  std::size_t point_count() const override { return points_.size(); }
  bool computes_together() const override { return false; }
  std::string content_key() const override {
    ContentHash hash;
    append_engine(hash, "euclidean", kFastEngineVersion, engine_.tolerance());
    hash.append(surface_.triangles.size());
    for (const SurfaceTriangle& triangle : surface_.triangles) {
      for (const Vec3d& corner : triangle.corners_mm) hash.append(corner);
      for (const Vec3d& value : triangle.irradiance) hash.append(value);
      hash.append(triangle.component);
    }
    hash.append(points_.size());
    for (const SurfacePoint& point : points_.on_surface) {
      hash.append(point.position_mm);
      hash.append(point.component);
    }
    return hash.hex();
  }

 private:
  const Surface& surface_;
  FastEngine engine_;
  double largest_irradiance_;
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
  std::size_t point_count() const override { return points_.size(); }
  bool computes_together() const override { return true; }
  std::string content_key() const override {
    ContentHash hash;
    append_engine(hash, "geodesic", kGeodesicFastEngineVersion, engine_.tolerance());
    append_content(hash, surface_, points_.on_mesh);
    return hash.hex();
  }

 private:
  const GeodesicSurface& surface_;
  GeodesicFastEngine engine_;
  const ViewPoints& points_;
};

void append_surface(ContentHash& hash, const GeodesicSurface& surface) {
  const IntrinsicMesh& mesh = surface.mesh();
  hash.append(mesh.face_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (int j = 0; j < 3; ++j) {
      hash.append(mesh.corner(f, j));
      hash.append(mesh.corner_angle(f, j));
      hash.append(mesh.vertex(f, j));
    }
    hash.append(surface.pieces(f).size());
    for (const FlatPiece& piece : surface.pieces(f)) {
      for (const Vec2d& corner : piece.corners_mm) hash.append(corner);
      for (const Vec3d& value : piece.irradiance) hash.append(value);
      hash.append(piece.component);
    }
  }
}

}  // namespace

void append_content(ContentHash& hash, const GeodesicSurface& surface,
                    std::span<const GeodesicTarget> targets) {
  append_surface(hash, surface);
  hash.append(targets.size());
  for (const GeodesicTarget& target : targets) {
    hash.append(target.point.face);
    hash.append(target.point.barycentric);
    hash.append(target.component);
  }
}

LayerKind kind_of(const OwnTarget& target) {
  assert(!(target.geodesic && target.visible_only) && !target.transmittance);
  if (target.geodesic) return LayerKind::geodesic;
  return target.visible_only ? LayerKind::visible : LayerKind::euclidean;
}

std::unique_ptr<LayerSource> euclidean_source(const Surface& surface, double tolerance,
                                              double largest_irradiance, const ViewPoints& points) {
  return std::make_unique<EuclideanSource>(surface, tolerance, largest_irradiance, points);
}

std::unique_ptr<LayerSource> geodesic_source(const GeodesicSurface& surface, double tolerance,
                                             const ViewPoints& points) {
  return std::make_unique<GeodesicSource>(surface, tolerance, points);
}

}  // namespace truescatter
