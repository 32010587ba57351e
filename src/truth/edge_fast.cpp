#include "truth/edge_fast.h"

#include <array>
#include <cmath>
#include <vector>

#include "truth/exact.h"

namespace truescatter {
namespace {

// The tables end here: beyond, Gaussians are below exp(-6^2 / 2) = 1.5e-8.
constexpr double kReach = 6.0;
constexpr int kCells = 120;
constexpr double kStep = kReach / kCells;

// The cubic on [0, 1] with values v and derivatives d (by the cell's width) at the ends: its four weights.
std::array<double, 4> hermite_weights(double x) {
  const double y = 1.0 - x;
  return {y * y * (1.0 + 2.0 * x), x * x * (3.0 - 2.0 * x), x * y * y, -x * x * y};
}

// For s = 1, R(p, t) = 1/2pi int_0^t (1 - exp(-rho^2 / 2)) p / rho^2 dt = atan(t/p)/2pi - T(p, t/p), which is
// entire in p and t, odd in both. With rho^2 = p^2 + t^2 and g = (1 - exp(-rho^2 / 2)) / rho^2,
//
//   dR/dt = p g / 2pi,  dR/dp = exp(-p^2 / 2) erf(t / sqrt 2) / (2 sqrt(2 pi)) - t g / 2pi,
//   d2R/dpdt = (g + 2 p^2 dg/d(rho^2)) / 2pi.
//
// Along one variable cubic Hermite interpolation errs by at most step^4 / 384 |d4R|, 1.6e-8 |d4R| here, so
// along both by twice that and a product of higher order; |d4R/dp4| and |d4R/dt4| stay below 0.3.
class RadialTable {
 public:
  RadialTable() {
    for (int i = 0; i <= kCells; ++i) {
      for (int j = 0; j <= kCells; ++j) nodes_.push_back(node(i * kStep, j * kStep));
    }
  }

  // For 0 <= p < kReach and 0 <= t <= kReach.
  double operator()(double p, double t) const {
    const int i = std::min(static_cast<int>(p / kStep), kCells - 1);
    const int j = std::min(static_cast<int>(t / kStep), kCells - 1);
    const std::array<double, 4> wp = hermite_weights(p / kStep - i);
    const std::array<double, 4> wt = hermite_weights(t / kStep - j);
    const Node* low = &nodes_[static_cast<std::size_t>(i * (kCells + 1) + j)];
    const Node* high = low + (kCells + 1);
    const auto along_t = [&](const Node* n, std::size_t value, std::size_t slope) {
      return wt[0] * n[0][value] + wt[1] * n[1][value] + wt[2] * n[0][slope] + wt[3] * n[1][slope];
    };
    return wp[0] * along_t(low, 0, 1) + wp[1] * along_t(high, 0, 1) + wp[2] * along_t(low, 2, 3) +
           wp[3] * along_t(high, 2, 3);
  }

 private:
  using Node = std::array<double, 4>;  // R, step dR/dt, step dR/dp, step^2 d2R/dpdt

  static Node node(double p, double t) {
    const double u = p * p + t * t;
    // Near 0 by the series: both quotients would lose digits.
    const double g = u > 1e-3 ? -std::expm1(-0.5 * u) / u : 0.5 - u / 8.0 + u * u / 48.0;
    const double dg = u > 1e-3 ? (0.5 * std::exp(-0.5 * u) - g) / u : -1.0 / 8.0 + u / 24.0 - u * u / 128.0;
    const double line = std::exp(-0.5 * p * p) * std::erf(t / std::sqrt(2.0)) / (2.0 * std::sqrt(2.0 * kPi));
    return {edge_inside_exact(p, 0.0, t, 1.0, 1.0).radial, kStep * p * g / (2.0 * kPi),
            kStep * (line - t * g / (2.0 * kPi)), kStep * kStep * (g + 2.0 * p * p * dg) / (2.0 * kPi)};
  }

  std::vector<Node> nodes_;  // t fastest
};

double angle_between(double p, double t0, double t1) {
  return p == 0.0 ? 0.0 : std::atan2(p * (t1 - t0), p * p + t0 * t1);
}

// R for any t and p within reach.
double radial_up_to(double p, double t) {
  static const RadialTable table;
  const double distance = std::abs(p);
  const double length = std::abs(t);
  double value = table(distance, std::min(length, kReach));
  if (length > kReach) value += angle_between(distance, kReach, length) / (2.0 * kPi);
  return std::signbit(p) == std::signbit(t) ? value : -value;
}

}  // namespace

EdgeIntegrals edge_inside_fast(double p, double t0, double t1, double std_dev_mm, double at_foot) {
  const double scale = 1.0 / std_dev_mm;
  const double q = p * scale;
  const double a = t0 * scale;
  const double b = t1 * scale;
  if (std::abs(q) >= kReach || a >= kReach || b <= -kReach)
    return {at_foot * angle_between(p, t0, t1) / (2.0 * kPi), 0.0};
  const double along = std::erf(b / std::sqrt(2.0)) - std::erf(a / std::sqrt(2.0));
  return {at_foot * (radial_up_to(q, b) - radial_up_to(q, a)),
          -at_foot * std_dev_mm * std::exp(-0.5 * q * q) * along / (2.0 * std::sqrt(2.0 * kPi))};
}

EdgeIntegrals edge_outside_fast(double p, double t0, double t1, double h, double std_dev_mm, double at_cut) {
  const double at_foot = gauss_at(h, std_dev_mm);
  EdgeIntegrals sum = edge_inside_fast(p, t0, t1, std_dev_mm, at_foot);
  sum.radial -= edge_beyond_cut(p, t0, t1, at_foot, at_cut).radial;
  return sum;
}

}  // namespace truescatter
