#include "experiment/profile_model.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "profile/gaussian_mixture.h"

namespace truescatter {
namespace {

// As of any list of Gaussians; truths are not cut.
constexpr double kRadiusStdDevs = 3.0;

void fill_in_material(ProfileModelSpec& spec) {
  if (spec.material.empty()) return;
  std::vector<std::string> names;
  for (const Material& material : materials()) {
    names.push_back(material.name);
    if (material.name != spec.material) continue;
    spec.sigma_a_per_mm = material.sigma_a_per_mm;
    spec.sigma_s_prime_per_mm = material.sigma_s_prime_per_mm;
    spec.eta = material.eta;
    return;
  }
  throw_input_error(spec.material_where, "there is no material '{}'; there are: {}; or give coefficients",
                    spec.material, fmt::join(names, ", "));
}

ImageSources sources_of(const ProfileModelSpec& spec, int channel) {
  const Medium medium{spec.sigma_a_per_mm[channel], spec.sigma_s_prime_per_mm[channel], spec.eta};
  if (spec.model == "classical-dipole") return classical_dipole(medium);
  if (spec.model == "better-dipole") return better_dipole(medium);
  return multipole(medium, spec.thickness_mm, SlabSide::lit);
}

// One number where the channels agree.
std::string text_of(const Vec3d& channels) {
  if ((channels.array() == channels[0]).all()) return fmt::format("{}", channels[0]);
  return fmt::format("[{}]", fmt::join(channels, ", "));
}

Profile profile_of(const GaussianMixture& mixture, const std::string& name) {
  Profile profile;
  profile.name = name;
  for (const GaussianLevel& level : mixture.levels)
    profile.terms.push_back({Vec3d::Constant(level.variance_mm2), level.weight});
  profile.r_max_mm = kRadiusStdDevs * profile.widest_std_dev_mm();
  return profile;
}

}  // namespace

std::string ProfileModel::title() const {
  const std::string of = spec.material.empty() ? fmt::format("sigma_a {}, sigma_s' {} 1/mm, eta {}",
                                                             text_of(spec.sigma_a_per_mm),
                                                             text_of(spec.sigma_s_prime_per_mm), spec.eta)
                                               : spec.material;
  std::string model = spec.model;
  std::replace(model.begin(), model.end(), '-', ' ');
  const std::string slab =
      spec.model == "multipole" ? fmt::format(", a slab of {} mm", spec.thickness_mm) : "";
  return fmt::format("{} of {}{}", model, of, slab);
}

ProfileModel make_profile_model(const ProfileModelSpec& stated, const std::string& name) {
  ProfileModelSpec spec = stated;
  fill_in_material(spec);
  try {
    const std::array<ImageSources, 3> channels = {sources_of(spec, 0), sources_of(spec, 1),
                                                  sources_of(spec, 2)};
    const GaussianMixture mixture = gaussian_mixture(channels, spec.tolerance);
    const Vec3d albedo(channels[0].albedo(), channels[1].albedo(), channels[2].albedo());
    return {spec, channels, profile_of(mixture, name), mixture.error_bound, albedo};
  } catch (const Error& error) {
    throw Error(error.kind(), spec.where, error.what());
  }
}

}  // namespace truescatter
