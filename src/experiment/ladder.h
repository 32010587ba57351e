#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/image.h"
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
// so far, to rounding in double precision; `telescopes` holds both sums and the largest difference at any
// pixel and channel.
nlohmann::json ladder_json(const std::vector<LadderRung>& rungs, const MetricInputs& inputs);

// The signed difference of a rung from the one above, 0 outside of the mask.
Image ladder_step(const LadderRung& rung, const LadderRung& above, const Image& mask);

}  // namespace truescatter
