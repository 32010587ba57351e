#pragma once

#include <algorithm>
#include <cmath>

#include "truth/surface.h"

namespace truescatter {

// The two integrals of DESIGN section 1 along a piece of an edge, at signed distance p from the foot of the
// perpendicular, from arc length t0 to t1, for F(r) = -exp(-r^2 / 2s^2) / 2 pi and the point at height h.
struct EdgeIntegrals {
  double radial = 0.0;  // int (F(r) - F(h)) p / (p^2 + t^2) dt
  double line = 0.0;    // int F(r) dt
};

inline EdgeIntegrals operator+(const EdgeIntegrals& a, const EdgeIntegrals& b) {
  return {a.radial + b.radial, a.line + b.line};
}

// Beyond the cut-off F stands at F(r_max) = -at_cut / 2 pi; at_foot = exp(-h^2 / 2s^2).
inline EdgeIntegrals edge_beyond_cut(double p, double t0, double t1, double at_foot, double at_cut) {
  if (t1 <= t0) return {};
  const double angle = p == 0.0 ? 0.0 : std::atan(t1 / p) - std::atan(t0 / p);
  return {(at_foot - at_cut) * angle / (2.0 * kPi), -at_cut / (2.0 * kPi) * (t1 - t0)};
}

// A whole edge: `inside(p, t0, t1, at_foot)` gives the integrals where r < r_max.
template <typename Inside>
EdgeIntegrals integrate_edge(double p, double t0, double t1, double h, const TruthLayer& layer,
                             double at_foot, const Inside& inside) {
  if (!std::isfinite(layer.r_max_mm)) return inside(p, t0, t1, at_foot);
  const double cut_in_std_devs = layer.r_max_mm / layer.std_dev_mm;
  const double at_cut = std::exp(-0.5 * cut_in_std_devs * cut_in_std_devs);
  const double half_chord2 = layer.r_max_mm * layer.r_max_mm - h * h - p * p;
  if (half_chord2 <= 0.0) return edge_beyond_cut(p, t0, t1, at_foot, at_cut);
  const double half_chord = std::sqrt(half_chord2);
  const double c0 = std::clamp(-half_chord, t0, t1);
  const double c1 = std::clamp(half_chord, t0, t1);
  EdgeIntegrals sum =
      edge_beyond_cut(p, t0, c0, at_foot, at_cut) + edge_beyond_cut(p, c1, t1, at_foot, at_cut);
  if (c1 > c0) sum = sum + inside(p, c0, c1, at_foot);
  return sum;
}

// The convolution of one triangle as a sum over its edges: (M_r, M_g, M_b, m). A triangle without area
// gives 0.
template <typename Inside>
Vec4d convolve_triangle_by_edges(const SurfaceTriangle& triangle, const Vec3d& point_mm,
                                 const TruthLayer& layer, const Inside& inside) {
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
        integrate_edge(a.dot(outward), a.dot(along), b.dot(along), h, layer, at_foot, inside);
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

}  // namespace truescatter
