#include "experiment/run_experiment.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/file.h"
#include "experiment/filter_width.h"
#include "experiment/pieces.h"
#include "experiment/plan.h"
#include "experiment/provenance.h"
#include "experiment/scene_setup.h"
#include "experiment/sweep.h"
#include "experiment/view_composite.h"
#include "experiment/view_runner.h"

namespace truescatter {
namespace {

using nlohmann::json;

// What a run shares between all its scenes.
struct Shared {
  const gpu::Context& context;
  TruthCache* cache;
  const KeptValues& kept;
  const KeptValues& kept_by_parts;  // what a whole run computes each time
  const SourceWrapper& wrap;
  const PieceStore& pieces;
  const ImageTexts& origin;
  std::filesystem::path inputs;
  std::filesystem::path passes;
  bool buffers;
  const Compositor* compositor;
  KnownWidths& widths;
  std::uint64_t memory_limit_bytes;
  bool times_shared;
};

// Computes the pieces of a scene that are not finished.
void run_scene(const ScenePlan& what, const Shared& shared) {
  const auto& [spec, plan] = what;
  const auto admit = [&](const SceneSize& size) {
    refuse_beyond_memory(spec, plan, size, shared.memory_limit_bytes);
  };
  const bool reflection = shared.buffers || (spec.composite && spec.composite->specular);
  const PreparedScene scene = prepare_scene(
      spec, [&](const Mesh& mesh) { admit(size_of(mesh)); }, reflection, shared.kept);
  admit(size_of(scene));
  const SurfaceBuffers buffers(shared.context, scene.shading, scene.lights);
  const std::vector<PlannedTruth> planned = planned_truths(plan, buffers.has_uvs());
  const bool geodesic = std::any_of(planned.begin(), planned.end(), [](const PlannedTruth& truth) {
    return truth.target.follows_surface() && truth.not_computed.empty();
  });
  const SceneTruths truths(scene, spec.truth, geodesic || spec.truth.light_paths > 0, shared.cache,
                           shared.wrap, shared.kept_by_parts);
  const Setup setup{spec,
                    plan,
                    scene,
                    shared.context,
                    buffers,
                    truths,
                    shared.pieces,
                    shared.origin,
                    shared.inputs,
                    shared.passes,
                    shared.buffers,
                    shared.compositor,
                    shared.times_shared};
  for (const ViewSpec& view : spec.views) run_view(setup, view);
  for (const Piece& piece : pieces_of(spec, plan)) {
    if (piece.kind == Piece::Kind::widths && !shared.pieces.has(piece))
      shared.pieces.keep(piece, measure_filter_widths(shared.context, plan, buffers, shared.widths));
  }
}

struct Finished {
  std::size_t pieces = 0;
  std::size_t of = 0;
};

Finished finished_of(const ScenePlan& scene, const PieceStore& pieces) {
  std::vector<Piece> all = pieces_of(scene.spec, scene.plan);
  std::erase_if(all, [&](const Piece& piece) { return pieces.is_elsewhere(piece); });
  const auto finished =
      std::count_if(all.begin(), all.end(), [&](const Piece& piece) { return pieces.has(piece); });
  return {static_cast<std::size_t>(finished), all.size()};
}

void say_finished(const std::vector<ScenePlan>& scenes, const PieceStore& pieces) {
  Finished sum;
  for (const ScenePlan& scene : scenes) {
    const Finished finished = finished_of(scene, pieces);
    sum = {sum.pieces + finished.pieces, sum.of + finished.of};
  }
  if (sum.pieces > 0) fmt::print(stderr, "{} of {} pieces are finished\n", sum.pieces, sum.of);
}

// One scene after the other: of a sweep one for each value.
void run_scenes(const ExperimentSpec& spec, const std::vector<ScenePlan>& scenes, const Shared& shared) {
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Finished finished = finished_of(scenes[i], shared.pieces);
    if (finished.pieces == finished.of) continue;
    if (spec.sweep) {
      fmt::print(stderr, "{} = {} ({} of {})\n", spec.sweep->title, spec.sweep->axis[i], i + 1,
                 scenes.size());
    }
    run_scene(scenes[i], shared);
  }
}

// Plans refer to the experiments.
std::vector<Plan> make_plans(const std::vector<ExperimentSpec>& points, const RunOptions& options) {
  std::vector<Plan> plans;
  for (const ExperimentSpec& point : points) {
    plans.push_back(make_plan(point, options.export_inputs));
    refuse_beyond_memory(point, plans.back(), {}, options.memory_limit_bytes);
  }
  // A value that the scene refuses is not found after hours.
  if (points.size() > 1) {
    for (std::size_t i = 0; i < points.size(); ++i)
      refuse_beyond_memory(points[i], plans[i], size_of(check_scene(points[i])), options.memory_limit_bytes);
  }
  return plans;
}

json key_of(const gpu::Context& context, const ExperimentSpec& spec, const RunOptions& options) {
  json key = provenance(context, spec);
  key["exports"] = exports_of(options);
  if (!options.part) return key;
  key["part"] = options.part->str();
  key["times_shared"] = options.times_shared;
  return key;
}

json start_anew(PieceStore& pieces, const json& key) {
  pieces.clear();
  pieces.set_key(key);
  return key;
}

// What a part goes on from: a scheduler may begin it again on another machine, and with the same command
// after the experiment has changed.
json resume_part(PieceStore& pieces, const json& before, const json& key) {
  if (const std::string difference = part_difference(before, key); !difference.empty()) {
    fmt::print(stderr, "note: what was cut off is of something else ({}); starting from the beginning\n",
               difference);
    return start_anew(pieces, key);
  }
  const json joined = with_machines_of(before, key);
  pieces.set_key(joined);
  return joined;
}

// The pieces that a run goes on from; none, unless that is asked for. Returns what they belong to.
json start_pieces(PieceStore& pieces, const json& key, const RunOptions& options) {
  const std::optional<json> before = pieces.key();
  if (!options.resume || !before) return start_anew(pieces, key);
  if (options.part) return resume_part(pieces, *before, key);
  if (const std::string difference = provenance_difference(*before, key); !difference.empty())
    throw_input_error({}, "the run that was cut off cannot be resumed: {}; without --resume it starts anew",
                      difference);
  return *before;
}

}  // namespace

json exports_of(const RunOptions& options) {
  json exports = json::array();
  if (options.export_inputs) exports.push_back("inputs");
  if (options.export_passes) exports.push_back("passes");
  if (options.buffers) exports.push_back("buffers");
  return exports;
}

RunOutcome run_experiment(const ExperimentSpec& spec, const std::filesystem::path& folder, TruthCache* cache,
                          const SourceWrapper& wrap, const RunOptions& options) {
  const std::vector<ExperimentSpec> points = sweep_points(spec);
  const std::vector<Plan> plans = make_plans(points, options);
  const std::vector<ScenePlan> scenes = scene_plans(points, plans);
  const gpu::Context context(options.gl);
  for (const Plan& plan : plans) check_shaders(plan, context);
  const std::filesystem::path inputs = options.export_inputs ? folder / "inputs" : "";
  if (!inputs.empty()) make_folder(inputs);
  const std::filesystem::path passes = options.export_passes || options.buffers ? folder / "passes" : "";
  if (!passes.empty()) make_folder(passes);

  PieceStore pieces(folder, options.part ? pieces_elsewhere(scenes, *options.part) : std::set<std::string>());
  const json key = start_pieces(pieces, key_of(context, spec, options), options);
  say_finished(scenes, pieces);
  const ImageTexts origin = picture_origin(key);
  std::optional<Compositor> compositor;
  if (spec.composite) compositor.emplace(context, compositor_settings(*spec.composite));
  KnownWidths widths;
  const KeptValues kept(cache, key.at("program").get<std::string>());
  const KeptValues nothing;
  run_scenes(spec, scenes,
             {context, cache, kept, options.part ? kept : nothing, wrap, pieces, origin, inputs, passes,
              options.buffers, compositor ? &*compositor : nullptr, widths, options.memory_limit_bytes,
              options.times_shared});

  const MemoryTaken memory{peak_memory(), options.memory_limit_bytes};
  const ExperimentRecord record = record_of(spec, scenes);
  if (!options.part) return write_results(record, pieces, key, memory, folder);
  write_text_file(folder / kResolvedFile, record.resolved);
  const PartWork work{memory, cache != nullptr ? cache->stored_count() : 0,
                      cache != nullptr ? cache->found_count() : 0};
  write_part(folder, *options.part, pieces_of_part(scenes, *options.part), record, key, work);
  return {};
}

}  // namespace truescatter
