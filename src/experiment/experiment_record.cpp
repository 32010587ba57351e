#include "experiment/experiment_record.h"

#include <cassert>
#include <cstddef>

#include "experiment/result_json.h"

namespace truescatter {
namespace {

using nlohmann::json;

json profiles_of(const ScenePlan& scene) {
  json profiles = json::array();
  for (std::size_t i = 0; i < scene.plan.profiles.size(); ++i) {
    const Profile& profile = scene.plan.profiles[i];
    profiles.push_back(profile_json(profile));
    if (const auto fit = scene.plan.fits.find(profile.name); fit != scene.plan.fits.end()) {
      profiles.back()["fit"] = profile_fit_json(scene.plan.approximated.at(profile.name),
                                                *scene.spec.profiles[i].fit, fit->second);
    }
    if (const ProfileModel* model = scene.plan.model_of(profile))
      profiles.back()["of"] = profile_model_json(*model);
  }
  return profiles;
}

json piece_json(const Piece& piece) {
  return {{"kind", static_cast<int>(piece.kind)},
          {"view", piece.view},
          {"profile", piece.profile},
          {"name", piece.name}};
}

Piece read_piece(const json& read) {
  return {static_cast<Piece::Kind>(read.at("kind").get<int>()), read.at("view").get<std::string>(),
          read.at("profile").get<std::string>(), read.at("name").get<std::string>()};
}

json scene_json(const ExperimentRecord::Scene& scene) {
  json written = {{"profiles", scene.profiles}, {"pieces", json::array()}};
  for (const Piece& piece : scene.pieces) written["pieces"].push_back(piece_json(piece));
  if (scene.mark) {
    written["sweep"] = {{"index", scene.mark->index},
                        {"axis", scene.mark->axis},
                        {"views", scene.mark->views},
                        {"profiles", scene.mark->profiles}};
  }
  return written;
}

ExperimentRecord::Scene read_scene(const json& read) {
  ExperimentRecord::Scene scene;
  for (const json& piece : read.at("pieces")) scene.pieces.push_back(read_piece(piece));
  scene.profiles = read.at("profiles");
  if (read.contains("sweep")) {
    const json& mark = read.at("sweep");
    scene.mark = {mark.at("index").get<std::size_t>(), mark.at("axis").get<double>(),
                  mark.at("views").get<std::map<std::string, std::string>>(),
                  mark.at("profiles").get<std::map<std::string, std::string>>()};
  }
  return scene;
}

json sweep_text_json(const SweepText& sweep) {
  return {{"keys", sweep.keys},   {"values", sweep.values}, {"axis", sweep.axis},
          {"title", sweep.title}, {"unit", sweep.unit},     {"difficulty", sweep.difficulty},
          {"scale", sweep.scale}};
}

SweepText read_sweep_text(const json& read) {
  return {read.at("keys").get<std::vector<std::string>>(),
          read.at("values").get<std::vector<std::string>>(),
          read.at("axis").get<std::vector<double>>(),
          read.at("title").get<std::string>(),
          read.at("unit").get<std::string>(),
          read.at("difficulty").get<std::string>(),
          read.at("scale").get<std::string>()};
}

}  // namespace

std::vector<ScenePlan> scene_plans(const std::vector<ExperimentSpec>& points,
                                   const std::vector<Plan>& plans) {
  assert(points.size() == plans.size());
  std::vector<ScenePlan> scenes;
  for (std::size_t i = 0; i < points.size(); ++i) scenes.push_back({points[i], plans[i]});
  return scenes;
}

ExperimentRecord record_of(const ExperimentSpec& experiment, const std::vector<ScenePlan>& scenes) {
  ExperimentRecord record;
  record.experiment = {{"name", experiment.name},
                       {"question", experiment.question},
                       {"expectation", experiment.expectation},
                       {"source", experiment.source}};
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    record.scenes.push_back(
        {pieces_of(scenes[i].spec, scenes[i].plan), profiles_of(scenes[i]), std::nullopt});
    if (experiment.sweep) record.scenes.back().mark = sweep_mark(*experiment.sweep, i);
  }
  if (experiment.composite) record.composite = composite_json(*experiment.composite);
  if (experiment.sweep) record.sweep = sweep_text(*experiment.sweep);
  record.thresholds = experiment.thresholds;
  record.resolved = to_toml(experiment);
  return record;
}

json record_json(const ExperimentRecord& record) {
  json written = {{"experiment", record.experiment},
                  {"scenes", json::array()},
                  {"composite", record.composite},
                  {"thresholds", json::array()},
                  {"resolved", record.resolved}};
  for (const ExperimentRecord::Scene& scene : record.scenes) written["scenes"].push_back(scene_json(scene));
  if (record.sweep) written["sweep"] = sweep_text_json(*record.sweep);
  for (const ThresholdSpec& threshold : record.thresholds) {
    written["thresholds"].push_back({{"method", threshold.method},
                                     {"metric", threshold.metric},
                                     {"maximum", threshold.maximum},
                                     {"where", threshold.where.str()}});
  }
  return written;
}

ExperimentRecord read_record(const json& read) {
  ExperimentRecord record;
  record.experiment = read.at("experiment");
  for (const json& scene : read.at("scenes")) record.scenes.push_back(read_scene(scene));
  record.composite = read.at("composite");
  if (read.contains("sweep")) record.sweep = read_sweep_text(read.at("sweep"));
  for (const json& threshold : read.at("thresholds")) {
    record.thresholds.push_back({threshold.at("method").get<std::string>(),
                                 threshold.at("metric").get<std::string>(),
                                 threshold.at("maximum").get<double>(),
                                 {threshold.at("where").get<std::string>()}});
  }
  record.resolved = read.at("resolved").get<std::string>();
  return record;
}

}  // namespace truescatter
