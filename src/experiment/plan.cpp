#include "experiment/plan.h"

#include <algorithm>

namespace truescatter {
namespace {

Profile resolve_profile(const ProfileSpec& spec) {
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

}  // namespace

Plan make_plan(const ExperimentSpec& spec) {
  Plan plan;
  for (const ProfileSpec& profile : spec.profiles) plan.profiles.push_back(resolve_profile(profile));
  for (const MethodSpec& m : spec.methods) {
    const Method& method = find_method(m.name, m.where);
    plan.methods.push_back(
        {&method, m.label, Settings(method.name, method.settings, m.settings, m.settings_where)});
  }
  return plan;
}

std::string describe_plan(const ExperimentSpec& spec, const Plan& plan) {
  std::string text =
      fmt::format("{}: {} views x {} profiles x {} methods = {} runs\nscene {}\n", spec.name,
                  spec.views.size(), plan.profiles.size(), plan.methods.size(),
                  spec.views.size() * plan.profiles.size() * plan.methods.size(), spec.scene.mesh);
  for (const ViewSpec& view : spec.views) {
    text += fmt::format("view {}: {} x {} px\n", view.name, view.width_px, view.height_px);
    for (const Profile& profile : plan.profiles) {
      text += fmt::format("  truth {}: Euclidean, normalised, tolerance {}\n", profile.name,
                          spec.truth.tolerance);
      for (const PlannedMethod& m : plan.methods) {
        text += fmt::format("  run {} {} ({}), {} + {} frames\n", profile.name, m.label, m.method->title,
                            spec.timing.warm_up, spec.timing.repeats);
      }
    }
  }
  return text;
}

}  // namespace truescatter
