#pragma once

#include <functional>
#include <span>
#include <vector>

#include "truth/layer_plan.h"
#include "truth/triangle_tree.h"

namespace truescatter {

// The engine that a run uses for every pixel: the same integrals as ExactEngine to an absolute error of
// `tolerance` times the largest irradiance (and `tolerance` for the mass).
//
// How the tolerance is spent:
// - Tail: nothing beyond the radius where a plane's remaining mass is tolerance/10.
// - Quadrature: each triangle takes the cheapest rule, after a uniform split if need be, whose errors over a
//   plane sum to at most 0.6 tolerance (gaussian_error).
// - Grid: where many points meet many nodes, the nodes' sums go by way of a lattice (add_gauss_sums), at an
//   error of at most tolerance/10. Whether they do is a matter of cost alone.
// - A cut-off at r_max is the uncut sum by way of the grid less what lies beyond r_max, which is little and
//   needs no more relative accuracy than that; or, where the grid does not pay, the sum over what lies
//   inside.
// - Triangles too large for quadrature, and those which the cut-off sphere crosses, take the boundary formula.
// - For a tolerance of 1e-5 or more sums run in single precision (about 1e-6) and the formula takes Owen's T
//   from a table (about 1e-8); else all is in double precision.
//
// Neighbouring points share their search for triangles and the nodes (add_cluster_sums). The result is
// bitwise the same for any number of jobs.
class FastEngine {
 public:
  FastEngine(const Surface& surface, double tolerance);

  double tolerance() const { return tolerance_; }

  // Every layer at every point: [layer][point]. `advance`, if set, is told how many of the
  // points x layers are newly done; it is called from any thread.
  TruthValues convolve(std::span<const SurfacePoint> points, std::span<const TruthLayer> layers,
                       const std::function<void(std::size_t)>& advance = {}) const;

  // An upper bound, relative to the largest irradiance, of the light beyond the search radius and the
  // lattice's reach, for a surface that has at most twice the area of its tangent plane in any shell around
  // the point.
  double tail_bound() const;

 private:
  const Surface& surface_;
  TriangleTree tree_;
  std::vector<TriangleBounds> bounds_;  // by triangle
  double tolerance_;
};

}  // namespace truescatter
