#include "experiment/ladder.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "metrics/error_stats.h"

namespace truescatter {
namespace {

using nlohmann::json;

// The steps' sum at every pixel against the whole difference.
double largest_gap(const std::vector<LadderRung>& rungs, const Image& mask) {
  double gap = 0.0;
  const std::size_t channels = 3;
  for (std::size_t i = 0; i < mask.data().size(); ++i) {
    if (mask.data()[i] == 0.0F) continue;
    for (std::size_t c = 0; c < channels; ++c) {
      const auto at = [&](std::size_t r) {
        return static_cast<double>(rungs[r].exitance->data()[channels * i + c]);
      };
      double sum = 0.0;
      for (std::size_t r = 1; r < rungs.size(); ++r) sum += at(r) - at(r - 1);
      gap = std::max(gap, std::abs(sum - (at(rungs.size() - 1) - at(0))));
    }
  }
  return gap;
}

}  // namespace

Image ladder_step(const LadderRung& rung, const LadderRung& above, const Image& mask) {
  return signed_error(*rung.exitance, *above.exitance, mask);
}

json ladder_json(const std::vector<LadderRung>& rungs, const MetricInputs& inputs) {
  assert(rungs.size() >= 2 && &inputs.truth == rungs.front().exitance);
  json list = json::array();
  double sum_of_biases = 0.0;
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    json rung = {{"rung", rungs[r].name}, {"assumption", rungs[r].assumption}};
    if (r > 0) {
      rung["step"] = error_stats_json(*rungs[r].exitance, *rungs[r - 1].exitance, inputs.mask);
      const json& bias = rung["step"]["bias"];
      if (bias.is_number()) sum_of_biases += bias.get<double>();
      rung["so_far"] = metrics_json(*rungs[r].exitance, inputs);
    }
    list.push_back(rung);
  }
  return {{"rungs", list},
          {"telescopes",
           {{"sum_of_step_biases", sum_of_biases},
            {"bias_so_far", list.back()["so_far"]["bias"]},
            {"largest_gap", largest_gap(rungs, inputs.mask)}}}};
}

}  // namespace truescatter
