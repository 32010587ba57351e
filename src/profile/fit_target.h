#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "profile/radial_profile.h"

namespace truescatter {

// One channel of a diffusion profile as a fit of Gaussians needs it. `value` and `antiderivative` are
// RadialProfile's; the quadratic norms are integrals over [r_min_mm, r_max_mm].
struct FitTarget {
  std::function<double(double r_mm)> value;
  std::function<double(double r_mm)> antiderivative;
  double albedo = 0.0;
  double narrowest_mm = 0.0;  // the standard deviation below which a Gaussian is not resolved
  double widest_mm = 0.0;     // and above which it is flat over all of the domain
  double r_min_mm = 0.0;
  double r_max_mm = 0.0;
  std::vector<double> breaks_mm;  // where it is not smooth, ascending; empty: smooth in log r
  bool square_integrable = true;  // int r f^2 dr is finite at r = 0
};

// Of a profile that is smooth but for r = 0, over the domain [1e-4 shortest length, the radius beyond which
// 1e-10 of the albedo is left, or 1e6 shortest lengths if that is less]: of a dipole, [1e-4 / sigma_t', some
// 23 / s_tr]. Of r R^2 and r^2 R^2, R finite at 0, less than 1e-8 is left out. A Gaussian of half of the
// domain's length is wider than any that helps, as so little of the light is beyond.
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
          0.5 * r_max_mm,
          1e-4 * length_mm,
          r_max_mm,
          {},
          true};
}

// Channels that are fitted together: each gets the union of their domains, so that a Gaussian for a wide
// channel is not free in a narrow one, beyond whose own domain it would shine. Tables keep theirs, which are
// what was measured.
inline void share_domain(std::array<FitTarget, 3>& targets) {
  double r_min_mm = targets[0].r_min_mm;
  double r_max_mm = targets[0].r_max_mm;
  for (const FitTarget& target : targets) {
    if (!target.breaks_mm.empty()) return;
    r_min_mm = std::min(r_min_mm, target.r_min_mm);
    r_max_mm = std::max(r_max_mm, target.r_max_mm);
  }
  for (FitTarget& target : targets) {
    target.r_min_mm = r_min_mm;
    target.r_max_mm = r_max_mm;
  }
}

}  // namespace truescatter
