#include "truth/audit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "truth/exact.h"

namespace truescatter {
namespace {

constexpr double kSmallMass = 0.5;
// How many standard deviations the closed form reaches: beyond lies at most a hundredth of the tolerance of a
// plane's mass, and never more than the 1.5e-8 of 6, at half the cost of going to rounding.
double audit_reach(double tolerance) { return std::max(6.0, std::sqrt(-2.0 * std::log(0.01 * tolerance))); }

double difference(const Vec4d& fast, const Vec4d& exact, double largest_irradiance) {
  double worst = (fast - exact).head<3>().cwiseAbs().maxCoeff() / largest_irradiance;
  worst = std::max(worst, std::abs(fast[3] - exact[3]));
  if (exact[3] >= kSmallMass && fast[3] > 0.0) {
    const Vec3d normalised = fast.head<3>() / fast[3] - exact.head<3>() / exact[3];
    worst = std::max(worst, normalised.cwiseAbs().maxCoeff() / largest_irradiance);
  }
  return worst;
}

}  // namespace

Certificate audit(const Surface& surface, std::span<const SurfacePoint> points,
                  std::span<const TruthLayer> layers, const TruthValues& values, double tolerance,
                  double tail_bound, std::span<const std::uint32_t> audited, std::size_t random_count) {
  std::vector<SurfacePoint> chosen;
  for (const std::uint32_t i : audited) chosen.push_back(points[i]);
  const TruthValues exact = ExactEngine(surface, audit_reach(tolerance)).convolve(chosen, layers);

  Certificate certificate;
  certificate.audited = audited.size();
  certificate.tolerance = tolerance;
  certificate.tail_bound = tail_bound;
  const double largest = surface.largest_irradiance();
  for (std::size_t l = 0; l < layers.size(); ++l) {
    for (std::size_t i = 0; i < audited.size(); ++i) {
      certificate.max_error =
          std::max(certificate.max_error, difference(values[l][audited[i]], exact[l][i], largest));
    }
  }
  // If a share q of the points were worse, n random points would all miss it with probability (1 - q)^n.
  if (random_count > 0) {
    certificate.open_share = 1.0 - std::pow(0.05, 1.0 / static_cast<double>(random_count));
  }
  return certificate;
}

}  // namespace truescatter
