#pragma once

#include <span>

#include "truth/edge_formula.h"
#include "truth/surface.h"
#include "truth/triangle_tree.h"

namespace truescatter {

// The convolution of one triangle with one Gaussian, seen from `point_mm`: (M_r, M_g, M_b, m). Closed form
// of README, Definitions: with F(r) = -s^2 G(s, r) and the foot of the perpendicular as origin,
//
//   integral of G I dA = sum over edges [ i0 int (F(r) - F(h)) p / (p^2 + t^2) dt + (g.n) int F(r) dt ].
//
// The first integral is Owen's T function, the second an error function. A finite r_max replaces F(r) by
// F(min(r, r_max)), split where the edge crosses the sphere. Accurate to rounding in units of the largest
// irradiance (absolute: far triangles cancel). A triangle without area gives 0.
Vec4d convolve_triangle_exact(const SurfaceTriangle& triangle, const Vec3d& point_mm,
                              const TruthLayer& layer);

// The integrals along a piece of an edge inside the cut-off, in closed form: Owen's T and erf.
EdgeIntegrals edge_inside_exact(double p, double t0, double t1, double std_dev_mm, double at_foot);

// The exact engine: the closed form over every triangle within `search_std_devs`. By default every one that
// matters to rounding: beyond 8.6 standard deviations lies exp(-8.6^2 / 2) = 9e-17 of a plane's mass. The
// certifier; slow.
class ExactEngine {
 public:
  explicit ExactEngine(const Surface& surface, double search_std_devs = 8.6)
      : surface_(surface), tree_(surface), search_std_devs_(search_std_devs) {}

  Vec4d convolve(const SurfacePoint& point, const TruthLayer& layer) const;
  // Every layer at every point, in parallel: [layer][point].
  TruthValues convolve(std::span<const SurfacePoint> points, std::span<const TruthLayer> layers) const;

 private:
  const Surface& surface_;
  TriangleTree tree_;
  double search_std_devs_;
};

}  // namespace truescatter
