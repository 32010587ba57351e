#include "truth/exact.h"

#include <algorithm>
#include <boost/math/special_functions/owens_t.hpp>
#include <cmath>

#include "core/parallel.h"

namespace truescatter {
namespace {

// (1/2pi) atan(t/p) - T(|p|/s, t/p): the first edge integral's antiderivative for F(h) = -1/2pi. The angle is
// taken from the same quotient as Owen's T, so that the two cancel for a point on the edge (p = 0).
double angle_minus_owen(double p, double t, double std_dev) {
  if (p == 0.0) return 0.0;
  const double slope = t / p;
  return std::atan(slope) / (2.0 * kPi) - boost::math::owens_t(std::abs(p) / std_dev, slope);
}

}  // namespace

EdgeIntegrals edge_inside_exact(double p, double t0, double t1, double std_dev_mm, double at_foot) {
  const double scale = 1.0 / (std_dev_mm * std::sqrt(2.0));
  const double gauss_p = std::exp(-0.5 * (p / std_dev_mm) * (p / std_dev_mm));
  EdgeIntegrals result;
  result.radial = at_foot * (angle_minus_owen(p, t1, std_dev_mm) - angle_minus_owen(p, t0, std_dev_mm));
  result.line = -at_foot * gauss_p * std_dev_mm / (2.0 * kPi) * std::sqrt(kPi / 2.0) *
                (std::erf(t1 * scale) - std::erf(t0 * scale));
  return result;
}

Vec4d convolve_triangle_exact(const SurfaceTriangle& triangle, const Vec3d& point_mm,
                              const TruthLayer& layer) {
  return convolve_inner_part(triangle, TriangleFrame(triangle), point_mm, layer,
                             [&](double p, double t0, double t1, double at_foot) {
                               return edge_inside_exact(p, t0, t1, layer.std_dev_mm, at_foot);
                             });
}

Vec4d ExactEngine::convolve(const SurfacePoint& point, const TruthLayer& layer) const {
  const double radius_mm = std::min(layer.r_max_mm, search_std_devs_ * layer.std_dev_mm);
  std::vector<std::uint32_t> near;
  tree_.find(point.position_mm, radius_mm, point.component, near);
  Vec4d sum = Vec4d::Zero();
  for (const std::uint32_t t : near)
    sum += convolve_triangle_exact(surface_.triangles[t], point.position_mm, layer);
  return sum;
}

TruthValues ExactEngine::convolve(std::span<const SurfacePoint> points,
                                  std::span<const TruthLayer> layers) const {
  TruthValues values(layers.size(), std::vector<Vec4d>(points.size(), Vec4d::Zero()));
  parallel_for(points.size(), [&](std::size_t i) {
    for (std::size_t l = 0; l < layers.size(); ++l) values[l][i] = convolve(points[i], layers[l]);
  });
  return values;
}

}  // namespace truescatter
