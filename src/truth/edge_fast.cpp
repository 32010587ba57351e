#include "truth/edge_fast.h"

#include <array>

#include "truth/exact.h"

namespace truescatter {
namespace {

// Gauss-Legendre quadrature with 6 nodes along a piece of an edge is accurate to about 1e-7 of the Gaussian
// at its nearest: the integrand's poles lie at t = +-ip, and with half the piece's length a at most half the
// distance from the foot to its middle, the ellipse of analyticity has a radius of at least 2 + sqrt(3) (a
// pole beside the end) or 2 + sqrt(5) (beside the middle), so the error is of the order of 3.7^-12 = 1e-7; a
// <= s keeps the Gaussian's own part below that (0.5^12 / 12!).
bool suits_quadrature(double p, double t0, double t1, double std_dev_mm) {
  const double half = 0.5 * (t1 - t0);
  const double middle = 0.5 * (t0 + t1);
  return half <= std_dev_mm && 4.0 * half * half <= middle * middle + p * p;
}

// int (level - exp(-rho^2 / 2s^2)) p / rho^2 dt and int exp(-rho^2 / 2s^2) dt, by that quadrature.
EdgeIntegrals edge_by_quadrature(double p, double t0, double t1, double std_dev_mm, double level) {
  static constexpr std::array<double, 3> kNodes = {0.2386191860831969, 0.6612093864662645,
                                                   0.9324695142031521};
  static constexpr std::array<double, 3> kWeights = {0.4679139345726910, 0.3607615730481386,
                                                     0.1713244923791704};
  const double half = 0.5 * (t1 - t0);
  const double middle = 0.5 * (t0 + t1);
  Eigen::Array<double, 8, 1> t = Eigen::Array<double, 8, 1>::Constant(middle);
  Eigen::Array<double, 8, 1> weight = Eigen::Array<double, 8, 1>::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto n = static_cast<std::size_t>(i);
    t[2 * i] -= half * kNodes[n];
    t[2 * i + 1] += half * kNodes[n];
    weight[2 * i] = weight[2 * i + 1] = half * kWeights[n];
  }
  const Eigen::Array<double, 8, 1> rho2 = t.square() + p * p;
  const Eigen::Array<double, 8, 1> gauss = (rho2 * (-0.5 / (std_dev_mm * std_dev_mm))).exp();
  return {(weight * (level - gauss) * p / rho2).sum(), (weight * gauss).sum()};
}

}  // namespace

EdgeIntegrals edge_inside_fast(double p, double t0, double t1, double std_dev_mm, double at_foot) {
  if (!suits_quadrature(p, t0, t1, std_dev_mm)) return edge_inside_exact(p, t0, t1, std_dev_mm, at_foot);
  const EdgeIntegrals sum = edge_by_quadrature(p, t0, t1, std_dev_mm, 1.0);
  const double scale = at_foot / (2.0 * kPi);
  return {sum.radial * scale, -sum.line * scale};
}

EdgeIntegrals edge_outside_fast(double p, double t0, double t1, double h, double std_dev_mm, double at_cut) {
  const double at_foot = gauss_at(h, std_dev_mm);
  if (!suits_quadrature(p, t0, t1, std_dev_mm)) {
    EdgeIntegrals sum = edge_inside_exact(p, t0, t1, std_dev_mm, at_foot);
    sum.radial -= edge_beyond_cut(p, t0, t1, at_foot, at_cut).radial;
    return sum;
  }
  const EdgeIntegrals sum = edge_by_quadrature(p, t0, t1, std_dev_mm, at_cut / at_foot);
  const double scale = at_foot / (2.0 * kPi);
  return {sum.radial * scale, -sum.line * scale};
}

}  // namespace truescatter
