#pragma once

#include <functional>
#include <limits>

#include "truth/surface.h"
#include "truth/triangle_tree.h"

namespace truescatter {

// Any radial kernel f(r) of one channel, by its antiderivative (a RadialProfile gives both).
struct RadialKernel {
  std::function<double(double r_mm)> antiderivative;  // F'(r) = r f(r), F -> 0 far away; r >= 0; no unit
  double shortest_length_mm = 0.0;                    // F changes over no shorter a length; > 0
  double r_max_mm = std::numeric_limits<double>::infinity();  // f is cut off there
};

// (M_r, M_g, M_b, m) of irradiance and of 1, and an estimate of each one's error that errs on the high side:
// the differences of the two quadrature rules, summed, and rounding.
struct RadialValue {
  Vec4d value = Vec4d::Zero();
  Vec4d error = Vec4d::Zero();
};

// The convolution of one triangle with the kernel, seen from `point_mm`: the boundary integrals of
// README, Definitions, for a general F,
//
//   sum over edges [ i0 int (F(r) - F(h)) p / (p^2 + t^2) dt + (g.n) int F(r) dt ],
//
// by adaptive Gauss-Kronrod quadrature along each edge, in w with t = q sinh w, q^2 = h^2 + p^2 + (shortest
// length)^2: in w the kernel varies over lengths of 1 wherever the edge runs. A cut-off takes
// F(min(r, r_max)), and edges are divided where they cross the sphere. `tolerance`: what the two rules may
// differ by on a stretch of an edge, in units of the light (of 1 for the mass) times `unit`. Throws Error
// (run) where they do not come to agree.
//
// Far triangles cancel, and so does the light on needles, over whose width irradiance changes fast: `error`
// says by how much.
RadialValue convolve_triangle_radial(const SurfaceTriangle& triangle, const Vec3d& point_mm,
                                     const RadialKernel& kernel, double tolerance, const Vec4d& unit);

// The exact truth of a profile itself, of which a sum of Gaussians is a fit: convolve_triangle_radial over
// every triangle of the point's component where less than rounding lies beyond. Euclidean. Slow.
class RadialExactEngine {
 public:
  // `tolerance` for each stretch of an edge, in units of the largest irradiance.
  explicit RadialExactEngine(const Surface& surface, double tolerance = 1e-13);

  RadialValue convolve(const SurfacePoint& point, const RadialKernel& kernel) const;

 private:
  const Surface& surface_;
  TriangleTree tree_;
  double tolerance_;
  Vec4d unit_;
};

}  // namespace truescatter
