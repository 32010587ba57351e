#pragma once

#include <nlohmann/json.hpp>

#include "config/experiment_spec.h"
#include "gpu/context.h"

namespace truescatter {

// Where a result comes from: version, commit (and whether it had changes), the program's own content,
// compiler, libraries, OpenGL renderer, machine, and the content of the experiment and of every file that it
// names. Throws Error (input): see input_hashes.
nlohmann::json provenance(const gpu::Context& context, const ExperimentSpec& spec);

// Why what was computed under `before` cannot be joined with what is computed under `now`: the first entry
// that differs, with both values. Empty: it can. What changes no result may differ: the number of jobs, and
// the system's release.
std::string provenance_difference(const nlohmann::json& before, const nlohmann::json& now);

// The time, as results have it: 2026-01-31T12:00:00Z.
std::string now_utc();

}  // namespace truescatter
