#include "experiment/join_pieces.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <iterator>
#include <string>

#include "experiment/result_json.h"
#include "experiment/sweep.h"
#include "metrics/map_picture.h"

namespace truescatter {
namespace {

using nlohmann::json;

void append(json& list, const json& more) {
  for (const json& entry : more) list.push_back(entry);
}

void add_profiles(const ScenePlan& scene, json& profiles) {
  for (std::size_t i = 0; i < scene.plan.profiles.size(); ++i) {
    const Profile& profile = scene.plan.profiles[i];
    const bool known = std::any_of(profiles.begin(), profiles.end(),
                                   [&](const json& other) { return other["name"] == profile.name; });
    if (known) continue;
    profiles.push_back(profile_json(profile));
    if (const auto fit = scene.plan.fits.find(profile.name); fit != scene.plan.fits.end()) {
      profiles.back()["fit"] = profile_fit_json(scene.plan.approximated.at(profile.name),
                                                *scene.spec.profiles[i].fit, fit->second);
    }
    if (const ProfileModel* model = scene.plan.model_of(profile))
      profiles.back()["of"] = profile_model_json(*model);
  }
}

// Gives every run of a view the spread of its error over derived views.
void add_stability(const Piece& piece, const json& measured, json& results) {
  append(results["stability"], measured["stability"]);
  for (json& run : results["runs"]) {
    if (run["view"] != piece.view || !run.contains("metrics")) continue;
    const auto found =
        std::find_if(measured["runs"].begin(), measured["runs"].end(), [&](const json& spread) {
          return spread["profile"] == run["profile"] && spread["label"] == run["label"];
        });
    assert(found != measured["runs"].end());
    run["metrics"].update((*found)["metrics"], true);
  }
}

// Gives every rung of a scene's ladders the width of its filter.
void add_widths(const json& widths, std::size_t first_ladder, json& ladders) {
  for (std::size_t i = first_ladder; i < ladders.size(); ++i) {
    if (!ladders[i].contains("rungs")) continue;
    for (json& rung : ladders[i]["rungs"]) {
      const auto found = std::find_if(widths.begin(), widths.end(), [&](const json& width) {
        return width["profile"] == ladders[i]["profile"] && width["rung"] == rung["rung"];
      });
      assert(found != widths.end());
      rung["filter_width"] = (*found)["filter_width"];
    }
  }
}

void add_piece(const Piece& piece, const json& finished, std::size_t first_ladder, json& results) {
  switch (piece.kind) {
    case Piece::Kind::view:
      results["views"].push_back(finished["view"]);
      results["scene"] = finished["scene"];
      return;
    case Piece::Kind::truth:
      for (const char* list : {"truths", "fit_errors", "light_paths"}) append(results[list], finished[list]);
      return;
    case Piece::Kind::run:
      results["runs"].push_back(finished);
      return;
    case Piece::Kind::ladder:
      results["ladders"].push_back(finished);
      return;
    case Piece::Kind::stability:
      add_stability(piece, finished, results);
      return;
    case Piece::Kind::widths:
      add_widths(finished, first_ladder, results["ladders"]);
      return;
  }
}

// The median rounded up; 1 where there is nothing.
double range_of(std::vector<double> quantiles) {
  if (quantiles.empty()) return 1.0;
  const auto middle = quantiles.begin() + static_cast<std::ptrdiff_t>(quantiles.size() / 2);
  std::nth_element(quantiles.begin(), middle, quantiles.end());
  return *middle > 0.0 ? round_range(*middle) : 1.0;
}

void add_quantile(const json& measured, const char* what, std::vector<double>& quantiles) {
  if (measured.contains(what) && measured[what]["p99"].is_number())
    quantiles.push_back(measured[what]["p99"].get<double>());
}

}  // namespace

std::vector<ScenePlan> scene_plans(const std::vector<ExperimentSpec>& points,
                                   const std::vector<Plan>& plans) {
  assert(points.size() == plans.size());
  std::vector<ScenePlan> scenes;
  for (std::size_t i = 0; i < points.size(); ++i) scenes.push_back({points[i], plans[i]});
  return scenes;
}

json join_pieces(const ExperimentSpec& experiment, const std::vector<ScenePlan>& scenes,
                 const PieceStore& pieces) {
  json results = {{"experiment",
                   {{"name", experiment.name},
                    {"question", experiment.question},
                    {"expectation", experiment.expectation},
                    {"source", experiment.source}}}};
  for (const char* list :
       {"profiles", "views", "truths", "fit_errors", "light_paths", "runs", "ladders", "stability"})
    results[list] = json::array();
  std::vector<json> described;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    add_profiles(scenes[i], results["profiles"]);
    const std::size_t first_view = results["views"].size();
    const std::size_t first_run = results["runs"].size();
    const std::size_t first_ladder = results["ladders"].size();
    for (const Piece& piece : pieces_of(scenes[i].spec, scenes[i].plan))
      add_piece(piece, pieces.read(piece), first_ladder, results);
    described.push_back(results["scene"]);
    if (experiment.sweep) mark_sweep(experiment, i, first_view, first_run, results);
  }
  if (experiment.composite) results["composite"] = composite_json(*experiment.composite);
  // What is said of the scene is said of the first.
  results["scene"] = described.front();
  if (experiment.sweep) results["sweep"] = sweep_json(*experiment.sweep, described, results);
  return results;
}

MapRanges common_ranges(const json& results) {
  std::vector<double> errors;
  for (const json& run : results["runs"]) add_quantile(run, "metrics", errors);
  std::vector<double> steps;
  for (const json& ladder : results["ladders"]) {
    for (const json& rung : ladder.value("rungs", json::array())) add_quantile(rung, "step", steps);
  }
  return {range_of(errors), range_of(steps)};
}

std::vector<ViewPictures> pictures_of(const ScenePlan& scene, const PieceStore& pieces) {
  std::vector<ViewPictures> views;
  for (const Piece& piece : pieces_of(scene.spec, scene.plan)) {
    const json finished = pieces.read(piece);
    switch (piece.kind) {
      case Piece::Kind::view:
        views.push_back({piece.view, pieces.picture(piece), finished["exposure"].get<double>()});
        views.back().composites = scene.spec.composite.has_value();
        break;
      case Piece::Kind::truth:
        views.back().truths.push_back(piece.stem());
        if (!finished["fit_errors"].empty()) views.back().profile_truths.push_back(profile_truth_stem(piece));
        break;
      case Piece::Kind::run:
        if (!finished.contains("skipped")) views.back().runs.push_back(piece.stem());
        break;
      case Piece::Kind::ladder:
        if (finished.contains("skipped")) break;
        views.back().ladders.push_back({piece.stem(), {}});
        for (std::size_t r = 1; r < finished["rungs"].size(); ++r)
          views.back().ladders.back().steps.push_back(finished["rungs"][r]["rung"]);
        break;
      case Piece::Kind::stability:
      case Piece::Kind::widths:
        break;
    }
  }
  return views;
}

}  // namespace truescatter
