#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "profile/fit_norms.h"
#include "profile/fit_target.h"
#include "profile/profile.h"

namespace truescatter {

inline constexpr int kMostGaussians = 16;  // of a fit

struct FitOptions {
  FitNorm norm = FitNorm::r;
  bool nonnegative = true;                 // weights >= 0; else of either sign
  bool keep_albedo = false;                // the weights of a channel sum to its profile's albedo
  bool shared_variances = true;            // one set for all channels, as passes that blur all at once need
  std::optional<double> min_variance_mm2;  // of every Gaussian; nothing: as narrow as is resolved
  std::optional<double> max_variance_mm2;
  std::uint64_t seed = 1;  // of the random starts
  int random_starts = 8;
};

// Gaussians in place of a profile: per channel sum_i w_i G(v_i, r).
struct GaussianFit {
  std::vector<GaussianLevel> levels;  // variances ascending; a channel that does not use one has weight 0
  std::array<FitErrors, 3> errors;    // of each channel
  std::vector<WeightedGaussian> channel(std::size_t c) const;
  Vec3d total_weight() const;        // per channel
  double worst(FitNorm norm) const;  // of the channels
};

// Whether a sum has no weight in a channel, as a published one that is of another channel alone.
bool is_dark(const GaussianFit& fit, std::size_t channel);

// The sum of `gaussians` Gaussians (for each channel, where variances are not shared) that is nearest to the
// profile in the norm: the least sum over channels of the squared relative errors (of the relative errors,
// for the area norm).
//
// For given variances the best weights are a linear problem (weight_solver.h), so the search is over
// variances alone (variable projection, Golub & Pereyra 1973), by Ceres with the exact Jacobian. Neighbouring
// variances differ by 5 % at least, by 25 % where weights may be of either sign, which otherwise can grow
// without end. The area norm is approached by quadratic ones that are weighted anew after each step.
//
// One start is not enough: sums of ever more Gaussians grow by one where it helps most; the last is also
// tried with each of its Gaussians moved to where another would help most, and from random places. The best
// of all is kept, so that the seed changes the path, not the result.
//
// Throws Error (input) for a number of Gaussians out of 1 to 16; for more Gaussians than the profile carries
// (the best sum has fewer, the rest would have no weight or add nothing) or than a table has points for; for
// the norm r where it is not finite; and for bounds that leave no room.
GaussianFit fit_gaussians(const std::array<FitTarget, 3>& targets, int gaussians, const FitOptions& options);

// The fewest Gaussians whose worst channel errs by `tolerance` at most in the norm. Throws Error (input)
// that says how near it comes where the tolerance is out of reach.
GaussianFit fit_to_tolerance(const std::array<FitTarget, 3>& targets, double tolerance,
                             const FitOptions& options);

}  // namespace truescatter
