#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/profile_model.h"
#include "experiment/scene_setup.h"
#include "methods/method.h"
#include "profile/profile.h"

namespace truescatter {

// A method with its settings checked.
struct PlannedMethod {
  std::shared_ptr<const Method> method;
  std::string label;
  Settings settings;
  const MethodSpec* pictures =
      nullptr;  // of the experiment: the method is pictures made elsewhere; null: it is not
};

// An experiment with every name resolved: scenes x views x profiles x methods.
struct Plan {
  std::vector<Profile> profiles;
  // By profiles' names: what they approximate, where they say; that with its truth, where it is asked for;
  // and the fits that were made.
  std::map<std::string, DiffusionProfile> approximated;
  std::map<std::string, ProfileModel> models;
  std::map<std::string, GaussianFit> fits;
  std::vector<PlannedMethod> methods;
  std::vector<OwnTarget> extra_targets;  // every method is measured against these too
  std::string no_geodesics;              // why no geodesic truth is computed; empty: they are
  std::vector<LadderSpec> ladders;

  // What this profile approximates, where its truth is asked for; else null.
  const ProfileModel* model_of(const Profile& profile) const;
};

// Throws Error (input) at the offending line: unknown profile, material or method, a setting out of range;
// and as own_method.h says. Pictures that are not there are errors unless `without_pictures`; they are
// skipped then. The plan refers to the experiment.
Plan make_plan(const ExperimentSpec& spec, bool without_pictures = false);

// Compiles the shaders that the experiment brings. Throws Error (input): see glsl_method.h.
void check_shaders(const Plan& plan, const gpu::Context& context);
// The same on a context of its own, which is made if there are any.
void check_shaders(const Plan& plan, gpu::Backend gl);

// A truth that every view needs: a profile's headline, what methods set out to compute, or one that the
// experiment asks for beside them.
struct PlannedTruth {
  const Profile* profile;  // of the plan
  OwnTarget target;
  std::vector<std::string> own_target_of;  // labels of methods
  bool extra = false;
  std::vector<std::string> rung_of = {};  // names of ladders
  std::string not_computed = {};          // why the experiment does without it; empty: it is computed

  bool is_headline() const { return target == OwnTarget{}; }
};

// The truth that a ladder's rung names, which is no method.
OwnTarget rung_target(const LadderSpec::Rung& rung, const Profile& profile);

// Whether a method cannot run on a mesh without UVs, which this one is.
bool is_skipped(const PlannedMethod& method, bool has_uvs);

// Why a method of pictures is skipped: there is none for this view and profile. Empty: it is not.
std::string missing_picture(const ExperimentSpec& spec, const PlannedMethod& method, const std::string& view,
                            const std::string& profile);

// Each distinct target of what runs once, profile by profile, the headline first.
std::vector<PlannedTruth> planned_truths(const Plan& plan, bool has_uvs);

// A truth's name in results.json.
std::string truth_id(const std::string& view, const Profile& profile, const OwnTarget& target);

// The same of the truth of the profile that `profile` approximates.
std::string model_truth_id(const std::string& view, const Profile& profile, bool normalised);

// What a run would do, for --dry-run: scene, methods with their settings, and for each view its truths and
// runs.
std::string describe_plan(const ExperimentSpec& spec, const Plan& plan, const SceneOutline& scene);

}  // namespace truescatter
