#pragma once

#include <vector>

#include "profile/medium.h"
#include "profile/radial_profile.h"

namespace truescatter {

// A point source inside the medium and its image of the opposite sign, at signed depths below the surface at
// which the light leaves.
struct SourcePair {
  double real_mm;
  double virtual_mm;
};

// The profiles of diffusion theory with image sources. With d_z(r) = sqrt(r^2 + z^2) and s = s_tr,
//
//   f(r) = sum over pairs of  flux [g(z_real) - g(z_virtual)] + fluence [e(z_real) - e(z_virtual)]
//   g(z) = z (1 + s d_z) exp(-s d_z) / d_z^3,  e(z) = exp(-s d_z) / d_z,
//
// of which r f has the antiderivative
//
//   F(r) = -sum of  flux [z exp(-s d_z) / d_z] + fluence [exp(-s d_z) / s],  each real less virtual,
//
// since d' = r/d. One channel; a RadialProfile.
class ImageSources {
 public:
  // Depths are not 0; s_tr_per_mm >= 0.
  ImageSources(double s_tr_per_mm, double flux, double fluence_per_mm, std::vector<SourcePair> pairs);

  double value(double r_mm) const;
  double antiderivative(double r_mm) const;
  double albedo() const;
  double shortest_length_mm() const;

  double s_tr_per_mm() const { return s_tr_; }
  double flux() const { return flux_; }
  double fluence_per_mm() const { return fluence_; }
  const std::vector<SourcePair>& pairs() const { return pairs_; }

 private:
  double s_tr_;
  double flux_;
  double fluence_;
  std::vector<SourcePair> pairs_;
};

static_assert(RadialProfile<ImageSources>);

// The classical dipole (Jensen et al. 2001, with the second term as in Donner & Jensen 2005: the original
// carries a 1/sigma_t' too much there). Each of these throws what require_valid throws.
ImageSources classical_dipole(const Medium& medium);

// The better dipole (d'Eon 2012): Grosjean's diffusion coefficient, exitance from flux and fluence, and
// moments of *internal* reflection. By default the exact ones.
ImageSources better_dipole(const Medium& medium);
ImageSources better_dipole(const Medium& medium, const FresnelMoments& moments);

enum class SlabSide { lit, far };

// The multipole (Donner & Jensen 2005) of a slab in air: what it sends back (lit side) or lets through (far
// side). So many images that those left out hold less than rounding, 20 pairs on either side at least.
// Throws Error (input) for a slab that is no thicker than a mean free path, for which there is no valid
// answer (transmittance would be negative), and for one that absorbs so little that more than 10000 images a
// side would matter (none at all: infinitely many).
ImageSources multipole(const Medium& medium, double thickness_mm, SlabSide side);

}  // namespace truescatter
