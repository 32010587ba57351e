#pragma once

#include <array>
#include <functional>
#include <string>
#include <variant>

#include "config/experiment_spec.h"
#include "profile/burley.h"
#include "profile/fit_target.h"
#include "profile/gaussian_fit.h"
#include "profile/image_sources.h"
#include "profile/layered.h"
#include "profile/profile.h"
#include "profile/table_profile.h"

namespace truescatter {

using ChannelProfile = std::variant<ImageSources, Burley, LayeredProfile, TableProfile>;

// A diffusion profile with its names resolved and its files read.
struct DiffusionProfile {
  ProfileModelSpec spec;  // a material's coefficients filled in
  std::array<ChannelProfile, 3> channels;

  // What a reader calls it: "classical dipole of skin1".
  std::string title() const;
  Vec3d albedo() const;  // of the profile itself: what a plane under irradiance 1 sends back
  std::array<FitTarget, 3> fit_targets() const;  // over one domain: share_domain
};

// Finds the file that a path in a spec stands for. Throws Error (input) at `where`.
using FindFile = std::function<std::filesystem::path(const std::string& path, const SourceLocation& where)>;

// Throws Error (input) at the offending line or in the file at fault: no such material, a slab that diffusion
// theory has no answer for, a table or a list of layers that breaks a rule.
DiffusionProfile make_diffusion_profile(const ProfileModelSpec& spec, const FindFile& find_file);

// The Gaussians that `fit` asks for, of this profile; not from a file. Throws Error (input) at the fit's
// place: see gaussian_fit.h.
GaussianFit fit_profile(const DiffusionProfile& profile, const FitSpec& fit);

// A profile that a sum of Gaussians approximates, ready to be convolved: of image sources.
struct ProfileModel {
  ProfileModelSpec spec;
  std::array<ImageSources, 3> channels;
  Profile mixture;    // the same as Gaussians, close enough for its truth; weights of either sign
  Vec3d error_bound;  // per channel, of the mixture: GaussianMixture::error_bound
  Vec3d albedo;
  std::string title;
};

// The mixture, to the tolerance that is asked for, of a profile whose spec asks for its truth. `name`: of the
// sum that approximates it. Throws Error (input) at the model's line.
ProfileModel make_profile_model(const DiffusionProfile& profile, const std::string& name);

}  // namespace truescatter
