#pragma once

#include <string>
#include <vector>

#include "config/experiment_spec.h"
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

// What a run would do, one line each, for --dry-run.
std::string describe_plan(const ExperimentSpec& spec, const Plan& plan);

}  // namespace truescatter
