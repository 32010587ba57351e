#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "config/experiment_spec.h"
#include "experiment/memory_estimate.h"
#include "experiment/parts.h"
#include "experiment/scene_truths.h"
#include "experiment/write_results.h"

namespace truescatter {

// How a run is done, beside what its experiment says.
struct RunOptions {
  gpu::Backend gl = gpu::Backend::osmesa;
  bool export_inputs =
      false;  // writes what methods are given of each view to inputs/, and skips what has no picture
  bool export_passes = false;  // writes the textures that methods name on their way to passes/
  bool buffers = false;        // the same, and there too what a view has before any method draws
  std::uint64_t memory_limit_bytes = default_memory_limit();
  bool resume = false;  // goes on from the finished pieces in the folder, if there are any
  std::optional<ExperimentPart> part = std::nullopt;  // computes this share of the pieces alone
  bool times_shared =
      false;  // other work runs on the machine meanwhile: times are marked as unfit for charts
};

// What a run writes beside its results, by name, as its provenance has it.
nlohmann::json exports_of(const RunOptions& options);

// Runs an experiment and writes results.json, results.csv, experiment.resolved.toml and maps/ into `folder`,
// which must be there. A scene that needs more memory than the limit is refused before it is lit, and where
// its size is known without generating it, before anything is computed. What is finished on the way is kept
// in pieces/ (PieceStore), which stays. Of a part, experiment.resolved.toml, pieces and part.json are
// written, and no results. Throws Error: input as it is found, and where the pieces to go on from were
// computed by another program, on another machine or of another experiment; run for a failed audit, the
// driver or the disk. `cache`: where truths are looked for first and kept; null for none. `wrap`: for tests
// of what a run does with an engine that errs.
RunOutcome run_experiment(const ExperimentSpec& spec, const std::filesystem::path& folder,
                          TruthCache* cache = nullptr, const SourceWrapper& wrap = {},
                          const RunOptions& options = {});

}  // namespace truescatter
