#pragma once

#include <list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/image.h"
#include "experiment/map_files.h"
#include "experiment/metrics_json.h"

namespace truescatter {

// One step of a chain of assumptions: the exitance with all of them up to this one.
struct LadderRung {
  std::string name;
  std::string assumption;
  const Image* exitance;
};

// What each assumption costs: for every rung but the first `step`, the error statistics of its exitance less
// the one above, and for every one `so_far`, the metrics against the first (inputs.truth must be its
// exitance). Signed differences telescope: at every pixel, and so in the bias, the steps sum to what there is
// so far. `telescopes` holds both sums of the bias, and the largest difference at any pixel and channel
// between the sum of the `steps` that are written and the last rung less the first: the rounding of each step
// to a float.
nlohmann::json ladder_json(const std::vector<LadderRung>& rungs, const std::list<LadderStep>& steps,
                           const MetricInputs& inputs);

// For every rung but the first its signed difference from the one above, 0 outside of the mask.
std::list<LadderStep> ladder_steps(const std::vector<LadderRung>& rungs, const Image& mask);

}  // namespace truescatter
