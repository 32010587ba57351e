#include "experiment/sweep.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "metrics/break_point.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr std::array<double, 3> kLevels = {0.02, 0.05, 0.10};
constexpr double kFall = 0.05;  // of an error: what is less is no fall

std::string numbered(const std::string& name, std::size_t point) {
  return fmt::format("{}-{:02}", name, point + 1);
}

bool changes_profiles(const SweepSpec& sweep) {
  return std::any_of(sweep.keys.begin(), sweep.keys.end(),
                     [](const std::string& key) { return key.starts_with("profile."); });
}

ExperimentSpec point_of(const SweepSpec& sweep, std::size_t index) {
  ExperimentSpec point = sweep.point[index];
  for (ViewSpec& view : point.views) view.name = numbered(view.name, index);
  if (point.stability && !point.stability->view.empty())
    point.stability->view = numbered(point.stability->view, index);
  if (!changes_profiles(sweep)) return point;
  for (ProfileSpec& profile : point.profiles) {
    if (!profile.builtin) profile.name = numbered(profile.name, index);
  }
  return point;
}

json value_at(const json& object, const char* pointer) {
  const json::json_pointer p(pointer);
  return object.contains(p) ? object.at(p) : json();
}

double number_at(const json& object, const char* key) {
  const json value = object.value(key, json());
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

json curve_point(const json& run) {
  static constexpr std::array<std::array<const char*, 2>, 10> kQuantities = {
      {{"rel_rmse", "/metrics/rel_rmse"},
       {"rmse", "/metrics/rmse"},
       {"bias", "/metrics/bias"},
       {"p99", "/metrics/p99"},
       {"max", "/metrics/max"},
       {"halo_peak", "/metrics/halo/peak"},
       {"visible_mean", "/metrics/visible/mean"},
       {"visible_p95", "/metrics/visible/p95"},
       {"own_rel_rmse", "/own_target/metrics/rel_rmse"},
       {"fetches_per_pixel", "/cost/fetches_per_pixel"}}};
  json point = {{"index", run["sweep"]["index"]}, {"axis", run["sweep"]["axis"]}, {"view", run["view"]}};
  for (const auto& [name, pointer] : kQuantities) point[name] = value_at(run, pointer);
  if (run.contains("skipped")) point["skipped"] = run["skipped"];
  return point;
}

json breaks_json(const DifficultyCurve& curve) {
  json breaks = json::object();
  for (const double level : kLevels) {
    const std::string name = fmt::format("{:g}%", 100.0 * level);
    const BreakPoint found = break_point(curve, level);
    breaks[name] = found.value ? json(*found.value) : json();
    if (!found.value) breaks[name + "_reason"] = found.reason;
  }
  return breaks;
}

DifficultyCurve curve_of(const json& points, const char* quantity, bool log_axis) {
  DifficultyCurve curve;
  curve.log_axis = log_axis;
  for (const json& point : points) {
    curve.axis.push_back(point["axis"].get<double>());
    curve.error.push_back(number_at(point, quantity));
  }
  return curve;
}

void add_breaks(json& curve, bool log_axis) {
  const DifficultyCurve headline = curve_of(curve["points"], "rel_rmse", log_axis);
  curve["breaks_at"] = breaks_json(headline);
  curve["own_breaks_at"] = breaks_json(curve_of(curve["points"], "own_rel_rmse", log_axis));
  double largest = 0.0;
  for (const double error : headline.error) {
    if (std::isfinite(error)) largest = std::max(largest, error);
  }
  curve["only_rises"] = only_rises(headline, kFall * largest);
}

}  // namespace

std::vector<ExperimentSpec> sweep_points(const ExperimentSpec& spec) {
  if (!spec.sweep) return {spec};
  std::vector<ExperimentSpec> points;
  for (std::size_t i = 0; i < spec.sweep->point.size(); ++i) points.push_back(point_of(*spec.sweep, i));
  return points;
}

SweepMark sweep_mark(const SweepSpec& sweep, std::size_t point) {
  const ExperimentSpec& base = sweep.point[point];
  const ExperimentSpec named = point_of(sweep, point);
  SweepMark mark{point, sweep.axis[point], {}, {}};
  for (std::size_t v = 0; v < named.views.size(); ++v) mark.views[named.views[v].name] = base.views[v].name;
  for (std::size_t p = 0; p < named.profiles.size(); ++p)
    mark.profiles[named.profiles[p].name] = base.profiles[p].name;
  return mark;
}

SweepText sweep_text(const SweepSpec& sweep) {
  SweepText text{sweep.keys, {}, sweep.axis, sweep.title, sweep.unit, sweep.difficulty, sweep.scale};
  for (const std::vector<std::string>& value : sweep.values)
    text.values.push_back(fmt::format("{}", fmt::join(value, ", ")));
  return text;
}

void mark_sweep(const SweepMark& mark, std::size_t first_view, std::size_t first_run, json& results) {
  const auto set = [&](json& entry, const std::string& view) {
    entry["sweep"] = {{"index", mark.index}, {"axis", mark.axis}, {"view", mark.views.at(view)}};
  };
  for (std::size_t v = first_view; v < results["views"].size(); ++v) {
    json& view = results["views"][v];
    set(view, view["name"].get<std::string>());
  }
  for (std::size_t r = first_run; r < results["runs"].size(); ++r) {
    json& run = results["runs"][r];
    set(run, run["view"].get<std::string>());
    run["sweep"]["profile"] = mark.profiles.at(run["profile"].get<std::string>());
  }
}

json sweep_json(const SweepText& sweep, const std::vector<json>& scenes, const json& results) {
  json points = json::array();
  for (std::size_t i = 0; i < sweep.axis.size(); ++i) {
    points.push_back({{"axis", sweep.axis[i]}, {"value", sweep.values[i]}, {"scene", scenes[i]}});
  }
  json curves = json::array();
  for (const json& run : results["runs"]) {
    json name = {{"view", run["sweep"]["view"]},
                 {"profile", run["sweep"]["profile"]},
                 {"method", run["method"]},
                 {"label", run["label"]}};
    auto curve = std::find_if(curves.begin(), curves.end(), [&](const json& known) {
      return known["view"] == name["view"] && known["profile"] == name["profile"] &&
             known["label"] == name["label"];
    });
    if (curve == curves.end()) {
      name["points"] = json::array();
      curves.push_back(name);
      curve = curves.end() - 1;
    }
    (*curve)["points"].push_back(curve_point(run));
  }
  // Values that fall, in a difficulty that grows with them, were given from hard to easy; and the other way
  // round.
  const bool falls = sweep.axis.back() < sweep.axis.front();
  const bool hard_first = falls == (sweep.difficulty == "up");
  for (json& curve : curves) {
    if (hard_first) std::reverse(curve["points"].begin(), curve["points"].end());
    add_breaks(curve, sweep.scale == "log");
  }
  return {{"keys", sweep.keys},         {"title", sweep.title},
          {"unit", sweep.unit},         {"difficulty", sweep.difficulty},
          {"scale", sweep.scale},       {"points", std::move(points)},
          {"curves", std::move(curves)}};
}

}  // namespace truescatter
