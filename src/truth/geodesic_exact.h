#pragma once

#include <span>

#include "truth/geodesic_surface.h"

namespace truescatter {

// The geodesic convolution to rounding: the certifier, slow.
//
// A face is covered by windows of the wave front, and a window owns the points that its paths reach first.
// Every part of a shortest path is a shortest path, so what a window owns is star-shaped about its (unfolded)
// pseudo-source: on the ray at angle theta it is an interval that ends where the face does or where another
// window's paths become the shorter ones, which is known in closed form (the two lengths differ by a monotone
// function along the ray). With d = offset + rho along the ray, the integral over what a window owns of a
// piece of surface is a sum over the piece's edges of
//
//   int [ i0 A(rho) + (g.u) B(rho) ] dtheta,   A = int_0^rho rho f(offset + rho) drho,  B = int_0^rho rho^2 f
//   drho,
//
// rho(theta) being the edge's distance, cut where the window ceases to own the ray and at r_max, and i0 + g.x
// the piece's irradiance about the pseudo-source: DESIGN section 1 with H = A. For a Gaussian A and B are
// closed, by erf; the integral over theta is adaptive Gauss-Kronrod quadrature of an integrand that is smooth
// except where the owner changes.
class GeodesicExactEngine {
 public:
  // `search_std_devs`: see ExactEngine.
  explicit GeodesicExactEngine(const GeodesicSurface& surface, double search_std_devs = 8.6)
      : surface_(surface), search_std_devs_(search_std_devs) {}

  // (M_r, M_g, M_b, m) of each layer; `field` is scratch, and one serves one thread.
  std::vector<Vec4d> convolve(GeodesicField& field, const GeodesicTarget& target,
                              std::span<const TruthLayer> layers) const;
  // Every layer at every point, in parallel: [layer][point].
  TruthValues convolve(std::span<const GeodesicTarget> targets, std::span<const TruthLayer> layers) const;

 private:
  const GeodesicSurface& surface_;
  double search_std_devs_;
};

}  // namespace truescatter
