#pragma once

#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/scene_setup.h"
#include "methods/method.h"
#include "profile/profile.h"

namespace truescatter {

// A method with its settings checked.
struct PlannedMethod {
  const Method* method;
  std::string label;
  Settings settings;
};

// An experiment with every name resolved: scenes x views x profiles x methods.
struct Plan {
  std::vector<Profile> profiles;
  std::vector<PlannedMethod> methods;
};

// Throws Error (input) at the offending line: unknown profile or method, a setting out of range.
Plan make_plan(const ExperimentSpec& spec);

// A truth that every view needs: a profile's headline, or what methods set out to compute.
struct PlannedTruth {
  const Profile* profile;  // of the plan
  OwnTarget target;
  std::vector<std::string> own_target_of;  // labels of methods

  bool is_headline() const { return target == OwnTarget{}; }
};

// Each distinct target once, profile by profile, the headline first. Geodesic ones are not computed yet.
std::vector<PlannedTruth> planned_truths(const Plan& plan);

// A truth's name in results.json.
std::string truth_id(const std::string& view, const Profile& profile, const OwnTarget& target);

// What a run would do, for --dry-run: scene, methods with their settings, and for each view its truths and
// runs.
std::string describe_plan(const ExperimentSpec& spec, const Plan& plan, const SceneOutline& scene);

}  // namespace truescatter
