#include "experiment/merge_parts.h"

#include <algorithm>

#include "core/error.h"
#include "core/file.h"
#include "experiment/provenance.h"
#include "experiment/sweep.h"

namespace truescatter {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

ExperimentSpec experiment_of(const PartResult& part) {
  ExperimentSpec spec = read_experiment(part.folder / kResolvedFile);
  if (experiment_hash(spec) != part.key.value("experiment", std::string())) {
    throw_input_error({(part.folder / kResolvedFile).string()},
                      "is not the experiment that this part was computed of");
  }
  return spec;
}

// That the parts have all pieces, each by its share.
void check_pieces(const std::vector<PartResult>& parts, const std::vector<ScenePlan>& scenes) {
  for (const PartResult& part : parts) {
    const std::set<std::string> own = pieces_of_part(scenes, part.part);
    if (own != std::set<std::string>(part.pieces.begin(), part.pieces.end())) {
      throw_input_error({(part.folder / kPartFile).string()},
                        "does not list the pieces of part {} of this experiment", part.part.str());
    }
    for (const std::string& id : own) {
      const fs::path file = part.folder / "pieces" / (id + ".json");
      if (!fs::exists(file))
        throw_input_error({file.string()}, "this piece of part {} is missing", part.part.str());
    }
  }
}

void copy_files(const fs::path& from, const fs::path& to) {
  if (!fs::is_directory(from)) return;
  make_folder(to);
  for (const fs::directory_entry& entry : fs::directory_iterator(from)) {
    const fs::path copy = to / entry.path().filename();
    if (entry.path().filename() == PieceStore::kKeyFile) continue;  // each part has its own
    std::error_code failure;
    fs::copy_file(entry.path(), copy, failure);
    if (failure)
      throw_run_error("{}: cannot be copied to {}: {}", entry.path().string(), copy.string(),
                      failure.message());
  }
}

}  // namespace

RunOutcome merge_parts(const std::vector<PartResult>& parts, const fs::path& folder) {
  const ExperimentSpec spec = experiment_of(parts.front());
  const std::vector<ExperimentSpec> points = sweep_points(spec);
  std::vector<Plan> plans;
  // Pictures made elsewhere were read when the parts were computed.
  for (const ExperimentSpec& point : points) plans.push_back(make_plan(point, true));
  const std::vector<ScenePlan> scenes = scene_plans(points, plans);
  check_pieces(parts, scenes);

  const PieceStore pieces(folder);
  MemoryTaken memory = parts.front().work.memory;
  for (const PartResult& part : parts) {
    for (const char* kind : {"pieces", "maps", "inputs", "passes"})
      copy_files(part.folder / kind, folder / kind);
    memory.peak_bytes = std::max(memory.peak_bytes, part.work.memory.peak_bytes);
  }
  json key = parts.front().key;
  key.erase("part");
  pieces.set_key(key);
  return write_results(spec, scenes, pieces, key, memory, folder);
}

}  // namespace truescatter
