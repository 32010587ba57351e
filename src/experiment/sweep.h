#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/experiment_spec.h"

namespace truescatter {

// The experiments that a run is made of: of a sweep one for each value, else itself. In a sweep, views have
// the value's number behind their names, as "front-03", so that all results have names of their own; and so
// do the profiles that an experiment spells out, where a key is one of a profile's.
std::vector<ExperimentSpec> sweep_points(const ExperimentSpec& spec);

// What results say of a value's views and runs.
struct SweepMark {
  std::size_t index;
  double axis;
  std::map<std::string, std::string> views;     // their names with the number, and without
  std::map<std::string, std::string> profiles;  // the same
};
SweepMark sweep_mark(const SweepSpec& sweep, std::size_t point);

// What they say of the sweep itself.
struct SweepText {
  std::vector<std::string> keys;
  std::vector<std::string> values;  // as TOML
  std::vector<double> axis;
  std::string title;
  std::string unit;
  std::string difficulty;
  std::string scale;
};
SweepText sweep_text(const SweepSpec& sweep);

// Says of what a point has added to views[] and runs[] which value it belongs to: `sweep` has its index, its
// place on the axis, and the view's and the profile's names without the number. `first_view`, `first_run`:
// how many entries were there before.
void mark_sweep(const SweepMark& mark, std::size_t first_view, std::size_t first_run,
                nlohmann::json& results);

// The `sweep` object of results.json: keys, title, unit, difficulty and scale; `points`, the values in the
// order given, with their scenes; and `curves`, for each view, profile and method (label) `points`, the run's
// errors at each value from easy to hard, and `breaks_at`, where its rel_rmse passes 2, 5 and 10 %
// (break_point.h), null with the reason where it does not, `only_rises` (by more than a twentieth of it), and
// by the same rule `own_breaks_at` of its error against its own target. `scenes`: of each point.
nlohmann::json sweep_json(const SweepText& sweep, const std::vector<nlohmann::json>& scenes,
                          const nlohmann::json& results);

}  // namespace truescatter
