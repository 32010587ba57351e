#pragma once

#include "truth/surface.h"

namespace truescatter {

// A second opinion: plain adaptive quadrature of G(s, |x - x_o|) I(x) over every triangle, that shares
// neither the closed form nor the rules, bounds and search of the fast engine. Slow.
//
// - A triangle is cut in four (its longest edge halved, then that of both halves) until no edge is longer
// than
//   s, so that no rule can miss the Gaussian; then until two product rules of Gauss and Legendre on it, of
//   3 x 3 and 5 x 5 or of 5 x 5 and 8 x 8 nodes, agree. Their difference, which bounds the error of the
//   coarser, is taken for that of the finer, and is at most `tolerance` times the part's share of all area
//   in reach. So the differences sum to at most `tolerance`.
// - What the sphere of radius r_max cuts is cut on until the circle is a gentle arc in it (edges of at most a
//   quarter of its radius); there the inside is a polygon and slivers between chord and arc, which are smooth
//   maps of a square. The accuracy is that of the uncut integral.
// - Nothing beyond the distance where a plane's remaining mass is tolerance/100.
//
// Accuracy: `tolerance`, in units of the largest irradiance, and for the mass in units of 1; 1e-13 or more.
class BruteEngine {
 public:
  BruteEngine(const Surface& surface, double tolerance = 1e-10);

  // (M_r, M_g, M_b, m) as ExactEngine gives them. Throws Error (run) where the tolerance is out of reach.
  Vec4d convolve(const SurfacePoint& point, const TruthLayer& layer) const;

 private:
  const Surface& surface_;
  double tolerance_;
  Vec4d unit_;  // of each entry's error
};

}  // namespace truescatter
