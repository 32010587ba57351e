#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/memory_estimate.h"
#include "experiment/scene_truths.h"

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
};

// What a run ended with.
struct RunOutcome {
  std::vector<std::string> exceeded;  // one line per stated threshold that was exceeded
};

// Runs an experiment and writes results.json, results.csv, experiment.resolved.toml and maps/ into `folder`,
// which must be there. A scene that needs more memory than the limit is refused before it is lit, and where
// its size is known without generating it, before anything is computed. What is finished on the way is kept
// in pieces/ (PieceStore), which stays. Throws Error: input as it is found, and where the pieces to go on
// from were computed by another program, on another machine or of another experiment; run for a failed audit,
// the driver or the disk. `cache`: where truths are looked for first and kept; null for none. `wrap`: for
// tests of what a run does with an engine that errs.
RunOutcome run_experiment(const ExperimentSpec& spec, const std::filesystem::path& folder,
                          TruthCache* cache = nullptr, const SourceWrapper& wrap = {},
                          const RunOptions& options = {});

}  // namespace truescatter
