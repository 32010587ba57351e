#pragma once

#include <functional>
#include <span>

#include "truth/surface.h"
#include "truth/triangle_tree.h"

namespace truescatter {

// The engine that a run uses for every pixel: the same integrals as ExactEngine to an absolute error of
// `tolerance` times the largest irradiance (and `tolerance` for the mass).
//
// How the tolerance is spent:
// - Tail: nothing beyond the radius where a plane's remaining mass is tolerance/10.
// - Quadrature: a rule of degree d integrates (Taylor polynomial of degree d-1 of G) * (linear I) exactly.
// What
//   is left of G is at most |x - c|^d max|D^d G| / d! around the centroid c, so a triangle whose corners lie
//   within x standard deviations of c errs by at most A |I| C_d x^d s^d max|D^d G| / d!, with C_d the rule's
//   `remainder`. Summed over a plane, s^d integral |D^d G| <= sqrt(d!) (the directional derivative is a
//   Hermite function He_d, and E|He_d| <= sqrt(E He_d^2) = sqrt(d!)), hence the total is at most C_d x^d /
//   sqrt(d!). Each triangle takes the cheapest rule, after a uniform split if need be, that keeps this bound
//   below 0.6 tolerance.
// - Triangles too large for that, and those which the cut-off sphere crosses, take the
//   boundary formula, each edge by Gauss-Legendre quadrature where that is good to 1e-7, else in closed form.
// - Sums run in single precision (about 1e-6) for a tolerance of 1e-5 or more, else in double.
//
// Work is shared: points are clustered in space, and a cluster much smaller than the Gaussian gathers its
// triangles and quadrature nodes once. The result is bitwise the same for any number of jobs.
class FastEngine {
 public:
  FastEngine(const Surface& surface, double tolerance);

  double tolerance() const { return tolerance_; }

  // Every layer at every point: [layer][point]. `advance`, if set, is told how many of the
  // points x layers are newly done; it is called from any thread.
  TruthValues convolve(std::span<const SurfacePoint> points, std::span<const TruthLayer> layers,
                       const std::function<void(std::size_t)>& advance = {}) const;

  // An upper bound, relative to the largest irradiance, of the light beyond the search radius, for a
  // surface that has at most twice the area of its tangent plane in any shell around the point.
  double tail_bound() const;

 private:
  const Surface& surface_;
  TriangleTree tree_;
  double tolerance_;
};

}  // namespace truescatter
