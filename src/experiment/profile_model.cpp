#include "experiment/profile_model.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "profile/gaussian_mixture.h"

namespace truescatter {
namespace {

template <typename Named>
const Named* find_named(const std::vector<Named>& known, const std::string& name) {
  const auto found = std::find_if(known.begin(), known.end(), [&](const Named& n) { return n.name == name; });
  return found == known.end() ? nullptr : &*found;
}

// A stack of layers by its name; null where the material is another or there is none.
const LayeredMaterial* layered_material(const ProfileModelSpec& spec) {
  return spec.model == "multipole" ? find_named(layered_materials(), spec.material) : nullptr;
}

void fill_in_material(ProfileModelSpec& spec) {
  if (spec.material.empty() || layered_material(spec) != nullptr) return;
  if (const Material* material = find_named(materials(), spec.material)) {
    spec.sigma_a_per_mm = material->sigma_a_per_mm;
    spec.sigma_s_prime_per_mm = material->sigma_s_prime_per_mm;
    spec.eta = material->eta;
    return;
  }
  std::vector<std::string> names;
  for (const Material& material : materials()) names.push_back(material.name);
  if (spec.model == "multipole")
    for (const LayeredMaterial& material : layered_materials()) names.push_back(material.name);
  throw_input_error(spec.material_where, "there is no material '{}'; there are: {}; or give coefficients",
                    spec.material, fmt::join(names, ", "));
}

BurleyScaling scaling_of(const ProfileModelSpec& spec) {
  if (spec.scaling == "searchlight") return BurleyScaling::searchlight;
  return spec.scaling == "diffuse" ? BurleyScaling::diffuse : BurleyScaling::diffuse_free_path;
}

// What one channel is where its medium is all that is known.
ChannelProfile homogeneous(const ProfileModelSpec& spec, const Medium& medium) {
  if (spec.model == "classical-dipole") return classical_dipole(medium);
  if (spec.model == "better-dipole") return better_dipole(medium);
  if (spec.model == "burley") return burley(medium, scaling_of(spec));
  if (spec.truth) return multipole(medium, spec.thickness_mm, SlabSide::lit);
  // The same in closed form, however many images matter.
  require_valid(medium);
  require_thick(medium, spec.thickness_mm, "slab");
  return LayeredProfile({{medium, spec.thickness_mm}});
}

std::array<ChannelProfile, 3> stacks_of(const std::array<std::vector<Layer>, 3>& layers) {
  return {LayeredProfile(layers[0]), LayeredProfile(layers[1]), LayeredProfile(layers[2])};
}

std::array<ChannelProfile, 3> channels_of(const ProfileModelSpec& spec, const FindFile& find_file) {
  if (spec.model == "table") {
    const std::array<TableProfile, 3> table = read_table_profile(find_file(spec.table, spec.file_where));
    return {table[0], table[1], table[2]};
  }
  if (!spec.layers.empty()) return stacks_of(read_layers(find_file(spec.layers, spec.file_where)));
  if (const LayeredMaterial* material = layered_material(spec)) {
    if (spec.thickness_mm > 0.0)
      throw_input_error(spec.material_where, "'{}' has layers of its own: no thickness goes with it",
                        spec.material);
    return stacks_of(material->channels);
  }
  if (spec.model == "multipole" && spec.thickness_mm == 0.0) {
    throw_input_error(
        spec.where, "a multipole needs the slab's thickness, a list of layers or a material that has layers");
  }
  const auto channel = [&](int c) {
    return homogeneous(spec, {spec.sigma_a_per_mm[c], spec.sigma_s_prime_per_mm[c], spec.eta});
  };
  return {channel(0), channel(1), channel(2)};
}

// Errors of formulas get the place that they come from; those of files have theirs.
template <typename Body>
auto located(const SourceLocation& where, const Body& body) {
  try {
    return body();
  } catch (const Error& error) {
    if (!error.where().file.empty()) throw;
    throw Error(error.kind(), where, error.what());
  }
}

// One number where the channels agree.
std::string text_of(const Vec3d& channels) {
  if ((channels.array() == channels[0]).all()) return fmt::format("{}", channels[0]);
  return fmt::format("[{}]", fmt::join(channels, ", "));
}

}  // namespace

std::string DiffusionProfile::title() const {
  if (spec.model == "table") return fmt::format("table {}", spec.table);
  if (!spec.layers.empty()) return fmt::format("multipole of the layers of {}", spec.layers);
  const std::string of = spec.material.empty() ? fmt::format("sigma_a {}, sigma_s' {} 1/mm, eta {}",
                                                             text_of(spec.sigma_a_per_mm),
                                                             text_of(spec.sigma_s_prime_per_mm), spec.eta)
                                               : spec.material;
  std::string model = spec.model;
  std::replace(model.begin(), model.end(), '-', ' ');
  if (spec.model == "burley") model += fmt::format(" ({})", spec.scaling);
  const std::string slab = spec.thickness_mm > 0.0 ? fmt::format(", a slab of {} mm", spec.thickness_mm) : "";
  return fmt::format("{} of {}{}", model, of, slab);
}

Vec3d DiffusionProfile::albedo() const {
  Vec3d albedo;
  for (std::size_t c = 0; c < 3; ++c)
    albedo[static_cast<Eigen::Index>(c)] = std::visit([](const auto& p) { return p.albedo(); }, channels[c]);
  return albedo;
}

std::array<FitTarget, 3> DiffusionProfile::fit_targets() const {
  const auto target = [](const ChannelProfile& channel) {
    return std::visit([](const auto& p) { return fit_target(p); }, channel);
  };
  std::array<FitTarget, 3> targets = {target(channels[0]), target(channels[1]), target(channels[2])};
  share_domain(targets);
  return targets;
}

DiffusionProfile make_diffusion_profile(const ProfileModelSpec& stated, const FindFile& find_file) {
  ProfileModelSpec spec = stated;
  fill_in_material(spec);
  return located(spec.where, [&] { return DiffusionProfile{spec, channels_of(spec, find_file)}; });
}

GaussianFit fit_profile(const DiffusionProfile& profile, const FitSpec& fit) {
  FitOptions options;
  options.norm = find_norm(fit.norm).value();
  options.nonnegative = fit.nonnegative;
  options.keep_albedo = fit.keep_albedo;
  options.shared_variances = fit.shared_variances;
  options.min_variance_mm2 = fit.min_variance_mm2;
  options.max_variance_mm2 = fit.max_variance_mm2;
  options.seed = static_cast<std::uint64_t>(fit.seed);
  const std::array<FitTarget, 3> targets = profile.fit_targets();
  located(fit.norm_where, [&] { require_finite(options.norm, targets[0]); });
  return located(fit.gaussians > 0 ? fit.where : fit.tolerance_where, [&] {
    return fit.gaussians > 0 ? fit_gaussians(targets, fit.gaussians, options)
                             : fit_to_tolerance(targets, fit.tolerance, options);
  });
}

ProfileModel make_profile_model(const DiffusionProfile& profile, const std::string& name) {
  const auto sources = [&](std::size_t c) { return std::get<ImageSources>(profile.channels[c]); };
  const std::array<ImageSources, 3> channels = {sources(0), sources(1), sources(2)};
  return located(profile.spec.where, [&] {
    const GaussianMixture mixture = gaussian_mixture(channels, profile.spec.tolerance);
    return ProfileModel{profile.spec,        channels,         sum_of_gaussians(name, mixture.levels),
                        mixture.error_bound, profile.albedo(), profile.title()};
  });
}

}  // namespace truescatter
