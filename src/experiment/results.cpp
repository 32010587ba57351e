#include "experiment/results.h"

#include <fmt/format.h>

#include <cmath>

namespace truescatter {
namespace {

using nlohmann::json;

// Quoted where it has to be (RFC 4180).
std::string csv_field(const json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  const std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

json at_pointer(const json& object, const char* pointer) {
  const json::json_pointer p(pointer);
  return object.contains(p) ? object.at(p) : json();
}

// Of a threshold's metric among a run's.
json::json_pointer metric_pointer(const std::string& name) {
  constexpr std::string_view kVisible = "visible_";
  return json::json_pointer(name.starts_with(kVisible) ? "/visible/" + name.substr(kVisible.size())
                                                       : "/" + name);
}

}  // namespace

std::string results_csv(const json& results) {
  static constexpr std::array<std::array<const char*, 2>, 44> kColumns = {
      {{"view", "/view"},
       {"profile", "/profile"},
       {"method", "/method"},
       {"label", "/label"},
       {"skipped", "/skipped"},
       {"bias", "/metrics/bias"},
       {"mae", "/metrics/mae"},
       {"rmse", "/metrics/rmse"},
       {"rel_rmse", "/metrics/rel_rmse"},
       {"p50", "/metrics/p50"},
       {"p95", "/metrics/p95"},
       {"p99", "/metrics/p99"},
       {"max", "/metrics/max"},
       {"flip", "/metrics/flip"},
       {"flip_hdr", "/metrics/flip_hdr"},
       {"halo_peak", "/metrics/halo/peak"},
       {"halo_width_mm", "/metrics/halo/width_mm"},
       {"halo_energy", "/metrics/halo/energy"},
       {"halo_contrast", "/metrics/halo/contrast"},
       {"seam_peak", "/metrics/seam/peak"},
       {"seam_energy", "/metrics/seam/energy"},
       {"leak_energy", "/metrics/leak/energy"},
       {"leak_peak", "/metrics/leak/peak"},
       {"own_rmse", "/own_target/metrics/rmse"},
       {"profile_rmse", "/profile_error/metrics/rmse"},
       {"frame_ms", "/cost/frame_ms/median"},
       {"passes", "/cost/passes"},
       {"fetches_per_pixel", "/cost/fetches_per_pixel"},
       {"bytes_per_pixel", "/cost/bytes_per_pixel"},
       {"rel_rmse_r", "/metrics/channels/r/rel_rmse"},
       {"rel_rmse_g", "/metrics/channels/g/rel_rmse"},
       {"rel_rmse_b", "/metrics/channels/b/rel_rmse"},
       {"own_rel_rmse", "/own_target/metrics/rel_rmse"},
       {"own_rel_rmse_r", "/own_target/metrics/channels/r/rel_rmse"},
       {"own_rel_rmse_g", "/own_target/metrics/channels/g/rel_rmse"},
       {"own_rel_rmse_b", "/own_target/metrics/channels/b/rel_rmse"},
       // An own target that is known at a sample of pixels, and the headline's error there.
       {"own_sampled_points", "/own_target/sampled/points"},
       {"sampled_rel_rmse", "/own_target/sampled/headline_metrics/rel_rmse"},
       // The first of the truths that were asked for beside the headline.
       {"extra_rel_rmse", "/extra_targets/0/metrics/rel_rmse"},
       // FLIP between the pictures that a person sees, where they were asked for.
       {"visible_mean", "/metrics/visible/mean"},
       {"visible_p95", "/metrics/visible/p95"},
       {"visible_above_005", "/metrics/visible/above_005"},
       {"visible_above_01", "/metrics/visible/above_01"},
       // True: frame_ms was taken beside other work, or on another machine than the others.
       {"frame_ms_shared", "/cost/frame_ms/shared"}}};
  std::string text;
  for (const auto& column : kColumns) text += fmt::format("{}{}", text.empty() ? "" : ",", column[0]);
  text += "\n";
  for (const json& run : results.at("runs")) {
    std::string row;
    for (const auto& column : kColumns) row += csv_field(at_pointer(run, column[1])) + ",";
    row.back() = '\n';
    text += row;
  }
  return text;
}

std::vector<std::string> exceeded_thresholds(const json& results,
                                             const std::vector<ThresholdSpec>& thresholds) {
  std::vector<std::string> lines;
  for (const ThresholdSpec& threshold : thresholds) {
    for (const json& run : results.at("runs")) {
      if (run.at("label") != threshold.method || run.contains("skipped")) continue;
      const json& value = run.at("metrics").at(metric_pointer(threshold.metric));
      if (value.is_number() && std::abs(value.get<double>()) <= threshold.maximum) continue;
      lines.push_back(fmt::format("{}: {} of {} in view {} with {} is {}; the bound is {}",
                                  threshold.where.str(), threshold.metric, threshold.method,
                                  run.at("view").get<std::string>(), run.at("profile").get<std::string>(),
                                  value.dump(), threshold.maximum));
    }
  }
  return lines;
}

}  // namespace truescatter
