#include "experiment/ladder.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "metrics/error_stats.h"

namespace truescatter {
namespace {

using nlohmann::json;

double largest_gap(const Image& first, const Image& last, const std::list<LadderStep>& steps,
                   const Image& mask) {
  double gap = 0.0;
  constexpr std::size_t kChannels = 3;
  for (std::size_t i = 0; i < kChannels * mask.data().size(); ++i) {
    if (mask.data()[i / kChannels] == 0.0F) continue;
    double sum = 0.0;
    for (const LadderStep& step : steps) sum += step.error.data()[i];
    const double whole = static_cast<double>(last.data()[i]) - static_cast<double>(first.data()[i]);
    gap = std::max(gap, std::abs(sum - whole));
  }
  return gap;
}

}  // namespace

std::list<LadderStep> ladder_steps(const std::vector<LadderRung>& rungs, const Image& mask) {
  std::list<LadderStep> steps;
  for (std::size_t r = 1; r < rungs.size(); ++r)
    steps.push_back({rungs[r].name, signed_error(*rungs[r].exitance, *rungs[r - 1].exitance, mask)});
  return steps;
}

json ladder_json(const std::vector<LadderRung>& rungs, const std::list<LadderStep>& steps,
                 const MetricInputs& inputs) {
  assert(rungs.size() >= 2 && steps.size() + 1 == rungs.size());
  assert(&inputs.truth == rungs.front().exitance);
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
  return {
      {"rungs", list},
      {"telescopes",
       {{"sum_of_step_biases", sum_of_biases},
        {"bias_so_far", list.back()["so_far"]["bias"]},
        {"largest_gap", largest_gap(*rungs.front().exitance, *rungs.back().exitance, steps, inputs.mask)}}}};
}

}  // namespace truescatter
