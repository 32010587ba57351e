#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/experiment_spec.h"

namespace truescatter {

// The version of the results.json format.
inline constexpr const char* kResultsSchema = "truescatter-results-1";

// One row a run: the headline metrics and costs of results.json as CSV. Missing values are empty.
std::string results_csv(const nlohmann::json& results);

// A line for every run of `results` that exceeds one of the thresholds (of |metric|).
std::vector<std::string> exceeded_thresholds(const nlohmann::json& results,
                                             const std::vector<ThresholdSpec>& thresholds);

}  // namespace truescatter
