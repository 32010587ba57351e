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

constexpr std::array<Field, 9> kMetrics = {{{"rmse", "/metrics/rmse"},
                                            {"rel_rmse", "/metrics/rel_rmse"},
                                            {"bias", "/metrics/bias"},
                                            {"max", "/metrics/max"},
                                            {"flip", "/metrics/flip"},
                                            {"flip_hdr", "/metrics/flip_hdr"},
                                            {"halo_peak", "/metrics/halo/peak"},
                                            {"frame_ms", "/cost/frame_ms/median"},
                                            {"fetches_per_pixel", "/cost/fetches_per_pixel"}}};

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

std::map<RunName, json> runs_by_name(const json& results, const fs::path& folder) {
  std::map<RunName, json> runs;
  for (const json& run : results.at("runs")) {
    const RunName name = name_of(run);
    if (!runs.emplace(name, run).second) {
      throw_input_error({(folder / "results.json").string()}, "two runs have the name {}",
                        fmt::join(name, " / "));
    }
  }
  return runs;
}

json metric_change(const json& old_value, const json& new_value) {
  json object = {{"old", old_value}, {"new", new_value}, {"change", nullptr}};
  if (!old_value.is_number() || !new_value.is_number()) {
    object["change_reason"] = "a value is missing";
    return object;
  }
  const double before = old_value.get<double>();
  const double after = new_value.get<double>();
  if (before == 0.0 && after != 0.0) {
    object["change_reason"] = "the old value is 0";
  } else {
    object["change"] = before == after ? 0.0 : (after - before) / std::abs(before);
  }
  return object;
}

json run_change(const RunName& name, const json& old_run, const json& new_run) {
  json object = name_json(name);
  for (const Field& metric : kMetrics) {
    object["metrics"][metric.name] =
        metric_change(at_pointer(old_run, metric.pointer), at_pointer(new_run, metric.pointer));
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

void put_runs(json& changes, const std::map<RunName, json>& before, const std::map<RunName, json>& after) {
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
  if (!change.is_number()) return "";
  return change == 0.0 ? "=" : fmt::format("{:+.2f} %", 100.0 * change.get<double>());
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
  for (const json& run : changes.at("runs")) {
    text += fmt::format("{}\n", name_text(run));
    for (const Field& field : kMetrics) {
      const json& metric = run.at("metrics").at(field.name);
      std::string line =
          fmt::format("  {:<17} {:>12} -> {:<12} {}", field.name, number_text(metric.at("old")),
                      number_text(metric.at("new")), change_text(metric));
      line.erase(line.find_last_not_of(' ') + 1);
      text += line + "\n";
    }
  }
  for (const auto& [key, where] : {std::pair("only_old", "old"), std::pair("only_new", "new")}) {
    for (const json& run : changes.at(key))
      text += fmt::format("only in the {}: {}\n", where, name_text(run));
  }
  return text;
}

}  // namespace truescatter
