#include "experiment/plan.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "experiment/fit_file.h"
#include "experiment/own_method.h"

namespace truescatter {
namespace {

// "1 view", "2 views".
std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

// Fitted now, or in a file.
Profile fitted_profile(const ExperimentSpec& experiment, const ProfileSpec& spec, Plan& plan) {
  Profile profile;
  if (spec.fit->file.empty()) {
    const DiffusionProfile& of = plan.approximated.at(spec.name);
    const GaussianFit& fit = plan.fits.emplace(spec.name, fit_profile(of, *spec.fit)).first->second;
    profile = sum_of_gaussians(spec.name, fit.levels);
    profile.title = fmt::format("{} for the {}", counted(fit.levels.size(), "Gaussian"), of.title());
    profile.source = "fitted by this experiment";
  } else {
    profile =
        sum_of_gaussians(spec.name, read_fit(resolve_path(experiment, spec.fit->file, spec.fit->where)));
    profile.title = fmt::format("{} of {}", counted(profile.terms.size(), "Gaussian"), spec.fit->file);
    profile.source = spec.fit->file;
  }
  if (spec.r_max_mm > 0.0) profile.r_max_mm = spec.r_max_mm;
  return profile;
}

Profile resolve_profile(const ExperimentSpec& experiment, const ProfileSpec& spec, Plan& plan) {
  if (spec.fit) return fitted_profile(experiment, spec, plan);
  if (!spec.builtin) {
    Profile profile;
    profile.name = spec.name;
    profile.title = spec.name;
    profile.source = "this experiment";
    profile.delta_weight = spec.delta_weight;
    for (const auto& gaussian : spec.gaussians)
      profile.terms.push_back({gaussian.variance_mm2, gaussian.weight});
    profile.r_max_mm = spec.r_max_mm;
    return profile;
  }
  const std::vector<Profile>& known = builtin_profiles();
  const auto found =
      std::find_if(known.begin(), known.end(), [&](const Profile& p) { return p.name == spec.name; });
  if (found != known.end()) return *found;
  std::vector<std::string> names;
  for (const Profile& p : known) names.push_back(p.name);
  throw_input_error(spec.where,
                    "there is no built-in profile '{}'; there are: {}; or give [[profile.gaussian]] entries",
                    spec.name, fmt::join(names, ", "));
}

// What the fast geodesic engine can promise in double precision.
constexpr double kSmallestGeodesicTolerance = 1e-7;

std::string reason_without_geodesics(const TruthSpec& spec) {
  if (spec.geodesic == "off") return "the experiment sets truth.geodesic = \"off\"";
  if (spec.tolerance >= kSmallestGeodesicTolerance) return "";
  return fmt::format("truth.tolerance is {}, and geodesic truths are good to {} at best", spec.tolerance,
                     kSmallestGeodesicTolerance);
}

// What a user's uniforms take: any number.
std::vector<SettingSpec> specs_of(const Method& method, const MethodSpec& spec) {
  if (!spec.own) return method.settings;
  std::vector<SettingSpec> specs;
  for (const auto& [name, value] : spec.settings)
    specs.push_back(
        {name, "", 0.0, std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()});
  return specs;
}

std::shared_ptr<const Method> resolve_method(const ExperimentSpec& spec, const MethodSpec& m) {
  if (m.own) return std::make_shared<const Method>(own_method(spec, m));
  // Built-in methods live as long as the program: nothing is owned.
  return {std::shared_ptr<const Method>(), &find_method(m.name, m.where)};
}

// Every picture that a method needs is there and fits its view; those that are not are passed over if
// `optional`.
void check_pictures(const ExperimentSpec& spec, const MethodSpec& method, bool optional) {
  if (spec.views.size() > 1 && method.own->image.find("{view}") == std::string::npos) {
    throw_input_error(method.own->image_where, "'method.image' needs {{view}} in it: there are {} views",
                      spec.views.size());
  }
  for (const ViewSpec& view : spec.views) {
    for (const ProfileSpec& profile : spec.profiles) {
      const std::filesystem::path file = picture_path(spec, method, view.name, profile.name);
      if (std::filesystem::exists(file)) {
        read_picture(file, method, view);
      } else if (!optional) {
        throw_input_error(method.own->image_where,
                          "no such file: {}; what it can be made from is written by run --export-inputs",
                          file.string());
      }
    }
  }
}

std::string text_of(double value) { return fmt::format("{}", value); }
std::string text_of(const SettingValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

// " (name = value, ...)", or nothing.
template <typename Value>
std::string in_brackets(const std::map<std::string, Value>& values) {
  std::vector<std::string> parts;
  for (const auto& [name, value] : values) parts.push_back(name + " = " + text_of(value));
  return parts.empty() ? "" : fmt::format(" ({})", fmt::join(parts, ", "));
}

std::string describe_truth(const std::string& view, const PlannedTruth& truth) {
  std::vector<std::string> roles;
  if (truth.is_headline()) roles.emplace_back("headline");
  if (!truth.own_target_of.empty())
    roles.push_back(fmt::format("own target of {}", fmt::join(truth.own_target_of, ", ")));
  if (truth.extra) roles.emplace_back("extra");
  if (!truth.rung_of.empty()) roles.push_back(fmt::format("rung of {}", fmt::join(truth.rung_of, ", ")));
  if (!truth.not_computed.empty()) roles.push_back("not computed: " + truth.not_computed);
  return fmt::format(
      "truth {}: {}, {}, {}{}{}, {} Gaussians; {}\n", truth_id(view, *truth.profile, truth.target),
      truth.target.geodesic ? "geodesic" : "Euclidean", truth.target.normalised ? "normalised" : "raw",
      truth.target.r_max_mm ? fmt::format("cut at {} mm", *truth.target.r_max_mm) : "not cut",
      truth.target.visible_only ? ", visible surface only" : "",
      truth.target.transmittance ? ", with what comes through the body, at a sample of pixels" : "",
      gaussian_levels(*truth.profile).size(), fmt::join(roles, "; "));
}

std::string describe_model_truth(const std::string& view, const Profile& profile, const ProfileModel& model) {
  return fmt::format("truth {}: {}, {} Gaussians, off by {:.2g} at most; fit error, profile error\n",
                     model_truth_id(view, profile, true), model.title, gaussian_levels(model.mixture).size(),
                     model.error_bound.maxCoeff());
}

}  // namespace

const ProfileModel* Plan::model_of(const Profile& profile) const {
  const auto found = models.find(profile.name);
  return found != models.end() ? &found->second : nullptr;
}

Plan make_plan(const ExperimentSpec& spec, bool without_pictures) {
  Plan plan;
  for (const ProfileSpec& profile : spec.profiles) {
    if (profile.of) {
      const auto find_file = [&](const std::string& path, const SourceLocation& where) {
        return resolve_path(spec, path, where);
      };
      const DiffusionProfile& of =
          plan.approximated.emplace(profile.name, make_diffusion_profile(*profile.of, find_file))
              .first->second;
      if (profile.of->truth) plan.models.emplace(profile.name, make_profile_model(of, profile.name));
    }
    plan.profiles.push_back(resolve_profile(spec, profile, plan));
  }
  for (const MethodSpec& m : spec.methods) {
    const std::shared_ptr<const Method> method = resolve_method(spec, m);
    const bool pictures = m.own && !m.own->image.empty();
    if (pictures) check_pictures(spec, m, without_pictures);
    plan.methods.push_back({method, m.label,
                            Settings(method->name, specs_of(*method, m), m.settings, m.settings_where),
                            pictures ? &m : nullptr});
  }
  plan.no_geodesics = reason_without_geodesics(spec.truth);
  plan.ladders = spec.ladders;
  if (spec.truth.visible_only) plan.extra_targets.push_back({false, true, std::nullopt, true});
  if (spec.truth.geodesic == "extra") plan.extra_targets.push_back({true, true, std::nullopt});
  return plan;
}

OwnTarget rung_target(const LadderSpec::Rung& rung, const Profile& profile) {
  OwnTarget target;
  target.geodesic = rung.truth == "geodesic";
  target.normalised = !rung.truth.starts_with("raw");
  target.visible_only = rung.truth.ends_with("visible");
  if (rung.truth.find("cut") != std::string::npos) target.r_max_mm = profile.r_max_mm;
  return target;
}

void check_shaders(const Plan& plan, const gpu::Context& context) {
  for (const PlannedMethod& m : plan.methods) {
    if (!m.method->check) continue;
    for (const Profile& profile : plan.profiles) m.method->check(context, profile, m.settings);
  }
}

void check_shaders(const Plan& plan, gpu::Backend gl) {
  const bool any = std::any_of(plan.methods.begin(), plan.methods.end(),
                               [](const PlannedMethod& m) { return static_cast<bool>(m.method->check); });
  if (any) check_shaders(plan, gpu::Context(gl));
}

bool is_skipped(const PlannedMethod& method, bool has_uvs) { return method.method->needs_uvs && !has_uvs; }

std::string missing_picture(const ExperimentSpec& spec, const PlannedMethod& method, const std::string& view,
                            const std::string& profile) {
  if (method.pictures == nullptr) return "";
  const std::filesystem::path file = picture_path(spec, *method.pictures, view, profile);
  return std::filesystem::exists(file) ? "" : "its picture is not there yet: " + file.string();
}

std::vector<PlannedTruth> planned_truths(const Plan& plan, bool has_uvs) {
  std::vector<PlannedTruth> truths;
  for (const Profile& profile : plan.profiles) {
    const std::size_t first = truths.size();
    // A reference into `truths`, good until the next call.
    const auto truth_of = [&](const OwnTarget& target) -> PlannedTruth& {
      const auto known = std::find_if(truths.begin() + static_cast<std::ptrdiff_t>(first), truths.end(),
                                      [&](const PlannedTruth& t) { return t.target == target; });
      if (known != truths.end()) return *known;
      truths.push_back({&profile, target, {}});
      if (target.follows_surface()) truths.back().not_computed = plan.no_geodesics;
      return truths.back();
    };
    truth_of(OwnTarget{});
    for (const PlannedMethod& m : plan.methods) {
      if (is_skipped(m, has_uvs)) continue;
      truth_of(m.method->own_target(profile, m.settings)).own_target_of.push_back(m.label);
    }
    for (const OwnTarget& target : plan.extra_targets) truth_of(target).extra = true;
    for (const LadderSpec& ladder : plan.ladders) {
      for (const LadderSpec::Rung& rung : ladder.rungs) {
        if (!rung.truth.empty()) truth_of(rung_target(rung, profile)).rung_of.push_back(ladder.name);
      }
    }
  }
  return truths;
}

std::string truth_id(const std::string& view, const Profile& profile, const OwnTarget& target) {
  std::string id =
      fmt::format("{}/{}/{}{}-{}", view, profile.name, target.geodesic ? "geodesic" : "euclidean",
                  target.visible_only ? "-visible" : "", target.normalised ? "normalised" : "raw");
  if (target.transmittance) id += "-transmittance";
  if (target.r_max_mm) id += fmt::format("-r{:.4g}", *target.r_max_mm);
  return id;
}

std::string model_truth_id(const std::string& view, const Profile& profile, bool normalised) {
  return fmt::format("{}/{}/profile-itself-{}", view, profile.name, normalised ? "normalised" : "raw");
}

std::string describe_plan(const ExperimentSpec& spec, const Plan& plan, const SceneOutline& scene) {
  const std::size_t runs = spec.views.size() * plan.profiles.size() * plan.methods.size();
  std::string text = fmt::format("{}: {} x {} x {} = {}\n", spec.name, counted(spec.views.size(), "view"),
                                 counted(plan.profiles.size(), "profile"),
                                 counted(plan.methods.size(), "method"), counted(runs, "run"));
  text += fmt::format("scene {}{}\n", spec.scene.mesh, in_brackets(scene.parameters));
  if (!spec.scene.characters.empty()) text += fmt::format("characters {}\n", spec.scene.characters.size());
  if (!spec.scene.skin_mask.empty()) text += fmt::format("skin mask {}\n", spec.scene.skin_mask);
  if (spec.truth.mask_truth == "all") text += "truth: what is not skin gives and receives light too\n";
  for (const PlannedMethod& m : plan.methods)
    text += fmt::format("method {}: {}{}\n", m.label, m.method->title, in_brackets(m.settings.values()));
  for (const Profile& profile : plan.profiles) {
    const auto fit = plan.fits.find(profile.name);
    if (fit == plan.fits.end()) continue;
    text += fmt::format("profile {}: {}; area error {:.3g} at most\n", profile.name, profile.title,
                        fit->second.worst(FitNorm::area));
  }
  const std::vector<PlannedTruth> truths = planned_truths(plan, scene.has_uvs);
  for (const ViewSpec& view : spec.views) {
    text += fmt::format("view {}: {} x {} px\n", view.name, view.width_px, view.height_px);
    for (const PlannedTruth& truth : truths) text += "  " + describe_truth(view.name, truth);
    for (const Profile& profile : plan.profiles) {
      if (const ProfileModel* model = plan.model_of(profile))
        text += "  " + describe_model_truth(view.name, profile, *model);
    }
    for (const Profile& profile : plan.profiles) {
      for (const PlannedMethod& m : plan.methods) {
        const std::string id = fmt::format("{}/{}/{}", view.name, profile.name, m.label);
        const std::string missing = missing_picture(spec, m, view.name, profile.name);
        if (is_skipped(m, scene.has_uvs)) {
          text += fmt::format("  skip {}: it needs UVs, and the mesh has none\n", id);
        } else if (!missing.empty()) {
          text += fmt::format("  skip {}: {}\n", id, missing);
        } else if (m.pictures != nullptr) {
          text += fmt::format("  read {}: {}\n", id,
                              picture_path(spec, *m.pictures, view.name, profile.name).string());
        } else {
          text += fmt::format("  run {}: {} + {} frames\n", id, spec.timing.warm_up, spec.timing.repeats);
        }
      }
    }
  }
  for (const LadderSpec& ladder : spec.ladders) {
    std::vector<std::string> rungs;
    for (const auto& rung : ladder.rungs)
      rungs.push_back(rung.truth.empty() ? rung.method : "truth " + rung.truth);
    text += fmt::format("ladder {}: {}\n", ladder.name, fmt::join(rungs, " -> "));
  }
  for (const ThresholdSpec& threshold : spec.thresholds)
    text += fmt::format("threshold {}: {} <= {}\n", threshold.method, threshold.metric, threshold.maximum);
  return text;
}

}  // namespace truescatter
