#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "truth/needle.h"
#include "truth/surface.h"

namespace truescatter {

// The two integrals of README, Definitions, along a piece of an edge, at signed distance p from the foot of
// the perpendicular, from arc length t0 to t1, for F(r) = -exp(-r^2 / 2s^2) / 2 pi and the point at height h.
struct EdgeIntegrals {
  double radial = 0.0;  // int (F(r) - F(h)) p / (p^2 + t^2) dt
  double line = 0.0;    // int F(r) dt
};

inline EdgeIntegrals operator+(const EdgeIntegrals& a, const EdgeIntegrals& b) {
  return {a.radial + b.radial, a.line + b.line};
}
inline EdgeIntegrals operator-(const EdgeIntegrals& a, const EdgeIntegrals& b) {
  return {a.radial - b.radial, a.line - b.line};
}

// Beyond the cut-off F stands at F(r_max) = -at_cut / 2 pi; at_foot = exp(-h^2 / 2s^2).
inline EdgeIntegrals edge_beyond_cut(double p, double t0, double t1, double at_foot, double at_cut) {
  if (t1 <= t0) return {};
  // atan(t1 / p) - atan(t0 / p)
  const double angle = p == 0.0 ? 0.0 : std::atan2(p * (t1 - t0), p * p + t0 * t1);
  return {(at_foot - at_cut) * angle / (2.0 * kPi), -at_cut / (2.0 * kPi) * (t1 - t0)};
}

// The part of an edge inside the sphere of radius r_max: between the arc lengths [first, last].
struct Chord {
  double first;
  double last;
};
inline Chord chord_inside(double p, double t0, double t1, double h, double r_max_mm) {
  const double half2 = r_max_mm * r_max_mm - h * h - p * p;
  const double half = half2 > 0.0 ? std::sqrt(half2) : 0.0;
  // Without a chord, the foot on the edge divides the outside in two; nothing is inside.
  return {std::clamp(-half, t0, t1), std::clamp(half, t0, t1)};
}

// A whole edge for the Gaussian cut off at r_max: F(min(r, r_max)). `inside(p, t0, t1, at_foot)` gives the
// integrals where r < r_max.
template <typename Inside>
EdgeIntegrals edge_of_inner_part(double p, double t0, double t1, double h, double r_max_mm, double at_foot,
                                 double at_cut, const Inside& inside) {
  const Chord chord = chord_inside(p, t0, t1, h, r_max_mm);
  EdgeIntegrals sum = edge_beyond_cut(p, t0, chord.first, at_foot, at_cut) +
                      edge_beyond_cut(p, chord.last, t1, at_foot, at_cut);
  if (chord.last > chord.first) sum = sum + inside(p, chord.first, chord.last, at_foot);
  return sum;
}

// A whole edge for the Gaussian beyond r_max: F(max(r, r_max)), which at the foot is -at_cut / 2 pi.
// `outside(p, t0, t1, h, at_cut)` gives the integrals where r > r_max, with that value in place of F(h).
template <typename Outside>
EdgeIntegrals edge_of_outer_part(double p, double t0, double t1, double h, double r_max_mm, double at_cut,
                                 const Outside& outside) {
  const Chord chord = chord_inside(p, t0, t1, h, r_max_mm);
  EdgeIntegrals sum{0.0, -at_cut / (2.0 * kPi) * (chord.last - chord.first)};
  if (chord.first > t0) sum = sum + outside(p, t0, chord.first, h, at_cut);
  if (t1 > chord.last) sum = sum + outside(p, chord.last, t1, h, at_cut);
  return sum;
}

// A triangle's directions, which do not depend on the point.
struct TriangleFrame {
  Vec3d normal = Vec3d::Zero();  // zero for a triangle without area
  std::array<Vec3d, 3> along;    // of the edge from corner e to e + 1; zero for an edge without length
  std::array<Vec3d, 3> outward;
  std::array<Vec3d, 3> gradient;  // of the barycentric coordinates
  double smallest_height_mm = 0.0;

  explicit TriangleFrame(const SurfaceTriangle& triangle) {
    const auto& x = triangle.corners_mm;
    const Vec3d cross = (x[1] - x[0]).cross(x[2] - x[0]);
    const double twice_area = cross.norm();
    if (!(twice_area > 0.0)) return;
    normal = cross / twice_area;
    const double longest = std::max({(x[1] - x[0]).norm(), (x[2] - x[1]).norm(), (x[0] - x[2]).norm()});
    smallest_height_mm = twice_area / longest;
    for (std::size_t e = 0; e < 3; ++e) {
      const Vec3d edge = x[(e + 1) % 3] - x[e];
      const double length = edge.norm();
      along[e] = length > 0.0 ? Vec3d(edge / length) : Vec3d(Vec3d::Zero());
      outward[e] = along[e].cross(normal);
      gradient[e] = normal.cross(x[(e + 2) % 3] - x[(e + 1) % 3]) / twice_area;
    }
  }

  bool has_area() const { return normal != Vec3d::Zero(); }
};

// The convolution of one triangle as a sum over its edges: (M_r, M_g, M_b, m). `edge(p, t0, t1)` gives the
// integrals along a whole edge. The triangle has an area.
template <typename Edge>
Vec4d convolve_triangle_by_edges(const SurfaceTriangle& triangle, const TriangleFrame& frame,
                                 const Vec3d& point_mm, double h, const Edge& edge) {
  const auto& x = triangle.corners_mm;
  const Vec3d foot = point_mm - h * frame.normal;
  double radial = 0.0;
  Vec3d line = Vec3d::Zero();  // sum over edges of n int F dt
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3d a = x[e] - foot;
    const Vec3d b = x[(e + 1) % 3] - foot;
    const EdgeIntegrals sum = edge(a.dot(frame.outward[e]), a.dot(frame.along[e]), b.dot(frame.along[e]));
    radial += sum.radial;
    line += sum.line * frame.outward[e];
  }
  // Barycentric coordinates of the foot and their gradients give i0 and g for each channel.
  Vec4d result(0.0, 0.0, 0.0, radial);
  for (std::size_t i = 0; i < 3; ++i) {
    const double at_origin = (foot - x[(i + 1) % 3]).dot(frame.gradient[i]);
    result.head<3>() += triangle.irradiance[i] * (at_origin * radial + frame.gradient[i].dot(line));
  }
  return result;
}

inline double height_above(const SurfaceTriangle& triangle, const TriangleFrame& frame,
                           const Vec3d& point_mm) {
  return (point_mm - triangle.corners_mm[0]).dot(frame.normal);
}

inline double gauss_at(double r, double std_dev_mm) {
  return std::exp(-0.5 * (r / std_dev_mm) * (r / std_dev_mm));
}

// Whether the boundary formula would lose digits: over the width of a needle, irradiance changes so fast that
// the gradient's term is a small difference of large ones, off by some 1e-15 of s over the width.
inline bool is_needle(const TriangleFrame& frame, const TruthLayer& layer) {
  return frame.smallest_height_mm < (std::isfinite(layer.r_max_mm) ? 1e-3 : 1e-2) * layer.std_dev_mm;
}

// The convolution of one triangle with the Gaussian where r < r_max; `inside` as above.
template <typename Inside>
Vec4d convolve_inner_part(const SurfaceTriangle& triangle, const TriangleFrame& frame, const Vec3d& point_mm,
                          const TruthLayer& layer, const Inside& inside) {
  if (!frame.has_area()) return Vec4d::Zero();
  if (is_needle(frame, layer)) return convolve_needle(triangle, point_mm, layer);
  const double h = height_above(triangle, frame, point_mm);
  if (std::abs(h) >= layer.r_max_mm) return Vec4d::Zero();
  const double at_foot = gauss_at(h, layer.std_dev_mm);
  if (!std::isfinite(layer.r_max_mm)) {
    return convolve_triangle_by_edges(triangle, frame, point_mm, h, [&](double p, double t0, double t1) {
      return t1 > t0 ? inside(p, t0, t1, at_foot) : EdgeIntegrals{};
    });
  }
  const double at_cut = gauss_at(layer.r_max_mm, layer.std_dev_mm);
  return convolve_triangle_by_edges(triangle, frame, point_mm, h, [&](double p, double t0, double t1) {
    return edge_of_inner_part(p, t0, t1, h, layer.r_max_mm, at_foot, at_cut, inside);
  });
}

// The convolution of one triangle with the Gaussian where r > r_max; `outside` as above. For |h| >= r_max
// that is the whole triangle.
template <typename Outside>
Vec4d convolve_outer_part(const SurfaceTriangle& triangle, const TriangleFrame& frame, const Vec3d& point_mm,
                          const TruthLayer& layer, const Outside& outside) {
  if (!frame.has_area()) return Vec4d::Zero();
  if (is_needle(frame, layer)) {
    return convolve_needle(triangle, point_mm, {layer.std_dev_mm}) -
           convolve_needle(triangle, point_mm, layer);
  }
  const double h = height_above(triangle, frame, point_mm);
  const double foot_r = std::max(std::abs(h), layer.r_max_mm);
  const double at_cut = gauss_at(foot_r, layer.std_dev_mm);
  return convolve_triangle_by_edges(triangle, frame, point_mm, h, [&](double p, double t0, double t1) {
    return edge_of_outer_part(p, t0, t1, h, layer.r_max_mm, at_cut, outside);
  });
}

}  // namespace truescatter
