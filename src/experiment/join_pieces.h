#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/map_files.h"
#include "experiment/pieces.h"
#include "experiment/plan.h"

namespace truescatter {

// One scene of an experiment: of a sweep one for each value.
struct ScenePlan {
  const ExperimentSpec& spec;
  const Plan& plan;
};

// Of an experiment's points (sweep_points) with the plan of each; both outlive what is returned.
std::vector<ScenePlan> scene_plans(const std::vector<ExperimentSpec>& points, const std::vector<Plan>& plans);

// results.json, but for what it says of the program and the machine, out of finished pieces, every one of
// which is there. `experiment`: as its file states it; `scenes`: what it is made of. Throws Error (run): see
// PieceStore.
nlohmann::json join_pieces(const ExperimentSpec& experiment, const std::vector<ScenePlan>& scenes,
                           const PieceStore& pieces);

// The ends of all error maps' colours: the median over the runs of the error's 99 % quantile, rounded up, and
// another one for the steps of ladders, which are smaller. The worst method's maps saturate; scaled to the
// worst, the good ones would be black.
MapRanges common_ranges(const nlohmann::json& results);

// Which pictures the views of a scene have.
std::vector<ViewPictures> pictures_of(const ScenePlan& scene, const PieceStore& pieces);

}  // namespace truescatter
