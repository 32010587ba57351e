#pragma once

#include <functional>
#include <span>

#include "truth/cgal_geodesic.h"
#include "truth/geodesic_surface.h"

namespace truescatter {

// The distance along the surface from one point to x in the frame of a face. Where it is longer than the
// radius asked for, anything that is longer too. Serves one thread.
using DistanceTo = std::function<double(std::size_t face, const Vec2d& x)>;
// Makes it for a point and a radius. Serves any number of threads.
using DistanceFrom = std::function<DistanceTo(const GeodesicPoint& source, double radius_mm)>;

// By the windows that the other geodesic engines use. `mesh` must outlive the result, and all that it makes.
DistanceFrom distances_by_windows(const IntrinsicMesh& mesh);
// By CGAL, of the same mesh. Both must outlive the result, and all that it makes.
DistanceFrom distances_by_cgal(const IntrinsicMesh& mesh, const CgalGeodesics& geodesics);

// A second opinion of the geodesic truth: plain adaptive quadrature of G(s, d) I over every piece, that asks
// for nothing but distances d. It is not told where their kinks lie (cut loci). Slow.
//
// - A piece is cut in four until no edge is longer than s, nor than r_max / 4; then the part with the largest
//   error is cut, until the errors of all parts sum to at most `tolerance`. A part's error is the difference
//   of two product rules of Gauss and Legendre, of 5 x 5 and 8 x 8 nodes (or of 3 x 3 and 5 x 5, where they
//   agree to half the part's share of the tolerance by area).
// - Rules do not see a kink that only cuts off a corner. But where all paths come straight from one unfolded
//   source, distances at a part's corners and the middles of its sides fit that source. Where they fit none,
//   the part's error is its difference from a rule with nodes there, and falls as the square of the size.
// - A cut-off: along a face d changes by no more than the way, so of most parts one distance tells whether
//   they lie inside. In the others the rule's lines, which run from one corner to the opposite side, end
//   where d reaches r_max, found by bracketing. So a smooth part of the circle costs no accuracy.
// - Nothing beyond the distance where a plane's remaining mass is tolerance/100.
//
// Accuracy: `tolerance`, in units of the largest irradiance, and for the mass in units of 1; 1e-9 or more.
// A point takes up to seconds at 1e-8, and a tenth of that at 1e-6, if there are many cut loci within reach.
class GeodesicBruteEngine {
 public:
  GeodesicBruteEngine(const GeodesicSurface& surface, DistanceFrom distances, double tolerance);

  // (M_r, M_g, M_b, m) of each layer, as GeodesicExactEngine gives them. Throws Error (run) where the
  // tolerance is out of reach. Serves any number of threads.
  std::vector<Vec4d> convolve(const GeodesicTarget& target, std::span<const TruthLayer> layers) const;

 private:
  const GeodesicSurface& surface_;
  DistanceFrom distances_;
  double tolerance_;
  Vec4d unit_;  // of each entry's error
};

}  // namespace truescatter
