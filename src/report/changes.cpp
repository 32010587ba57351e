#include "report/changes.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "config/experiment_values.h"
#include "core/error.h"
#include "report/results_file.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Field {
  const char* name;
  const char* pointer;
};

// What a difference has to exceed to be a change.
enum class Noise {
  truth,      // in units of irradiance: the uncertainty of both truths, see truth_noise
  relative,   // the same over the RMS of the truth
  own_truth,  // as the first, of the method's own target
  none,       // any: counted, or without a bound by the truth's uncertainty
  time,       // the ranges of the repeats do not overlap
};

struct MetricField {
  const char* name;
  const char* pointer;
  Noise noise;
};

constexpr std::array<MetricField, 23> kMetrics = {
    {{"rmse", "/metrics/rmse", Noise::truth},
     {"rel_rmse", "/metrics/rel_rmse", Noise::relative},
     {"bias", "/metrics/bias", Noise::truth},
     {"mae", "/metrics/mae", Noise::truth},
     {"p50", "/metrics/p50", Noise::truth},
     {"p95", "/metrics/p95", Noise::truth},
     {"p99", "/metrics/p99", Noise::truth},
     {"max", "/metrics/max", Noise::truth},
     {"flip", "/metrics/flip", Noise::none},
     {"flip_hdr", "/metrics/flip_hdr", Noise::none},
     {"halo_peak", "/metrics/halo/peak", Noise::none},
     {"halo_energy", "/metrics/halo/energy", Noise::none},
     {"seam_peak", "/metrics/seam/peak", Noise::none},
     {"leak_energy", "/metrics/leak/energy", Noise::none},
     {"visible_mean", "/metrics/visible/mean", Noise::none},
     {"visible_p95", "/metrics/visible/p95", Noise::none},
     {"visible_above_005", "/metrics/visible/above_005", Noise::none},
     {"visible_above_01", "/metrics/visible/above_01", Noise::none},
     {"own_rmse", "/own_target/metrics/rmse", Noise::own_truth},
     {"frame_ms", "/cost/frame_ms/median", Noise::time},
     {"passes", "/cost/passes", Noise::none},
     {"fetches_per_pixel", "/cost/fetches_per_pixel", Noise::none},
     {"bytes_per_pixel", "/cost/bytes_per_pixel", Noise::none}}};

constexpr const char* kRules =
    "changed (*): bias, mae, rmse (own_rmse too), quantiles and max by more than the uncertainties of both "
    "truths together, which is what a change of truth alone can do; rel_rmse by more than that times (1 + "
    "rel_rmse) / RMS of the truth; frame_ms where the ranges [min, max] of the repeats do not overlap; all "
    "else "
    "where it differs\n";

constexpr std::array<Field, 11> kProvenance = {{{"version", "/version"},
                                                {"commit", "/commit"},
                                                {"commit_dirty", "/commit_dirty"},
                                                {"compiler", "/compiler"},
                                                {"build_type", "/build_type"},
                                                {"instruction_set", "/instruction_set"},
                                                {"gl_context", "/gl_context"},
                                                {"gl_renderer", "/gl_renderer"},
                                                {"gl_version", "/gl_version"},
                                                {"rasteriser_threads", "/rasteriser_threads"},
                                                {"processor", "/machine/processor"}}};

json at_pointer(const json& object, const char* pointer) {
  const json::json_pointer p(pointer);
  return object.contains(p) ? object.at(p) : json();
}

// Scene, view, profile, label.
using RunName = std::array<std::string, 4>;

RunName name_of(const json& run) {
  const fs::path scene(run.at("scene").get<std::string>());
  return {scene.filename().string(), run.at("view").get<std::string>(), run.at("profile").get<std::string>(),
          run.at("label").get<std::string>()};
}

json name_json(const RunName& name) {
  return {{"scene", name[0]}, {"view", name[1]}, {"profile", name[2]}, {"label", name[3]}};
}

// A run with the uncertainties of its truth and of its own target's, in units of irradiance; null where the
// results do not say.
struct NamedRun {
  json run;
  json uncertainty;
  json own_uncertainty;
};

// The largest irradiance of a run's scene: a sweep has one for each value.
json largest_irradiance(const json& results, const json& run) {
  const json index = at_pointer(run, "/sweep/index");
  if (!index.is_number_unsigned()) return at_pointer(results, "/scene/largest_irradiance");
  const std::string point =
      fmt::format("/sweep/points/{}/scene/largest_irradiance", index.get<std::size_t>());
  return at_pointer(results, point.c_str());
}

json uncertainty_of(const json& results, const json& run, const json& id) {
  const json largest = largest_irradiance(results, run);
  if (!largest.is_number() || !id.is_string()) return {};
  for (const json& truth : results.value("truths", json::array())) {
    if (truth.value("id", json()) != id || !truth.value("uncertainty", json()).is_number()) continue;
    return truth.at("uncertainty").get<double>() * largest.get<double>();
  }
  return {};
}

std::map<RunName, NamedRun> runs_by_name(const json& results, const fs::path& folder) {
  std::map<RunName, NamedRun> runs;
  for (const json& run : results.at("runs")) {
    const RunName name = name_of(run);
    if (!runs.emplace(name, NamedRun{run, uncertainty_of(results, run, at_pointer(run, "/truth")),
                                     uncertainty_of(results, run, at_pointer(run, "/own_target/truth"))})
             .second) {
      throw_input_error({(folder / "results.json").string()}, "two runs have the name {}",
                        fmt::join(name, " / "));
    }
  }
  return runs;
}

// How far a metric in units of irradiance may move when nothing but the truth does: where the truth moves by
// at most u at every pixel, so does every error, and with it bias, MAE, RMSE, each quantile of |e| and the
// maximum.
json sum_of(const json& before, const json& after) {
  if (!before.is_number() || !after.is_number()) return {};
  return before.get<double>() + after.get<double>();
}

json truth_noise(const NamedRun& before, const NamedRun& after) {
  return sum_of(before.uncertainty, after.uncertainty);
}

// The same of rmse / rms, to first order: u / rms, and rel_rmse times the change of the RMS, u / rms.
json relative_noise(const NamedRun& before, const NamedRun& after) {
  const json noise = truth_noise(before, after);
  const json rmse = at_pointer(before.run, "/metrics/rmse");
  const json relative = at_pointer(before.run, "/metrics/rel_rmse");
  if (!noise.is_number() || !rmse.is_number() || !relative.is_number()) return {};
  if (!(rmse.get<double>() > 0.0) || !(relative.get<double>() > 0.0)) return {};
  const double rms = rmse.get<double>() / relative.get<double>();
  return noise.get<double>() * (1.0 + relative.get<double>()) / rms;
}

// Of the repeats of a frame; null where there are fewer than two, for one says nothing of its noise.
json range_of(const json& run) {
  const json repeats = at_pointer(run, "/cost/frame_ms/repeats");
  if (!repeats.is_number() || repeats.get<double>() < 2.0) return {};
  const json least = at_pointer(run, "/cost/frame_ms/min");
  const json most = at_pointer(run, "/cost/frame_ms/max");
  if (!least.is_number() || !most.is_number()) return {};
  return {least, most};
}

json noise_of(Noise kind, const NamedRun& before, const NamedRun& after) {
  if (kind == Noise::truth) return truth_noise(before, after);
  if (kind == Noise::relative) return relative_noise(before, after);
  if (kind == Noise::own_truth) return sum_of(before.own_uncertainty, after.own_uncertainty);
  return {};
}

json metric_change(const MetricField& field, const NamedRun& old_run, const NamedRun& new_run) {
  const json old_value = at_pointer(old_run.run, field.pointer);
  const json new_value = at_pointer(new_run.run, field.pointer);
  json object = {{"old", old_value}, {"new", new_value}, {"change", nullptr}, {"changed", nullptr}};
  if (!old_value.is_number() || !new_value.is_number()) {
    object["change_reason"] = "a value is missing";
    object["changed"] = old_value.is_number() != new_value.is_number();
    return object;
  }
  const double before = old_value.get<double>();
  const double after = new_value.get<double>();
  if (before == 0.0 && after != 0.0) {
    object["change_reason"] = "the old value is 0";
  } else {
    object["change"] = before == after ? 0.0 : (after - before) / std::abs(before);
  }
  const json noise = noise_of(field.noise, old_run, new_run);
  if (noise.is_number()) object["noise"] = noise;
  object["changed"] = std::abs(after - before) > (noise.is_number() ? noise.get<double>() : 0.0);
  if (field.noise != Noise::time) return object;
  object["old_range"] = range_of(old_run.run);
  object["new_range"] = range_of(new_run.run);
  if (is_time_shared(old_run.run) || is_time_shared(new_run.run)) {
    object["changed"] = nullptr;
    object["changed_reason"] = "other work ran on the machine while a side was timed";
  } else if (object["old_range"].is_null() || object["new_range"].is_null()) {
    object["changed"] = nullptr;
    object["changed_reason"] = "fewer than two repeats on a side say nothing of noise";
  } else {
    object["changed"] =
        object["old_range"][1] < object["new_range"][0] || object["new_range"][1] < object["old_range"][0];
  }
  return object;
}

json run_change(const RunName& name, const NamedRun& old_run, const NamedRun& new_run) {
  json object = name_json(name);
  object["changed"] = json::array();
  for (const MetricField& field : kMetrics) {
    json change = metric_change(field, old_run, new_run);
    if (change.at("changed") == true) object["changed"].push_back(field.name);
    object["metrics"][field.name] = std::move(change);
  }
  return object;
}

json provenance_changes(const json& old_results, const json& new_results) {
  json changes = json::object();
  const json before = old_results.value("provenance", json::object());
  const json after = new_results.value("provenance", json::object());
  for (const Field& field : kProvenance) {
    const json old_value = at_pointer(before, field.pointer);
    const json new_value = at_pointer(after, field.pointer);
    if (old_value != new_value) changes[field.name] = {{"old", old_value}, {"new", new_value}};
  }
  return changes;
}

json experiment_changes(const fs::path& old_file, const fs::path& new_file) {
  const std::map<std::string, std::string> before = experiment_values(old_file);
  const std::map<std::string, std::string> after = experiment_values(new_file);
  std::set<std::string> keys;
  for (const auto& [key, value] : before) keys.insert(key);
  for (const auto& [key, value] : after) keys.insert(key);
  const auto value_of = [](const std::map<std::string, std::string>& values, const std::string& key) {
    const auto at = values.find(key);
    return at != values.end() ? json(at->second) : json();
  };
  json changes = json::object();
  for (const std::string& key : keys) {
    const json old_value = value_of(before, key);
    const json new_value = value_of(after, key);
    if (old_value != new_value) changes[key] = {{"old", old_value}, {"new", new_value}};
  }
  return changes;
}

void put_experiment(json& changes, const fs::path& old_folder, const fs::path& new_folder) {
  constexpr const char* kName = "experiment.resolved.toml";
  changes["experiment"] = nullptr;
  for (const fs::path& folder : {old_folder, new_folder}) {
    if (fs::is_regular_file(folder / kName)) continue;
    changes["experiment_reason"] = fmt::format("there is no {}", (folder / kName).string());
    return;
  }
  changes["experiment"] = experiment_changes(old_folder / kName, new_folder / kName);
}

void put_runs(json& changes, const std::map<RunName, NamedRun>& before,
              const std::map<RunName, NamedRun>& after) {
  for (const char* key : {"runs", "only_old", "only_new"}) changes[key] = json::array();
  for (const auto& [name, run] : before) {
    const auto same = after.find(name);
    if (same == after.end()) {
      changes["only_old"].push_back(name_json(name));
    } else {
      changes["runs"].push_back(run_change(name, run, same->second));
    }
  }
  for (const auto& [name, run] : after) {
    if (before.count(name) == 0) changes["only_new"].push_back(name_json(name));
  }
}

std::string number_text(const json& value) {
  return value.is_number() ? fmt::format("{:.6g}", value.get<double>()) : "-";
}

std::string change_text(const json& metric) {
  const json& change = metric.at("change");
  std::string text = change.is_number() ? fmt::format("{:+.2f} %", 100.0 * change.get<double>()) : "";
  if (metric.at("changed") == true) return text + (text.empty() ? "*" : " *");
  if (metric.contains("changed_reason"))
    return text + fmt::format(" ({})", metric.at("changed_reason").get<std::string>());
  if (metric.contains("noise"))
    return text + fmt::format(" (noise {:.2g})", metric.at("noise").get<double>());
  if (metric.contains("old_range")) {
    return text + fmt::format(" (within [{:.4g}, {:.4g}] and [{:.4g}, {:.4g}])",
                              metric["old_range"][0].get<double>(), metric["old_range"][1].get<double>(),
                              metric["new_range"][0].get<double>(), metric["new_range"][1].get<double>());
  }
  return text;
}

// What differs of a run, a line each.
std::string metrics_text(const json& metrics) {
  std::string text;
  for (const MetricField& field : kMetrics) {
    const json& metric = metrics.at(field.name);
    if (metric.at("old") == metric.at("new")) continue;
    std::string line = fmt::format("  {:<17} {:>12} -> {:<12} {}", field.name, number_text(metric.at("old")),
                                   number_text(metric.at("new")), change_text(metric));
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text.empty() ? "  the same\n" : text;
}

std::string plain_text(const json& value) {
  if (value.is_null()) return "(none)";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string differences_text(const std::string& title, const json& changes) {
  if (changes.empty()) return title + ": the same\n";
  std::string text = title + ":\n";
  for (const auto& [key, value] : changes.items())
    text += fmt::format("  {}: {} -> {}\n", key, plain_text(value.at("old")), plain_text(value.at("new")));
  return text;
}

std::string name_text(const json& run) {
  std::vector<std::string> parts;
  for (const char* key : {"scene", "view", "profile", "label"}) parts.push_back(run.at(key));
  return fmt::format("{}", fmt::join(parts, " / "));
}

}  // namespace

json result_changes(const fs::path& old_folder, const fs::path& new_folder) {
  const auto read = [](const fs::path& folder) {
    json results = read_results(folder);
    try {
      return std::pair(results, runs_by_name(results, folder));
    } catch (const json::exception& problem) {
      throw_input_error({(folder / "results.json").string()},
                        "the results are not laid out as their schema says: {}", problem.what());
    }
  };
  const auto [old_results, old_runs] = read(old_folder);
  const auto [new_results, new_runs] = read(new_folder);
  json changes = {
      {"schema", "truescatter-changes-1"}, {"old", old_folder.string()}, {"new", new_folder.string()}};
  changes["provenance"] = provenance_changes(old_results, new_results);
  put_experiment(changes, old_folder, new_folder);
  put_runs(changes, old_runs, new_runs);
  return changes;
}

std::string changes_text(const json& changes) {
  std::string text =
      fmt::format("old: {}\nnew: {}\n", plain_text(changes.at("old")), plain_text(changes.at("new")));
  text += differences_text("provenance", changes.at("provenance"));
  text += changes.at("experiment").is_null()
              ? fmt::format("experiment: not compared, {}\n", plain_text(changes.at("experiment_reason")))
              : differences_text("experiment", changes.at("experiment"));
  if (!changes.at("runs").empty()) text += kRules;
  for (const json& run : changes.at("runs"))
    text += fmt::format("{}\n{}", name_text(run), metrics_text(run.at("metrics")));
  for (const auto& [key, where] : {std::pair("only_old", "old"), std::pair("only_new", "new")}) {
    for (const json& run : changes.at(key))
      text += fmt::format("only in the {}: {}\n", where, name_text(run));
  }
  return text;
}

}  // namespace truescatter
