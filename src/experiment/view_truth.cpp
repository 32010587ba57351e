#include "experiment/view_truth.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <random>

#include "core/progress.h"

namespace truescatter {
namespace {

double irradiance_contrast(const ShadingTriangle& triangle) {
  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  for (const Vec3d& value : triangle.irradiance) {
    low = std::min(low, luminance(value));
    high = std::max(high, luminance(value));
  }
  return high - low;
}

// Distinct points, in the order in which they were chosen.
class Sample {
 public:
  explicit Sample(std::size_t population) : taken_(population, 0) {}

  std::size_t size() const { return chosen_.size(); }
  const std::vector<std::uint32_t>& chosen() const { return chosen_; }

  // Draws until there are `size` (at most the population).
  void draw_to(std::size_t size, std::mt19937_64& generator) {
    while (chosen_.size() < size) add(static_cast<std::uint32_t>(generator() % taken_.size()));
  }

  // The `count` points of the largest scores among those not chosen yet; ties by index.
  void add_largest(const std::vector<double>& score, std::size_t count) {
    std::vector<std::uint32_t> order(score.size());
    std::iota(order.begin(), order.end(), 0U);
    const std::size_t looked_at = std::min(count + chosen_.size(), order.size());
    std::partial_sort(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(looked_at), order.end(),
        [&](std::uint32_t a, std::uint32_t b) { return score[a] != score[b] ? score[a] > score[b] : a < b; });
    const std::size_t wanted = std::min(chosen_.size() + count, order.size());
    for (std::size_t i = 0; i < looked_at && chosen_.size() < wanted; ++i) add(order[i]);
  }

 private:
  void add(std::uint32_t i) {
    if (taken_[i] != 0) return;
    taken_[i] = 1;
    chosen_.push_back(i);
  }

  std::vector<char> taken_;
  std::vector<std::uint32_t> chosen_;
};

}  // namespace

ViewTruth::ViewTruth(const PreparedScene& scene, const Surface& surface, const FrameImages& images)
    : surface_(surface), images_(images) {
  for (int y = 0; y < images.mask.height(); ++y) {
    for (int x = 0; x < images.mask.width(); ++x) {
      const PixelSurface& seen = images.surface_at(x, y);
      if (seen.triangle < 0 || images.mask.at(x, y, 0) == 0.0F) continue;
      const ShadingTriangle& triangle = scene.shading.triangles[static_cast<std::size_t>(seen.triangle)];
      SurfacePoint point;
      point.component = triangle.component;
      Vec3d irradiance = Vec3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        const double b = seen.barycentric[static_cast<Eigen::Index>(c)];
        point.position_mm += b * scene.shading.corner(triangle, c);
        irradiance += b * triangle.irradiance[c];
      }
      pixels_.push_back({x, y});
      points_.push_back(point);
      irradiance_.push_back(irradiance);
      contrast_.push_back(irradiance_contrast(triangle));
    }
  }
}

TruthLayer ViewTruth::layer_of(double variance_mm2, const OwnTarget& target) const {
  TruthLayer layer{std::sqrt(variance_mm2)};
  // A cut that removes less than a hundredth of the tolerance is no cut: the layer is shared.
  if (target.r_max_mm &&
      std::exp(-0.5 * *target.r_max_mm * *target.r_max_mm / variance_mm2) > 0.01 * tolerance_) {
    layer.r_max_mm = *target.r_max_mm;
  }
  return layer;
}

const ViewTruth::LayerResult& ViewTruth::result_of(const TruthLayer& layer) const {
  const auto found =
      std::find_if(layers_.begin(), layers_.end(), [&](const LayerResult& r) { return r.layer == layer; });
  assert(found != layers_.end());
  return *found;
}

// Half random; the rest in equal parts where irradiance changes fastest over a triangle (shadow edge), where
// the normal turns most to the next pixel (crease), and where the smallest Gaussian's mass is farthest from 1
// (boundary, mask edge, cut-off).
std::vector<std::uint32_t> ViewTruth::audited_points(const TruthSpec& spec) const {
  const auto wanted = std::min(static_cast<std::size_t>(spec.audit_points), points_.size());
  Sample sample(points_.size());
  std::mt19937_64 generator(spec.seed);
  sample.draw_to((wanted + 1) / 2, generator);
  std::vector<double> crease(points_.size(), 0.0);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto [x, y] = pixels_[i];
    const Vec3d normal = images_.face_normal.rgb(x, y);
    for (const auto& [nx, ny] : {Pixel{x + 1, y}, Pixel{x, y + 1}}) {
      if (nx >= images_.mask.width() || ny >= images_.mask.height() || images_.mask.at(nx, ny, 0) == 0.0F)
        continue;
      crease[i] = std::max(crease[i], 1.0 - normal.dot(images_.face_normal.rgb(nx, ny)));
    }
  }
  std::vector<double> mass(points_.size(), 0.0);
  for (const LayerResult& layer : layers_) {
    for (std::size_t i = 0; i < points_.size(); ++i)
      mass[i] = std::max(mass[i], std::abs(1.0 - layer.values[i][3]));
  }
  const std::size_t each = wanted / 2 / 3;
  sample.add_largest(contrast_, each);
  sample.add_largest(crease, each);
  sample.add_largest(mass, each);
  sample.draw_to(wanted, generator);
  return sample.chosen();
}

void ViewTruth::compute(const std::vector<Request>& requests, const TruthSpec& spec,
                        const FastEngine& engine) {
  tolerance_ = spec.tolerance;
  std::vector<TruthLayer> wanted;
  for (const Request& request : requests) {
    for (const GaussianLevel& level : gaussian_levels(*request.profile)) {
      const TruthLayer layer = layer_of(level.variance_mm2, request.target);
      if (std::find(wanted.begin(), wanted.end(), layer) == wanted.end()) wanted.push_back(layer);
    }
  }
  Progress progress(fmt::format("truth of {} points, {} Gaussians", points_.size(), wanted.size()),
                    points_.size() * wanted.size());
  for (const TruthLayer& layer : wanted) {
    const auto start = std::chrono::steady_clock::now();
    TruthValues values =
        engine.convolve(points_, std::span(&layer, 1), [&](std::size_t steps) { progress.advance(steps); });
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    layers_.push_back({layer, std::move(values.front()), {}, seconds});
  }
  if (points_.empty()) return;
  const std::vector<std::uint32_t> audited = audited_points(spec);
  const std::size_t random_count =
      (std::min(static_cast<std::size_t>(spec.audit_points), points_.size()) + 1) / 2;
  for (LayerResult& result : layers_) {
    const TruthValues values = {result.values};
    result.certificate = audit(surface_, points_, std::span(&result.layer, 1), values, spec.tolerance,
                               engine.tail_bound(), audited, random_count);
    if (!result.certificate.passed()) {
      throw_run_error(
          "the audit failed: at standard deviation {:.4g} mm the fast engine is off by {:.3g} of the largest "
          "irradiance (allowed: {:.3g}); nothing is ranked",
          result.layer.std_dev_mm, result.certificate.max_error, result.certificate.tolerance);
    }
  }
}

TruthImage ViewTruth::image(const Request& request) const {
  assert(!request.target.geodesic);
  TruthImage truth;
  truth.rgb = Image(images_.mask.width(), images_.mask.height(), 3);
  truth.smallest_mass = Image(images_.mask.width(), images_.mask.height(), 1);
  std::vector<Vec3d> sum(points_.size());
  std::vector<double> mass(points_.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < points_.size(); ++i)
    sum[i] = request.profile->delta_weight.cwiseProduct(irradiance_[i]);
  Vec3d weights = Vec3d::Zero();
  for (const GaussianLevel& level : gaussian_levels(*request.profile)) {
    const LayerResult& result = result_of(layer_of(level.variance_mm2, request.target));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec4d& value = result.values[i];
      const double divisor = request.target.normalised ? value[3] : 1.0;
      if (divisor > 0.0) sum[i] += level.weight.cwiseProduct(value.head<3>()) / divisor;
      mass[i] = std::min(mass[i], value[3]);
    }
    weights += level.weight.cwiseAbs();
    truth.seconds += result.seconds;
    Certificate& total = truth.certificate;
    total.audited = result.certificate.audited;
    total.tolerance = result.certificate.tolerance;
    total.tail_bound = result.certificate.tail_bound;
    total.open_share = result.certificate.open_share;
    total.max_error = std::max(total.max_error, result.certificate.max_error);
  }
  // The largest error of a layer, times this, bounds the sum's.
  truth.certificate.weight = std::max(1.0, weights.maxCoeff());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    truth.rgb.set_rgb(pixels_[i].x, pixels_[i].y, sum[i]);
    truth.smallest_mass.at(pixels_[i].x, pixels_[i].y, 0) = static_cast<float>(mass[i]);
  }
  return truth;
}

}  // namespace truescatter
