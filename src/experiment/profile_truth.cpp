#include "experiment/profile_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/parallel.h"
#include "core/progress.h"
#include "truth/radial_exact.h"

namespace truescatter {
namespace {

constexpr std::size_t kCheckedPoints = 32;
// Of a shell around a point, in units of a plane's; FastEngine::tail_bound takes the same.
constexpr double kMostShellArea = 2.0;
// Of what is allowed, for all the stretches of all edges; the quadrature reports what it needed.
constexpr double kQuadratureShare = 1e-3;
constexpr double kFinestQuadrature = 1e-13;

// Some of the audited points, evenly from all the classes for which they were drawn.
std::vector<std::uint32_t> checked_points(const AuditSample& audited) {
  const std::size_t count = std::min(kCheckedPoints, audited.points.size());
  std::vector<std::uint32_t> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(audited.points[i * audited.points.size() / count]);
  return points;
}

// By how much one point's sum is off, beyond the quadrature's own error.
double difference_at(const ProfileModel& model, const WeightedSum& sum, std::uint32_t point,
                     const SurfacePoint& place, const RadialExactEngine& engine, double largest_irradiance) {
  double worst = 0.0;
  for (std::size_t c = 0; c < model.channels.size(); ++c) {
    const ImageSources& profile = model.channels[c];
    const RadialValue exact = engine.convolve(
        place, {[&](double r_mm) { return profile.antiderivative(r_mm); }, profile.shortest_length_mm()});
    const auto channel = static_cast<Eigen::Index>(c);
    const double light = std::abs(sum.light[point][channel] - exact.value[channel]) - exact.error[channel];
    const double mass = std::abs(sum.mass[point][channel] - exact.value[3]) - exact.error[3];
    // A maximum would pass over what is not a number.
    if (!std::isfinite(light) || !std::isfinite(mass)) return std::numeric_limits<double>::infinity();
    worst = std::max({worst, light / largest_irradiance, mass});
  }
  return worst;
}

RadialCheck check_radially(const ProfileModel& model, const WeightedSum& sum, const ViewTruth& truth,
                           const Surface& surface) {
  const std::vector<std::uint32_t> points = checked_points(truth.audited());
  RadialCheck check;
  check.points = points.size();
  check.allowed =
      kMostShellArea * model.error_bound.maxCoeff() + sum.certificate.weight * sum.certificate.tolerance;
  const double tolerance =
      std::max(kFinestQuadrature,
               kQuadratureShare * check.allowed / (3.0 * static_cast<double>(surface.triangles.size())));
  const RadialExactEngine engine(surface, tolerance);
  const double largest_irradiance = surface.largest_irradiance();
  std::vector<double> differences(points.size());
  Progress progress(fmt::format("{} itself at {} points", model.title, points.size()), points.size());
  parallel_for(points.size(), [&](std::size_t i) {
    differences[i] = difference_at(model, sum, points[i], truth.points().on_surface[points[i]], engine,
                                   largest_irradiance);
    progress.advance();
  });
  check.max_difference = *std::max_element(differences.begin(), differences.end());
  if (!(check.max_difference <= check.allowed)) {
    throw_run_error(
        "the audit of the profile of '{}' failed: its mixture of Gaussians is off by {:.3g} of the largest "
        "irradiance (allowed: {:.3g}); nothing is ranked",
        model.mixture.name, check.max_difference, check.allowed);
  }
  return check;
}

// The smallest share that is measured; a plane's where none is.
double smallest_measured_share(const Image& mass) {
  double smallest = 1.0;
  for (const float share : mass.data()) {
    if (share >= static_cast<float>(kSmallMass)) smallest = std::min(smallest, static_cast<double>(share));
  }
  return smallest;
}

}  // namespace

ViewTruth::Request request_of(const ProfileModel& model) {
  return {&model.mixture, {false, false, std::nullopt}};
}

ProfileTruth profile_truth(const ProfileModel& model, const ViewTruth& truth, const Surface* surface) {
  const WeightedSum sum = truth.weighted_sum(request_of(model));
  std::vector<Vec3d> normalised(sum.light.size(), Vec3d::Zero());
  std::vector<double> share;
  for (std::size_t i = 0; i < sum.light.size(); ++i) {
    share.push_back(sum.mass[i].cwiseQuotient(model.albedo).minCoeff());
    if (!(share.back() > 0.0)) continue;
    normalised[i] = model.albedo.cwiseProduct(sum.light[i]).cwiseQuotient(sum.mass[i]);
  }
  ProfileTruth result;
  if (surface != nullptr) result.check = check_radially(model, sum, truth, *surface);
  result.raw = {
      truth.picture_of(sum.light), truth.picture_of(share), {}, sum.certificate, sum.seconds, sum.cached};
  result.raw.certificate.approximation = kMostShellArea * model.error_bound.maxCoeff();
  result.normalised = result.raw;
  result.normalised.rgb = truth.picture_of(normalised);
  // With errors of M and m of at most d, and M/m at most 1: A (M/m) is off by at most A/m (d + d).
  const double factor = 2.0 / smallest_measured_share(result.raw.smallest_mass);
  result.normalised.certificate.weight *= factor;
  result.normalised.certificate.approximation *= factor;
  return result;
}

}  // namespace truescatter
