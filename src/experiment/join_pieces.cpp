#include "experiment/join_pieces.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <iterator>
#include <string>

#include "metrics/map_picture.h"

namespace truescatter {
namespace {

using nlohmann::json;

void append(json& list, const json& more) {
  for (const json& entry : more) list.push_back(entry);
}

void add_profiles(const json& of_scene, json& profiles) {
  for (const json& profile : of_scene) {
    const bool known = std::any_of(profiles.begin(), profiles.end(),
                                   [&](const json& other) { return other["name"] == profile["name"]; });
    if (!known) profiles.push_back(profile);
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

void add_pictures(const std::vector<Piece>& of_scene, bool composites, const PieceStore& pieces,
                  std::vector<ViewPictures>& views) {
  for (const Piece& piece : of_scene) {
    const json finished = pieces.read(piece);
    switch (piece.kind) {
      case Piece::Kind::view:
        views.push_back({piece.view, pieces.picture(piece), finished["exposure"].get<double>()});
        views.back().composites = composites;
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
}

}  // namespace

json join_pieces(const ExperimentRecord& record, const PieceStore& pieces) {
  json results = {{"experiment", record.experiment}};
  for (const char* list :
       {"profiles", "views", "truths", "fit_errors", "light_paths", "runs", "ladders", "stability"})
    results[list] = json::array();
  std::vector<json> described;
  for (const ExperimentRecord::Scene& scene : record.scenes) {
    add_profiles(scene.profiles, results["profiles"]);
    const std::size_t first_view = results["views"].size();
    const std::size_t first_run = results["runs"].size();
    const std::size_t first_ladder = results["ladders"].size();
    for (const Piece& piece : scene.pieces) add_piece(piece, pieces.read(piece), first_ladder, results);
    described.push_back(results["scene"]);
    if (scene.mark) mark_sweep(*scene.mark, first_view, first_run, results);
  }
  if (!record.composite.is_null()) results["composite"] = record.composite;
  // What is said of the scene is said of the first.
  results["scene"] = described.front();
  if (record.sweep) results["sweep"] = sweep_json(*record.sweep, described, results);
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

std::vector<ViewPictures> pictures_of(const ExperimentRecord& record, const PieceStore& pieces) {
  std::vector<ViewPictures> views;
  for (const ExperimentRecord::Scene& scene : record.scenes)
    add_pictures(scene.pieces, !record.composite.is_null(), pieces, views);
  return views;
}

}  // namespace truescatter
