#include "experiment/view_truth.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/progress.h"

namespace truescatter {
namespace {

std::string_view name_of(LayerKind kind) {
  switch (kind) {
    case LayerKind::euclidean:
      return "truth";
    case LayerKind::geodesic:
      return "geodesic truth";
    case LayerKind::visible:
      return "truth of the visible surface";
    case LayerKind::unsure:
      return "bound of the visible surface";
  }
  std::abort();
}

}  // namespace

Image measured_mask(Image mask, const Image& smallest_mass) {
  for (std::size_t i = 0; i < mask.data().size(); ++i) {
    if (smallest_mass.data()[i] < static_cast<float>(kSmallMass)) mask.data()[i] = 0.0F;
  }
  return mask;
}

double plane_mass(const TruthLayer& layer) {
  const double q = layer.r_max_mm / layer.std_dev_mm;
  return -std::expm1(-0.5 * q * q);
}

TruthLayer truth_layer(double variance_mm2, const OwnTarget& target, double tolerance) {
  TruthLayer layer{std::sqrt(variance_mm2)};
  if (target.r_max_mm &&
      std::exp(-0.5 * *target.r_max_mm * *target.r_max_mm / variance_mm2) > 0.01 * tolerance) {
    layer.r_max_mm = *target.r_max_mm;
  }
  return layer;
}

ViewTruth::ViewTruth(const PreparedScene& scene, const FrameImages& images)
    : scene_(scene), images_(images), points_(view_points(scene, images)) {}

std::size_t ViewTruth::index_of(LayerKind kind, const TruthLayer& layer) const {
  const auto found = std::find_if(layers_.begin(), layers_.end(),
                                  [&](const LayerResult& r) { return r.kind == kind && r.layer == layer; });
  assert(found != layers_.end());
  return static_cast<std::size_t>(found - layers_.begin());
}

void ViewTruth::compute_kind(LayerKind kind, const std::vector<TruthLayer>& layers,
                             const LayerSource& source) {
  Progress progress(
      fmt::format("{} of {} points, {} Gaussians", name_of(kind), points_.size(), layers.size()),
      points_.size() * layers.size());
  std::vector<ComputedLayer> computed =
      source.compute(layers, [&](std::size_t steps) { progress.advance(steps); });
  for (std::size_t l = 0; l < layers.size(); ++l)
    layers_.push_back({kind, layers[l], std::move(computed[l]), {}});
}

std::vector<Certificate> ViewTruth::audit_kind(LayerKind kind, const std::vector<TruthLayer>& layers,
                                               const LayerSource& source) const {
  const Progress progress(fmt::format("audit of the {} at {} points", name_of(kind), sample_.points.size()),
                          1);
  const TruthValues exact = source.audit_values(sample_.points, layers);
  AuditTerms terms;
  terms.tolerance = tolerance_;
  terms.tail_bound = source.tail_bound();
  terms.largest_irradiance = source.largest_irradiance();
  terms.random_count = sample_.random_count;
  std::vector<Certificate> certificates;
  for (std::size_t l = 0; l < layers.size(); ++l) {
    terms.plane_mass = plane_mass(layers[l]);
    certificates.push_back(
        audit(layers_[index_of(kind, layers[l])].computed.values, exact[l], sample_.points, terms));
  }
  return certificates;
}

void ViewTruth::certify_kind(LayerKind kind, const std::vector<TruthLayer>& layers,
                             const LayerSource& source) {
  const auto all_passed = [](const std::vector<Certificate>& certificates) {
    return std::all_of(certificates.begin(), certificates.end(), [](const auto& c) { return c.passed(); });
  };
  const auto is_kind = [&](const LayerResult& result) { return result.kind == kind; };
  std::vector<Certificate> certificates = audit_kind(kind, layers, source);
  const bool cached = std::any_of(layers_.begin(), layers_.end(),
                                  [&](const LayerResult& r) { return is_kind(r) && r.computed.cached; });
  if (cached && !all_passed(certificates)) {
    fmt::print(stderr, "note: the {} in the cache fails its audit; it is computed again\n", name_of(kind));
    source.forget(layers);
    std::erase_if(layers_, is_kind);
    compute_kind(kind, layers, source);
    certificates = audit_kind(kind, layers, source);
  }
  for (std::size_t l = 0; l < layers.size(); ++l) {
    if (certificates[l].passed()) continue;
    throw_run_error(
        "the audit of the {} failed: at standard deviation {:.4g} mm the fast engine is off by {:.3g} of the "
        "largest irradiance (allowed: {:.3g}); nothing is ranked",
        name_of(kind), layers[l].std_dev_mm, certificates[l].max_error, certificates[l].tolerance);
  }
  for (std::size_t l = 0; l < layers.size(); ++l) {
    LayerResult& result = layers_[index_of(kind, layers[l])];
    result.certificate = certificates[l];
    source.keep(layers, l, result.computed);
  }
}

ViewTruth::Wanted ViewTruth::wanted_layers(const std::vector<Request>& requests) const {
  Wanted wanted;
  const auto want = [&](LayerKind kind, const TruthLayer& layer) {
    auto of_kind = std::find_if(wanted.begin(), wanted.end(), [&](const auto& w) { return w.first == kind; });
    if (of_kind == wanted.end()) of_kind = wanted.insert(wanted.end(), {kind, {}});
    std::vector<TruthLayer>& layers = of_kind->second;
    if (std::find(layers.begin(), layers.end(), layer) == layers.end()) layers.push_back(layer);
  };
  for (const Request& request : requests) {
    for (const GaussianLevel& level : gaussian_levels(*request.profile)) {
      const TruthLayer layer = layer_of(level.variance_mm2, request.target);
      want(kind_of(request.target), layer);
      if (request.target.visible_only) want(LayerKind::unsure, layer);
    }
  }
  return wanted;
}

CacheClaim ViewTruth::claim_of(const Wanted& wanted,
                               const std::vector<std::unique_ptr<LayerSource>>& sources) {
  std::size_t layers = 0;
  bool kept = true;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    layers += wanted[k].second.size();
    kept = kept && sources[k]->are_kept(wanted[k].second);
  }
  return kept ? CacheClaim() : sources.front()->claim(layers);
}

void ViewTruth::compute(const std::vector<Request>& requests, const TruthSpec& spec,
                        const SourceOf& source_of, const GeodesicSurface* geodesic) {
  assert(points_.size() > 0);
  tolerance_ = spec.tolerance;
  const Wanted wanted = wanted_layers(requests);
  std::vector<std::unique_ptr<LayerSource>> sources;
  sources.reserve(wanted.size());
  for (const auto& [kind, layers] : wanted) sources.push_back(source_of(kind, points_));
  // One claim for all of a view's layers, until they have passed their audit and are kept: who holds one and
  // waits for another could wait for ever.
  const CacheClaim claim = claim_of(wanted, sources);
  for (std::size_t k = 0; k < wanted.size(); ++k)
    compute_kind(wanted[k].first, wanted[k].second, *sources[k]);
  const auto narrowest = std::min_element(
      layers_.begin(), layers_.end(),
      [](const LayerResult& a, const LayerResult& b) { return a.layer.std_dev_mm < b.layer.std_dev_mm; });
  sample_ = draw_audit_sample({scene_.shading, images_, points_, narrowest->computed.values, geodesic},
                              static_cast<std::size_t>(spec.audit_points), spec.seed);
  for (std::size_t k = 0; k < wanted.size(); ++k)
    certify_kind(wanted[k].first, wanted[k].second, *sources[k]);
}

Image ViewTruth::picture_of(const std::vector<double>& values) const {
  Image picture(images_.mask.width(), images_.mask.height(), 1);
  for (std::size_t i = 0; i < values.size(); ++i)
    picture.at(points_.pixels[i].x, points_.pixels[i].y, 0) = static_cast<float>(values[i]);
  return picture;
}

Image ViewTruth::picture_of(const std::vector<Vec3d>& values) const {
  Image picture(images_.mask.width(), images_.mask.height(), 3);
  for (std::size_t i = 0; i < values.size(); ++i)
    picture.set_rgb(points_.pixels[i].x, points_.pixels[i].y, values[i]);
  return picture;
}

// With u the mass of what is unsure and m that of what was taken for seen, light of at most 1 more or less
// from what is unsure changes M by at most u, and M/m by at most u / (m - u), and never by more than 1.
std::vector<double> ViewTruth::visibility_bounds(const Request& request) const {
  std::vector<Vec3d> bound(points_.size(), Vec3d::Zero());
  for (const GaussianLevel& level : gaussian_levels(*request.profile)) {
    const TruthLayer layer = layer_of(level.variance_mm2, request.target);
    const std::vector<Vec4d>& unsure = layers_[index_of(LayerKind::unsure, layer)].computed.values;
    const std::vector<Vec4d>& seen = layers_[index_of(LayerKind::visible, layer)].computed.values;
    for (std::size_t i = 0; i < bound.size(); ++i) {
      const double u = unsure[i][3];
      const double rest = seen[i][3] - u;
      const double normalised = rest > u ? u / rest : 1.0;
      bound[i] += (request.target.normalised ? normalised : u) * level.weight.cwiseAbs();
    }
  }
  std::vector<double> largest;
  largest.reserve(bound.size());
  for (const Vec3d& channels : bound) largest.push_back(channels.maxCoeff());
  return largest;
}

void ViewTruth::Tally::add(const LayerResult& result, const Vec3d& weight) {
  weights += weight.cwiseAbs();
  seconds += result.computed.seconds;
  cached = cached && result.computed.cached;
  const double largest = std::max(certificate.max_error, result.certificate.max_error);
  certificate = result.certificate;
  certificate.max_error = largest;
  // The largest error of a layer, times this, bounds the sum's.
  certificate.weight = std::max(1.0, weights.maxCoeff());
}

WeightedSum ViewTruth::weighted_sum(const Request& request) const {
  WeightedSum sum;
  sum.light.assign(points_.size(), Vec3d::Zero());
  sum.mass.assign(points_.size(), Vec3d::Zero());
  Tally tally;
  for (const GaussianLevel& level : gaussian_levels(*request.profile)) {
    const LayerResult& result =
        layers_[index_of(kind_of(request.target), layer_of(level.variance_mm2, request.target))];
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec4d& value = result.computed.values[i];
      sum.light[i] += level.weight.cwiseProduct(value.head<3>());
      sum.mass[i] += level.weight * value[3];
    }
    tally.add(result, level.weight);
  }
  sum.certificate = tally.certificate;
  sum.seconds = tally.seconds;
  sum.cached = tally.cached;
  return sum;
}

TruthImage ViewTruth::image(const Request& request) const {
  const LayerKind kind = kind_of(request.target);
  TruthImage truth;
  std::vector<Vec3d> sum(points_.size());
  std::vector<double> mass(points_.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < points_.size(); ++i)
    sum[i] = request.profile->delta_weight.cwiseProduct(points_.irradiance[i]);
  Tally tally;
  for (const GaussianLevel& level : gaussian_levels(*request.profile)) {
    const LayerResult& result = layers_[index_of(kind, layer_of(level.variance_mm2, request.target))];
    const double whole = plane_mass(result.layer);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec4d& value = result.computed.values[i];
      const double divisor = request.target.normalised ? value[3] : 1.0;
      if (divisor > 0.0) sum[i] += level.weight.cwiseProduct(value.head<3>()) / divisor;
      mass[i] = std::min(mass[i], value[3] / whole);
    }
    // Divided by a mass below 1, what the layer is known to grows.
    tally.add(result, request.target.normalised ? Vec3d(level.weight / whole) : level.weight);
  }
  truth.certificate = tally.certificate;
  truth.seconds = tally.seconds;
  truth.cached = tally.cached;
  truth.rgb = picture_of(sum);
  truth.smallest_mass = picture_of(mass);
  if (request.target.visible_only) truth.visibility_bound = picture_of(visibility_bounds(request));
  return truth;
}

}  // namespace truescatter
