#pragma once

#include <array>
#include <vector>

#include "profile/image_sources.h"
#include "profile/profile.h"

namespace truescatter {

// A profile of three channels as sum_i w_i G(v_i, r): variances shared by the channels, weights of either
// sign.
struct GaussianMixture {
  std::vector<GaussianLevel> levels;  // variances ascending
  // Per channel, a bound on int_0^inf |f - mixture| 2 pi r dr. It bounds the error of every convolution with
  // irradiance in [0, 1] over a plane; over a surface, times the most area that a shell around the point has
  // in units of a plane's.
  Vec3d error_bound = Vec3d::Zero();
};

// The image sources as a mixture of Gaussians whose error_bound is at most `tolerance` (1e-12 to 0.1): the
// materials take 9 to 27 Gaussians for 1e-4 and 16 to 43 for 1e-7. Any engine for Gaussians then gives the
// profile's own truth, on either metric.
//
// exp(-s d) / d = 2 / sqrt(pi) int_0^inf exp(-d^2 t^2 - s^2 / 4 t^2) dt, and z (1 + s d) exp(-s d) / d^3 is
// minus its derivative by z. With d^2 = r^2 + z^2 and t = exp(u) the integrand is, for each u, a Gaussian in
// r of variance exp(-2u) / 2, and the trapezoid rule in u converges exponentially: for an integrand that is
// analytic for |Im u| < a, and there of L1 norm N(a) at most on every line, its error is at most
// 2 N(a) / (exp(2 pi a / step) - 1) (Trefethen & Weideman 2014, theorem 5.1). With the norm above taken
// inside the integral over u, and c = cos 2a,
//
//   N(a) <= 2 pi c^(-3/2) sum over sources of (flux + fluence / s) exp(-c s |z|),
//
// so the step follows from the tolerance. Nodes that are left out at either end add their weights, as each
// Gaussian has the norm 1.
//
// Throws Error (input) for a tolerance out of range, and for sources with fluence in a medium that does not
// absorb (s = 0), of which no Gaussian by itself has a finite norm.
GaussianMixture gaussian_mixture(const std::array<ImageSources, 3>& channels, double tolerance);

}  // namespace truescatter
