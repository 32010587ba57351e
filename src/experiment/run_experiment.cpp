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

}  // namespace

RunOutcome run_experiment(const ExperimentSpec& spec, const std::filesystem::path& folder, TruthCache* cache,
                          const SourceWrapper& wrap, const RunOptions& options) {
  const Plan plan = make_plan(spec, options.export_inputs);
  const gpu::Context context(options.gl);
  check_shaders(plan, context);
  const PreparedScene scene = prepare_scene(spec);
  const SurfaceBuffers buffers(context, scene.shading, scene.lights);
  const std::vector<PlannedTruth> planned = planned_truths(plan, buffers.has_uvs());
  const bool geodesic = std::any_of(planned.begin(), planned.end(), [](const PlannedTruth& truth) {
    return truth.target.follows_surface() && truth.not_computed.empty();
  });
  const SceneTruths truths(scene, spec.truth, geodesic || spec.truth.light_paths > 0, cache, wrap);
  const std::filesystem::path inputs = options.export_inputs ? folder / "inputs" : "";
  if (!inputs.empty()) make_folder(inputs);
  const std::filesystem::path passes = options.export_passes ? folder / "passes" : "";
  if (!passes.empty()) make_folder(passes);
  const Setup setup{spec, plan, scene, context, buffers, truths, inputs, passes};

  json results = {{"schema", kResultsSchema},
                  {"experiment",
                   {{"name", spec.name},
                    {"question", spec.question},
                    {"expectation", spec.expectation},
                    {"source", spec.source}}},
                  {"scene", scene_json(spec, scene)},
                  {"profiles", json::array()},
                  {"views", json::array()},
                  {"truths", json::array()},
                  {"fit_errors", json::array()},
                  {"light_paths", json::array()},
                  {"runs", json::array()},
                  {"ladders", json::array()},
                  {"stability", json::array()}};
  for (std::size_t i = 0; i < plan.profiles.size(); ++i) {
    const Profile& profile = plan.profiles[i];
    results["profiles"].push_back(profile_json(profile));
    if (const auto fit = plan.fits.find(profile.name); fit != plan.fits.end()) {
      results["profiles"].back()["fit"] =
          profile_fit_json(plan.approximated.at(profile.name), *spec.profiles[i].fit, fit->second);
    }
    if (const ProfileModel* model = plan.model_of(profile))
      results["profiles"].back()["of"] = profile_model_json(*model);
  }
  std::list<ViewMaps> views;
  for (const ViewSpec& view : spec.views) views.push_back(run_view(setup, view, results));

  add_filter_widths(context, plan, buffers, results["ladders"]);
  const MapRanges ranges = common_ranges(results);
  results["maps"] = {{"range", ranges.errors},
                     {"ladder_range", ranges.ladder_steps},
                     {"quantity", "luminance"},
                     {"exposure", setup.exposure()}};
  results["provenance"] = provenance(context);
  const std::vector<std::string> exceeded = exceeded_thresholds(results, spec.thresholds);
  results["exceeded"] = exceeded;

  const std::filesystem::path maps = folder / "maps";
  make_folder(maps);
  write_maps(views, maps, ranges, setup.exposure());
  write_text_file(folder / "experiment.resolved.toml", to_toml(spec));
  write_text_file(folder / "results.csv", results_csv(results));
  write_text_file(folder / "results.json", results.dump(1) + "\n");
  return {exceeded};
}

}  // namespace truescatter
