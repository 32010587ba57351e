#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "experiment/scene_setup.h"
#include "experiment/scene_truths.h"
#include "experiment/view_points.h"
#include "experiment/view_truth.h"
#include "profile/profile.h"

namespace truescatter {

// What LightPaths are sampled from in one view under one profile.
struct LightPathInputs {
  const PreparedScene& scene;
  const SceneTruths& truths;
  const ViewTruth& view;
  const Profile& profile;
  const TruthSpec& spec;  // light_paths: how many pixels; seed
};

// An entry of `light_paths` in results.json: how the Euclidean truth differs from the geodesic one, split by
// the ways that light takes (LightPaths), at pixels of the view drawn without repetition. Raw sums over the
// profile's Gaussians, cut into near and far at its r_max; luminance. Of transmittance, air, curvature, their
// sum and what lies beyond r_max along the surface: RMS and mean over the pixels relative to the RMS of the
// raw Euclidean truth there. `quadrature_error`: of each part, the RMS of its change as the quadrature's
// parts are made twice as coarse, likewise relative. `sum_check`: the largest difference between the sum and
// Euclidean less geodesic truth by their fast engines, in units of the largest irradiance, and what the
// engines and the quadrature allow. Where the mesh carries no geodesics: the reason. Throws Error (run) where
// the sum differs by more than is allowed.
nlohmann::json light_paths_json(const std::string& view, const LightPathInputs& inputs);

}  // namespace truescatter
