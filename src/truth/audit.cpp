#include "truth/audit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace truescatter {
namespace {

double difference(const Vec4d& fast, const Vec4d& exact, const AuditTerms& terms) {
  // A maximum would pass over what is not a number.
  if (!fast.allFinite() || !exact.allFinite()) return std::numeric_limits<double>::infinity();
  double worst = (fast - exact).head<3>().cwiseAbs().maxCoeff() / terms.largest_irradiance;
  worst = std::max(worst, std::abs(fast[3] - exact[3]));
  if (exact[3] >= kSmallMass * terms.plane_mass && fast[3] > 0.0) {
    const Vec3d normalised = fast.head<3>() / fast[3] - exact.head<3>() / exact[3];
    worst = std::max(worst, terms.plane_mass * normalised.cwiseAbs().maxCoeff() / terms.largest_irradiance);
  }
  return worst;
}

}  // namespace

double audit_reach_std_devs(double tolerance) {
  return std::max(6.0, std::sqrt(-2.0 * std::log(0.01 * tolerance)));
}

Certificate audit(std::span<const Vec4d> values, std::span<const Vec4d> exact,
                  std::span<const std::uint32_t> audited, const AuditTerms& terms) {
  assert(exact.size() == audited.size() && terms.random_count <= audited.size());
  Certificate certificate;
  certificate.audited = audited.size();
  certificate.tolerance = terms.tolerance;
  certificate.tail_bound = terms.tail_bound;
  for (std::size_t i = 0; i < audited.size(); ++i) {
    certificate.max_error = std::max(certificate.max_error, difference(values[audited[i]], exact[i], terms));
  }
  // If a share q of the points were worse, n random points would all miss it with probability (1 - q)^n.
  if (terms.random_count > 0) {
    certificate.open_share = 1.0 - std::pow(0.05, 1.0 / static_cast<double>(terms.random_count));
  }
  return certificate;
}

}  // namespace truescatter
