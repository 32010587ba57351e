#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "experiment/plan.h"
#include "experiment/profile_truth.h"
#include "experiment/scene_setup.h"
#include "experiment/view_truth.h"

namespace truescatter {

// Parts of results.json (README, Commands) that say what a run was made of.

// The mesh, its shading mesh and UVs, and how well irradiance is resolved.
nlohmann::json scene_json(const ExperimentSpec& spec, const PreparedScene& scene);
nlohmann::json profile_json(const Profile& profile);
// [r, g, b].
nlohmann::json vector_json(const Vec3d& v);
// What pictures for a person are made with: [composite].
nlohmann::json composite_json(const CompositeSpec& composite);

// As FIT.json has it, without the curve.
nlohmann::json profile_fit_json(const DiffusionProfile& profile, const FitSpec& asked,
                                const GaussianFit& fit);

// What a profile approximates: the model with its coefficients, its albedo, and the mixture that stands for
// it.
nlohmann::json profile_model_json(const ProfileModel& model);
nlohmann::json settings_json(const Settings& settings);
// metric, normalised, visible_only, transmittance, r_max_mm.
nlohmann::json target_json(const OwnTarget& target);
// An entry of truths[]: the target with its id, roles, cost and certificate.
nlohmann::json truth_json(const std::string& view, const PlannedTruth& planned, const TruthImage& truth,
                          const AuditSample& audited);
// The same for one of the two truths of the profile that `profile` approximates.
nlohmann::json model_truth_json(const std::string& view, const Profile& profile, const ProfileModel& model,
                                bool normalised, const ProfileTruth& truth, const AuditSample& audited);

}  // namespace truescatter
