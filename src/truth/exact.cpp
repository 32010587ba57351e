#include "truth/exact.h"

#include <algorithm>
#include <boost/math/special_functions/owens_t.hpp>
#include <cmath>

#include "core/parallel.h"

namespace truescatter {
namespace {

// Beyond 8.6 standard deviations lies exp(-8.6^2 / 2) = 9e-17 of a Gaussian's mass.
constexpr double kSearchRadiusStdDevs = 8.6;

// (1/2pi) atan(t/p) - T(|p|/s, t/p): the first edge integral's antiderivative for F(h) = -1/2pi. The angle is
// taken from the same quotient as Owen's T, so that the two cancel for a point on the edge (p = 0).
double angle_minus_owen(double p, double t, double std_dev) {
  if (p == 0.0) return 0.0;
  const double slope = t / p;
  return std::atan(slope) / (2.0 * kPi) - boost::math::owens_t(std::abs(p) / std_dev, slope);
}

double angle_over_two_pi(double p, double t) { return p == 0.0 ? 0.0 : std::atan(t / p) / (2.0 * kPi); }

struct EdgeIntegrals {
  double radial = 0.0;  // int (F(r) - F(h)) p / (p^2 + t^2) dt
  double line = 0.0;    // int F(r) dt
};

// The part of an edge from t0 to t1 inside the cut-off; `at_foot` is exp(-h^2 / 2s^2).
EdgeIntegrals inside_cut(double p, double t0, double t1, double std_dev, double at_foot) {
  const double scale = 1.0 / (std_dev * std::sqrt(2.0));
  const double gauss_p = std::exp(-0.5 * (p / std_dev) * (p / std_dev));
  EdgeIntegrals result;
  result.radial = at_foot * (angle_minus_owen(p, t1, std_dev) - angle_minus_owen(p, t0, std_dev));
  result.line = -at_foot * gauss_p * std_dev / (2.0 * kPi) * std::sqrt(kPi / 2.0) *
                (std::erf(t1 * scale) - std::erf(t0 * scale));
  return result;
}

// The part of an edge beyond the cut-off, where F stands at F(r_max) = -at_cut / 2 pi.
EdgeIntegrals beyond_cut(double p, double t0, double t1, double at_foot, double at_cut) {
  EdgeIntegrals result;
  result.radial = (at_foot - at_cut) * (angle_over_two_pi(p, t1) - angle_over_two_pi(p, t0));
  result.line = -at_cut / (2.0 * kPi) * (t1 - t0);
  return result;
}

EdgeIntegrals operator+(const EdgeIntegrals& a, const EdgeIntegrals& b) {
  return {a.radial + b.radial, a.line + b.line};
}

EdgeIntegrals integrate_edge(double p, double t0, double t1, double h, const TruthLayer& layer, double at_foot) {
  const double s = layer.std_dev_mm;
  if (!std::isfinite(layer.r_max_mm)) return inside_cut(p, t0, t1, s, at_foot);
  const double at_cut = std::exp(-0.5 * (layer.r_max_mm / s) * (layer.r_max_mm / s));
  const double half_chord2 = layer.r_max_mm * layer.r_max_mm - h * h - p * p;
  if (half_chord2 <= 0.0) return beyond_cut(p, t0, t1, at_foot, at_cut);
  const double half_chord = std::sqrt(half_chord2);
  const double c0 = std::clamp(-half_chord, t0, t1);
  const double c1 = std::clamp(half_chord, t0, t1);
  return beyond_cut(p, t0, c0, at_foot, at_cut) + inside_cut(p, c0, c1, s, at_foot) +
         beyond_cut(p, c1, t1, at_foot, at_cut);
}

}  // namespace

Vec4d convolve_triangle_exact(const SurfaceTriangle& triangle, const Vec3d& point_mm, const TruthLayer& layer) {
  const auto& x = triangle.corners_mm;
  const Vec3d cross = (x[1] - x[0]).cross(x[2] - x[0]);
  const double twice_area = cross.norm();
  if (!(twice_area > 0.0)) return Vec4d::Zero();
  const Vec3d normal = cross / twice_area;
  const double h = (point_mm - x[0]).dot(normal);
  if (std::abs(h) >= layer.r_max_mm) return Vec4d::Zero();
  const Vec3d foot = point_mm - h * normal;
  const double at_foot = std::exp(-0.5 * (h / layer.std_dev_mm) * (h / layer.std_dev_mm));

  double radial = 0.0;
  Vec3d line = Vec3d::Zero();  // sum over edges of n int F dt
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3d a = x[e] - foot;
    const Vec3d b = x[(e + 1) % 3] - foot;
    const double length = (b - a).norm();
    if (!(length > 0.0)) continue;
    const Vec3d along = (b - a) / length;
    const Vec3d outward = along.cross(normal);
    const EdgeIntegrals edge =
        integrate_edge(a.dot(outward), a.dot(along), b.dot(along), h, layer, at_foot);
    radial += edge.radial;
    line += edge.line * outward;
  }

  // Barycentric coordinates of the foot and their gradients give i0 and g for each channel.
  Vec4d result(0.0, 0.0, 0.0, radial);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d gradient = normal.cross(x[(i + 2) % 3] - x[(i + 1) % 3]) / twice_area;
    const double at_origin = (foot - x[(i + 1) % 3]).dot(gradient);
    result.head<3>() += triangle.irradiance[i] * (at_origin * radial + gradient.dot(line));
  }
  return result;
}

Vec4d ExactEngine::convolve(const SurfacePoint& point, const TruthLayer& layer) const {
  const double radius_mm = std::min(layer.r_max_mm, kSearchRadiusStdDevs * layer.std_dev_mm);
  std::vector<std::uint32_t> near;
  tree_.find(point.position_mm, radius_mm, point.component, near);
  Vec4d sum = Vec4d::Zero();
  for (const std::uint32_t t : near) sum += convolve_triangle_exact(surface_.triangles[t], point.position_mm, layer);
  return sum;
}

TruthValues ExactEngine::convolve(std::span<const SurfacePoint> points, std::span<const TruthLayer> layers) const {
  TruthValues values(layers.size(), std::vector<Vec4d>(points.size(), Vec4d::Zero()));
  parallel_for(points.size(), [&](std::size_t i) {
    for (std::size_t l = 0; l < layers.size(); ++l) values[l][i] = convolve(points[i], layers[l]);
  });
  return values;
}

}  // namespace truescatter
