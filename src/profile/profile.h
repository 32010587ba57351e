#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// One Gaussian per channel, G(v, r) = exp(-r^2 / 2v) / (2 pi v), times a weight per channel. In a published
// "sum of Gaussians" the three variances are equal; in Mikkelsen's spike and base they are not.
struct GaussianTerm {
  Vec3d variance_mm2;  // per channel: a variance, the square of the standard deviation
  Vec3d weight;        // per channel

  Vec3d std_dev_mm() const { return variance_mm2.cwiseSqrt(); }
};

// A diffusion profile as w_0 delta + sum_i w_i G_i, per channel.
struct Profile {
  std::string name;
  std::string title;
  std::string source;
  Vec3d delta_weight = Vec3d::Zero();  // light that leaves where it entered ("spike")
  std::vector<GaussianTerm> terms;     // ascending in the red variance
  double r_max_mm = 0.0;               // the radius that the source gives the filter; > 0

  // Sum of all weights per channel: 1 where the profile keeps energy.
  Vec3d total_weight() const;
  // The widest standard deviation that has weight in any channel: the unit of halo widths.
  double widest_std_dev_mm() const;
};

// One distinct variance of a profile with the weights of all terms that have it: what a method that blurs
// all channels alike needs ("a sum of Gaussians" with one blur for each variance).
struct GaussianLevel {
  double variance_mm2;
  Vec3d weight;

  double std_dev_mm() const;
};

// The distinct variances of a profile, ascending; channels that do not use one have weight 0 there.
std::vector<GaussianLevel> gaussian_levels(const Profile& profile);

// A profile of these Gaussians alone, whose filters reach three standard deviations of the widest.
Profile sum_of_gaussians(const std::string& name, const std::vector<GaussianLevel>& levels);

// The published profiles that are built in, by name:
//   spike-and-base        Mikkelsen 2010 table 1, "variance" read as a variance (the default reading:
//                         3 sqrt(2.3) = 4.55 mm is his r_max of 4.5 mm)
//   spike-and-base-sigma  the same numbers read as standard deviations
//   skin-six-gaussian     d'Eon & Luebke's six Gaussians, as in Yang et al. figure 2
const std::vector<Profile>& builtin_profiles();

// The published sums of Gaussians, to be scored against the profiles that they stand for:
//   skin-six-gaussian           as above
//   marble-green-four-gaussian  d'Eon & Luebke 2007's marble; green alone is published, so red and blue are
//   dark
const std::vector<Profile>& published_sums();

// A copy of `profile` with every length scaled by `factor` (> 0): variances by its square.
Profile scaled(const Profile& profile, double factor);

}  // namespace truescatter
