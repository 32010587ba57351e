#pragma once

#include "truth/surface.h"

namespace truescatter {

// The convolution of one triangle as ExactEngine gives it, for a triangle much thinner than the Gaussian is
// wide (its smallest height at most s/100): by Gauss-Legendre quadrature, 8 nodes for each s along the
// triangle and 3 across it. For such a triangle that is exact to rounding of a value which is itself small,
// whereas the boundary formula (edge_formula.h) loses what irradiance gains over the width.
//
// A cut-off at r_max bounds the quadrature across, and divides that along where the cut circle crosses an
// edge. At the circle's ends a square root remains, which costs up to (height/s)^3 / 1000.
Vec4d convolve_needle(const SurfaceTriangle& triangle, const Vec3d& point_mm, const TruthLayer& layer);

}  // namespace truescatter
