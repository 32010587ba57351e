#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "profile/radial_profile.h"

namespace truescatter {

// One channel of a diffusion profile as a fit of Gaussians needs it. `value` and `antiderivative` are
// RadialProfile's; norms are integrals over [r_min_mm, r_max_mm].
struct FitTarget {
  std::function<double(double r_mm)> value;
  std::function<double(double r_mm)> antiderivative;
  double albedo = 0.0;
  double narrowest_mm = 0.0;  // the standard deviation below which a Gaussian is not resolved
  double r_min_mm = 0.0;
  double r_max_mm = 0.0;
  std::vector<double> breaks_mm;  // where it is not smooth, ascending; empty: smooth in log r
  bool square_integrable = true;  // int r f^2 dr is finite at r = 0
};

// Of a profile that is smooth but for r = 0, over the domain [1e-4 shortest length, the radius beyond which
// 1e-10 of the albedo is left, or 1e6 shortest lengths if that is less]: of a dipole, [1e-4 / sigma_t', some
// 23 / s_tr]. What is left out of it weighs less than 1e-7 of any of the norms.
template <RadialProfile P>
FitTarget fit_target(const P& profile) {
  constexpr double kLeftOut = 1e-10;
  constexpr double kDecadesOut = 1e6;
  const double length_mm = profile.shortest_length_mm();
  const double whole = std::abs(profile.antiderivative(0.0));
  double r_max_mm = length_mm;
  while (std::abs(profile.antiderivative(r_max_mm)) > kLeftOut * whole && r_max_mm < kDecadesOut * length_mm)
    r_max_mm *= 1.05;
  return {[profile](double r_mm) { return profile.value(r_mm); },
          [profile](double r_mm) { return profile.antiderivative(r_mm); },
          profile.albedo(),
          0.03 * length_mm,
          1e-4 * length_mm,
          r_max_mm,
          {},
          true};
}

}  // namespace truescatter
