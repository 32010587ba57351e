#include "truth/radial_exact.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "truth/edge_formula.h"
#include "truth/gauss_kronrod.h"

namespace truescatter {
namespace {

constexpr int kDeepest = 40;
constexpr double kRoundings = 16.0;  // of some ten operations on positions, and of F
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// F(r) - F(r_max) up to the cut-off and 0 beyond: a constant changes neither integral round a triangle, and
// this one leaves nothing outside but the angle that belongs to the foot.
class CutAntiderivative {
 public:
  explicit CutAntiderivative(const RadialKernel& kernel)
      : kernel_(kernel),
        at_cut_(std::isfinite(kernel.r_max_mm) ? kernel.antiderivative(kernel.r_max_mm) : 0.0) {}

  double operator()(double r_mm) const {
    return r_mm < kernel_.r_max_mm ? kernel_.antiderivative(r_mm) - at_cut_ : 0.0;
  }

 private:
  const RadialKernel& kernel_;
  double at_cut_;
};

// Irradiance and 1 over a triangle's plane: i0 + gradient x about the foot.
struct PlaneLight {
  Vec4d at_foot = Vec4d::Zero();
  Eigen::Matrix<double, 4, 3> gradient = Eigen::Matrix<double, 4, 3>::Zero();
};

PlaneLight light_about(const Vec3d& foot, const SurfaceTriangle& triangle, const TriangleFrame& frame) {
  PlaneLight light;
  light.at_foot[3] = 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double share = (foot - triangle.corners_mm[(i + 1) % 3]).dot(frame.gradient[i]);
    light.at_foot.head<3>() += share * triangle.irradiance[i];
    light.gradient.topRows<3>() += triangle.irradiance[i] * frame.gradient[i].transpose();
  }
  return light;
}

// One edge, at signed distance p from the foot at height h.
struct Edge {
  double p;
  double h;
  double at_foot;  // F(h)
  double q;        // see the header
  Vec4d light;     // i0
  Vec4d slope;     // g.n
};

// Inside the cut-off, from arc length t0 to t1.
Quadrature stretch(const Edge& edge, const CutAntiderivative& f, double t0, double t1, const Vec4d& allowed) {
  Quadrature sum;
  if (!(t1 > t0)) return sum;
  const auto integrand = [&](double w) -> Vec4d {
    const double t = edge.q * std::sinh(w);
    const double rho2 = edge.p * edge.p + t * t;
    const double value = f(std::sqrt(edge.h * edge.h + rho2));
    const double radial = rho2 > 0.0 ? (value - edge.at_foot) * edge.p / rho2 : 0.0;
    return edge.q * std::cosh(w) * (radial * edge.light + value * edge.slope);
  };
  const double from = std::asinh(t0 / edge.q);
  const double to = std::asinh(t1 / edge.q);
  const double panels = std::ceil(to - from);
  for (double i = 0.0; i < panels; ++i) {
    sum += integrate_adaptively(integrand, from + i / panels * (to - from),
                                from + (i + 1.0) / panels * (to - from), allowed, kDeepest);
  }
  return sum;
}

// Beyond the cut-off only the foot's angle counts: -F(h) (atan(t1 / p) - atan(t0 / p)).
Vec4d beyond_cut(const Edge& edge, double t0, double t1) {
  if (!(t1 > t0) || edge.p == 0.0) return Vec4d::Zero();
  return -edge.at_foot * std::atan2(edge.p * (t1 - t0), edge.p * edge.p + t0 * t1) * edge.light;
}

// Where the edge is nearest, the kernel changes fastest: a panel ends there.
Quadrature whole_edge(const Edge& edge, const CutAntiderivative& f, double r_max_mm, double t0, double t1,
                      const Vec4d& allowed) {
  const Chord chord =
      std::isfinite(r_max_mm) ? chord_inside(edge.p, t0, t1, edge.h, r_max_mm) : Chord{t0, t1};
  const double nearest = std::clamp(0.0, chord.first, chord.last);
  Quadrature sum = stretch(edge, f, chord.first, nearest, allowed);
  sum += stretch(edge, f, nearest, chord.last, allowed);
  sum.value += beyond_cut(edge, t0, chord.first) + beyond_cut(edge, chord.last, t1);
  return sum;
}

// Beyond lies less than rounding.
double reach_of(const RadialKernel& kernel) {
  constexpr int kDoublings = 200;
  const double negligible = 0.1 * kEpsilon * std::abs(kernel.antiderivative(0.0));
  double reach_mm = kernel.shortest_length_mm;
  for (int i = 0; i < kDoublings && reach_mm < kernel.r_max_mm; ++i, reach_mm *= 2.0) {
    if (std::abs(kernel.antiderivative(reach_mm)) <= negligible &&
        std::abs(kernel.antiderivative(2.0 * reach_mm)) <= negligible)
      break;
  }
  return std::min(reach_mm, kernel.r_max_mm);
}

}  // namespace

RadialValue convolve_triangle_radial(const SurfaceTriangle& triangle, const Vec3d& point_mm,
                                     const RadialKernel& kernel, double tolerance, const Vec4d& unit) {
  assert(tolerance > 0.0 && kernel.shortest_length_mm > 0.0);
  const TriangleFrame frame(triangle);
  if (!frame.has_area()) return {};
  const double h = height_above(triangle, frame, point_mm);
  if (std::abs(h) >= kernel.r_max_mm) return {};
  const CutAntiderivative f(kernel);
  const Vec3d foot = point_mm - h * frame.normal;
  const PlaneLight light = light_about(foot, triangle, frame);
  const double at_foot = f(std::abs(h));
  double size_mm = point_mm.cwiseAbs().maxCoeff();
  for (const Vec3d& x : triangle.corners_mm) size_mm = std::max(size_mm, x.cwiseAbs().maxCoeff());
  const Vec4d summed = light.at_foot.cwiseAbs() + size_mm * light.gradient.rowwise().norm();
  const Vec4d rounding = kRoundings * kEpsilon * 2.0 * kPi * std::abs(at_foot) * summed;
  Quadrature sum;
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3d a = triangle.corners_mm[e] - foot;
    const Vec3d b = triangle.corners_mm[(e + 1) % 3] - foot;
    const double p = a.dot(frame.outward[e]);
    const Edge edge{p,
                    h,
                    at_foot,
                    std::sqrt(h * h + p * p + kernel.shortest_length_mm * kernel.shortest_length_mm),
                    light.at_foot,
                    light.gradient * frame.outward[e]};
    sum += whole_edge(edge, f, kernel.r_max_mm, a.dot(frame.along[e]), b.dot(frame.along[e]),
                      tolerance * unit + rounding);
  }
  if (!sum.converged) {
    throw_run_error(
        "the quadrature along an edge does not reach {}: two rules still differ on the smallest part",
        tolerance);
  }
  return {sum.value, sum.difference + rounding};
}

RadialExactEngine::RadialExactEngine(const Surface& surface, double tolerance)
    : surface_(surface),
      tree_(surface),
      tolerance_(tolerance),
      unit_(Vec4d::Constant(surface.largest_irradiance())) {
  unit_[3] = 1.0;
}

RadialValue RadialExactEngine::convolve(const SurfacePoint& point, const RadialKernel& kernel) const {
  std::vector<std::uint32_t> near;
  tree_.find(point.position_mm, reach_of(kernel), point.component, near);
  RadialValue sum;
  for (const std::uint32_t t : near) {
    const RadialValue part =
        convolve_triangle_radial(surface_.triangles[t], point.position_mm, kernel, tolerance_, unit_);
    sum.value += part.value;
    sum.error += part.error;
  }
  return sum;
}

}  // namespace truescatter
