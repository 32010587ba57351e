#pragma once

#include "composite/beckmann.h"
#include "core/image.h"
#include "core/vec.h"

namespace truescatter {

// Schlick's approximation of Fresnel's reflectance, F0 + (1 - F0) (1 - cos)^5; `cosine` in [0, 1].
double schlick_fresnel(double cosine, double f0);

// Reflectance of skin at normal incidence, an index of refraction of 1.4 (d'Eon & Luebke 2007).
inline constexpr double kSkinF0 = 0.028;

// The specular BRDF of Kelemen & Szirmay-Kalos 2001 (1/sr) for unit vectors, at full intensity (rho_s = 1):
//
//   f = D(N.H, m) F(V.H) / (h.h),  h = L + V, not made unit length (h.h = 4 (V.H)^2), H = h / |h|;
//
// 0 where N.L <= 0 or N.H <= 0. Never infinite: h.h is not taken below 1e-6, where L is opposite to V to a
// thousandth.
double kelemen_specular(const Vec3d& normal, const Vec3d& light, const Vec3d& view, double m, double f0);

// Integrals of f (N.L) p(L) over the directions L above the surface, seen at N.V = n_v: p = 1 (the lobe's
// hemispherical reflectance), and the moments of L = (x, y, n), x the way in which V leans from N and n along
// N. Those of y, xy and yn vanish, and the one of yy is albedo - xx - nn.
struct SpecularMoments {
  double albedo = 0.0;
  double x = 0.0;
  double n = 0.0;
  double xx = 0.0;
  double nn = 0.0;
  double xn = 0.0;
};

// With the lobe's own distribution of H as variable, D cos(alpha) dH = dt dphi / (2 pi), tan^2(alpha) = -m^2
// ln(1 - t), and dL = 4 (V.H) dH, the integrand is F (N.L) / ((V.H) (N.H)) p, which is at most 2: so the
// reflectance is below 1 wherever F is, down to grazing. The midpoint rule over `steps` x `steps`; 96 is good
// to 1e-4.
SpecularMoments specular_moments(double n_v, double m, double f0, int steps = 96);

// The moments over n_v (columns, 0 to 1) and ln m (rows, as BeckmannTable has them), values at texels'
// centres, for a bilinear reading: (albedo, x, n, xx) and (nn, xn, 0, 0).
struct MomentTables {
  Image first;
  Image second;
};
MomentTables make_moment_tables(double f0);

}  // namespace truescatter
