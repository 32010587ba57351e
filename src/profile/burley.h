#pragma once

#include "profile/fit_target.h"
#include "profile/medium.h"
#include "profile/radial_profile.h"

namespace truescatter {

// Burley's normalised diffusion (Christensen & Burley 2015):
//
//   f(r) = A (exp(-r/d) + exp(-r/3d)) / (8 pi d r),   F(r) = -A (exp(-r/d) + 3 exp(-r/3d)) / 8 pi,
//
// F' = r f. It goes as 1/r at 0, so int r f^2 dr is not finite. One channel; a RadialProfile.
class Burley {
 public:
  // The albedo is 0 to 1, the length d above 0; throws Error (input) otherwise.
  Burley(double albedo, double d_mm);

  double value(double r_mm) const;  // r > 0
  double antiderivative(double r_mm) const;
  double albedo() const { return albedo_; }
  double shortest_length_mm() const { return d_mm_; }

 private:
  double albedo_;
  double d_mm_;
};

static_assert(RadialProfile<Burley>);

FitTarget fit_target(const Burley& profile);

// How d = l / s follows from the albedo A and a length l (ibid., equations 5 to 8):
enum class BurleyScaling {
  searchlight,        // l the mean free path, a narrow beam: s = 1.85 - A + 7 |A - 0.8|^3
  diffuse,            // l the mean free path, diffuse light within: s = 1.9 - A + 3.5 (A - 0.8)^2
  diffuse_free_path,  // l the diffuse mean free path 1 / s_tr: s = 3.5 + 100 (A - 0.33)^4
};

double burley_scale(double albedo, BurleyScaling scaling);

// Of a medium: A is the better dipole's albedo (Burley's is of a Monte Carlo simulation, to which that comes
// nearest of the closed forms here), l its transport mean free path 1 / sigma_t' or, for diffuse_free_path,
// 1 / s_tr with Grosjean's diffusion coefficient. Throws Error (input) as better_dipole does, and for a
// medium that does not absorb with diffuse_free_path, which has none.
Burley burley(const Medium& medium, BurleyScaling scaling);

}  // namespace truescatter
