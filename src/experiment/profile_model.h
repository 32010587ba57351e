#pragma once

#include <array>
#include <string>

#include "config/experiment_spec.h"
#include "profile/image_sources.h"
#include "profile/profile.h"

namespace truescatter {

// A profile of diffusion theory that a sum of Gaussians approximates, ready to be convolved.
struct ProfileModel {
  ProfileModelSpec spec;  // a material's coefficients filled in
  std::array<ImageSources, 3> channels;
  Profile mixture;    // the same as Gaussians, close enough for its truth; weights of either sign
  Vec3d error_bound;  // per channel, of the mixture: GaussianMixture::error_bound
  Vec3d albedo;       // per channel, of the profile itself: what a plane under irradiance 1 sends back

  // What a reader calls it: "classical dipole of skin1".
  std::string title() const;
};

// The image sources of each channel, and their mixture to the tolerance that is asked for. `name`: of the
// profile that approximates it. Throws Error (input) at the offending line: no such material, a slab that
// diffusion theory has no answer for.
ProfileModel make_profile_model(const ProfileModelSpec& spec, const std::string& name);

}  // namespace truescatter
