#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/pieces.h"
#include "experiment/plan.h"
#include "experiment/sweep.h"

namespace truescatter {

// One scene of an experiment: of a sweep one for each value.
struct ScenePlan {
  const ExperimentSpec& spec;
  const Plan& plan;
};

// Of an experiment's points (sweep_points) with the plan of each; both outlive what is returned.
std::vector<ScenePlan> scene_plans(const std::vector<ExperimentSpec>& points, const std::vector<Plan>& plans);

// All that results.json takes from an experiment beside what its pieces hold. A part keeps it, so that parts
// are joined of what was computed, wherever the experiment's files are by then, and whatever they say.
struct ExperimentRecord {
  struct Scene {
    std::vector<Piece> pieces;      // pieces_of
    nlohmann::json profiles;        // an array; what `profiles` of results.json says of each
    std::optional<SweepMark> mark;  // of a sweep's scenes
  };
  nlohmann::json experiment;  // `experiment` of results.json
  std::vector<Scene> scenes;
  nlohmann::json composite;  // `composite` of results.json; null: there is none
  std::optional<SweepText> sweep;
  std::vector<ThresholdSpec> thresholds;
  std::string resolved;  // the text of experiment.resolved.toml
};

ExperimentRecord record_of(const ExperimentSpec& experiment, const std::vector<ScenePlan>& scenes);

// The record as JSON and back, to the last bit. Throws nlohmann::json::exception if it is no record.
nlohmann::json record_json(const ExperimentRecord& record);
ExperimentRecord read_record(const nlohmann::json& json);

}  // namespace truescatter
