#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// A homogeneous scattering medium under air, one channel.
struct Medium {
  double sigma_a_per_mm = 0.0;        // absorption; >= 0
  double sigma_s_prime_per_mm = 0.0;  // reduced scattering; > 0
  double eta = 1.3;                   // relative index of refraction; > 1

  double sigma_t_prime_per_mm() const { return sigma_s_prime_per_mm + sigma_a_per_mm; }
  double reduced_albedo() const { return sigma_s_prime_per_mm / sigma_t_prime_per_mm(); }
  // l = 1 / sigma_t', the depth of the real source.
  double mean_free_path_mm() const { return 1.0 / sigma_t_prime_per_mm(); }
};

// Throws Error (input) that names the coefficient which is out of range or not finite, its value and the
// rule. Coefficients are at most 1e9 / mm, and sigma_s' is 1e-9 / mm at least: no medium is beyond, and
// squares keep their digits.
void require_valid(const Medium& medium);

// Throws Error (input) that calls the slab or layer `what` where it is no thicker than a mean free path:
// diffusion theory has no valid answer then (transmittance would be negative).
void require_thick(const Medium& medium, double thickness_mm, std::string_view what);

// A = (1 + Fdr) / (1 - Fdr) of a relative index, in 2 A D: where the fluence is extrapolated to 0.
double extrapolation_factor(double diffuse_reflectance);

// The same for three channels, by name.
struct Material {
  std::string name;
  Vec3d sigma_s_prime_per_mm;
  Vec3d sigma_a_per_mm;
  double eta;

  Medium channel(int c) const { return {sigma_a_per_mm[c], sigma_s_prime_per_mm[c], eta}; }
};

// As measured by Jensen et al. 2001, table 1: marble (eta 1.5); skin1, skin2, whole-milk, skim-milk, apple,
// cream, ketchup (eta 1.3).
const std::vector<Material>& materials();

// Angular moments of the Fresnel reflectance R, for unpolarised light that meets the surface from inside at
// cosine mu: 2 C1 = 2 int_0^1 R mu dmu, 3 C2 = 3 int_0^1 R mu^2 dmu (d'Eon 2012).
struct FresnelMoments {
  double two_c1;
  double three_c2;
};

// By quadrature, to rounding; eta > 1. (d'Eon's polynomials are good to 1e-3, and to nothing outside the
// range that they were fitted in.)
FresnelMoments internal_fresnel_moments(double eta);

// Fdr, the diffuse reflectance inside as the classical dipole approximates it for eta > 1 (Jensen et al.
// 2001): -1.440 / eta^2 + 0.710 / eta + 0.668 + 0.0636 eta.
double classical_diffuse_reflectance(double eta);

}  // namespace truescatter
