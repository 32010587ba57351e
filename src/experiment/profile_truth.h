#pragma once

#include "experiment/profile_model.h"
#include "experiment/view_truth.h"
#include "truth/surface.h"

namespace truescatter {

// The raw sum of a mixture against the exact truth of the profile itself (RadialExactEngine), at some of the
// audited points: light in units of the largest irradiance, and mass.
struct RadialCheck {
  std::size_t points = 0;
  double max_difference = 0.0;
  // What it may be: the mixture's bound over a surface that has at most twice the area of its tangent plane
  // in any shell around the point (as the fast engine's tail bound has it), and the fast engine's tolerance
  // times the sum of |weights|.
  double allowed = 0.0;
};

// The truth of a profile of diffusion theory itself in one view, by its mixture of Gaussians, Euclidean:
//
//   raw         M_f = sum w_i M_i
//   normalised  A M_f / m_f per channel, m_f = sum w_i m_i, A the profile's albedo
//
// One mass for the whole profile: normalising each Gaussian by itself would depend on the mixture. With A in
// front it is scaled as a fit's truth sum w_i M_i / m_i is: each sends back its own albedo of even light.
// `smallest_mass` is m_f / A, of the channel that has least.
struct ProfileTruth {
  TruthImage raw;
  TruthImage normalised;
  RadialCheck check;
};

// What `truth.compute` has to be asked for.
ViewTruth::Request request_of(const ProfileModel& model);

// `truth` has computed it over `surface`, which it is checked with; null: it is not, and `check` has no
// points. Throws Error (run) if the check fails.
ProfileTruth profile_truth(const ProfileModel& model, const ViewTruth& truth, const Surface* surface);

}  // namespace truescatter
