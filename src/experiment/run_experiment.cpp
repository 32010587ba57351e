#include "experiment/run_experiment.h"

#include <algorithm>
#include <list>

#include "core/file.h"
#include "experiment/filter_width.h"
#include "experiment/map_files.h"
#include "experiment/plan.h"
#include "experiment/provenance.h"
#include "experiment/result_json.h"
#include "experiment/results.h"
#include "experiment/scene_setup.h"
#include "experiment/sweep.h"
#include "experiment/view_runner.h"
#include "metrics/map_picture.h"

namespace truescatter {
namespace {

using nlohmann::json;

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

// One fixed range for every error map of the experiment: the median over the runs of the 99 % quantile,
// rounded up. The worst method's maps saturate; scaled to the worst, the good ones would be black. Another
// one for the steps of ladders, which are smaller.
MapRanges common_ranges(const json& results) {
  std::vector<double> errors;
  for (const json& run : results["runs"]) add_quantile(run, "metrics", errors);
  std::vector<double> steps;
  for (const json& ladder : results["ladders"]) {
    for (const json& rung : ladder.value("rungs", json::array())) add_quantile(rung, "step", steps);
  }
  return {range_of(errors), range_of(steps)};
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) throw_run_error("{}: cannot make this folder: {}", folder.string(), failure.message());
}

// What a run shares between all its scenes.
struct Shared {
  const gpu::Context& context;
  TruthCache* cache;
  const SourceWrapper& wrap;
  std::filesystem::path inputs;
  std::filesystem::path passes;
};

// The pictures of a scene.
struct SceneMaps {
  std::list<ViewMaps> views;
  double exposure;
};

void add_profiles(const ExperimentSpec& spec, const Plan& plan, json& profiles) {
  for (std::size_t i = 0; i < plan.profiles.size(); ++i) {
    const Profile& profile = plan.profiles[i];
    const bool known = std::any_of(profiles.begin(), profiles.end(),
                                   [&](const json& other) { return other["name"] == profile.name; });
    if (known) continue;
    profiles.push_back(profile_json(profile));
    if (const auto fit = plan.fits.find(profile.name); fit != plan.fits.end()) {
      profiles.back()["fit"] =
          profile_fit_json(plan.approximated.at(profile.name), *spec.profiles[i].fit, fit->second);
    }
    if (const ProfileModel* model = plan.model_of(profile))
      profiles.back()["of"] = profile_model_json(*model);
  }
}

// Sets `scene` of the results to this one, and appends to all lists of what was measured.
SceneMaps run_scene(const ExperimentSpec& spec, const Plan& plan, const Shared& shared, json& results) {
  const PreparedScene scene = prepare_scene(spec);
  const SurfaceBuffers buffers(shared.context, scene.shading, scene.lights);
  const std::vector<PlannedTruth> planned = planned_truths(plan, buffers.has_uvs());
  const bool geodesic = std::any_of(planned.begin(), planned.end(), [](const PlannedTruth& truth) {
    return truth.target.follows_surface() && truth.not_computed.empty();
  });
  const SceneTruths truths(scene, spec.truth, geodesic || spec.truth.light_paths > 0, shared.cache,
                           shared.wrap);
  const Setup setup{spec, plan, scene, shared.context, buffers, truths, shared.inputs, shared.passes};
  results["scene"] = scene_json(spec, scene);
  add_profiles(spec, plan, results["profiles"]);
  SceneMaps maps{{}, setup.exposure()};
  const std::size_t first_ladder = results["ladders"].size();
  for (const ViewSpec& view : spec.views) maps.views.push_back(run_view(setup, view, results));
  add_filter_widths(shared.context, plan, buffers, results["ladders"], first_ladder);
  return maps;
}

// One scene after the other: of a sweep one for each value.
std::list<SceneMaps> run_scenes(const ExperimentSpec& spec, const std::vector<ExperimentSpec>& points,
                                const std::vector<Plan>& plans, const Shared& shared, json& results) {
  std::list<SceneMaps> maps;
  std::vector<json> scenes;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (spec.sweep)
      fmt::print(stderr, "{} = {} ({} of {})\n", spec.sweep->title, spec.sweep->axis[i], i + 1,
                 points.size());
    const std::size_t first_view = results["views"].size();
    const std::size_t first_run = results["runs"].size();
    maps.push_back(run_scene(points[i], plans[i], shared, results));
    scenes.push_back(results["scene"]);
    if (spec.sweep) mark_sweep(spec, i, first_view, first_run, results);
  }
  // What is said of the scene is said of the first.
  results["scene"] = scenes.front();
  if (spec.sweep) results["sweep"] = sweep_json(*spec.sweep, scenes, results);
  return maps;
}

// Plans refer to the experiments.
std::vector<Plan> make_plans(const std::vector<ExperimentSpec>& points, bool without_pictures) {
  std::vector<Plan> plans;
  for (const ExperimentSpec& point : points) plans.push_back(make_plan(point, without_pictures));
  // A value that the scene refuses is not found after hours.
  if (points.size() > 1) {
    for (const ExperimentSpec& point : points) check_scene(point);
  }
  return plans;
}

}  // namespace

RunOutcome run_experiment(const ExperimentSpec& spec, const std::filesystem::path& folder, TruthCache* cache,
                          const SourceWrapper& wrap, const RunOptions& options) {
  const std::vector<ExperimentSpec> points = sweep_points(spec);
  const std::vector<Plan> plans = make_plans(points, options.export_inputs);
  const gpu::Context context(options.gl);
  for (const Plan& plan : plans) check_shaders(plan, context);
  const std::filesystem::path inputs = options.export_inputs ? folder / "inputs" : "";
  if (!inputs.empty()) make_folder(inputs);
  const std::filesystem::path passes = options.export_passes ? folder / "passes" : "";
  if (!passes.empty()) make_folder(passes);

  json results = {{"schema", kResultsSchema},
                  {"experiment",
                   {{"name", spec.name},
                    {"question", spec.question},
                    {"expectation", spec.expectation},
                    {"source", spec.source}}},
                  {"profiles", json::array()},
                  {"views", json::array()},
                  {"truths", json::array()},
                  {"fit_errors", json::array()},
                  {"light_paths", json::array()},
                  {"runs", json::array()},
                  {"ladders", json::array()},
                  {"stability", json::array()}};
  const std::list<SceneMaps> scenes =
      run_scenes(spec, points, plans, {context, cache, wrap, inputs, passes}, results);

  const MapRanges ranges = common_ranges(results);
  results["maps"] = {{"range", ranges.errors},
                     {"ladder_range", ranges.ladder_steps},
                     {"quantity", "luminance"},
                     {"exposure", scenes.front().exposure}};
  results["provenance"] = provenance(context);
  const std::vector<std::string> exceeded = exceeded_thresholds(results, spec.thresholds);
  results["exceeded"] = exceeded;

  const std::filesystem::path maps = folder / "maps";
  make_folder(maps);
  for (const SceneMaps& scene : scenes) write_maps(scene.views, maps, ranges, scene.exposure);
  write_text_file(folder / "experiment.resolved.toml", to_toml(spec));
  write_text_file(folder / "results.csv", results_csv(results));
  write_text_file(folder / "results.json", results.dump(1) + "\n");
  return {exceeded};
}

}  // namespace truescatter
