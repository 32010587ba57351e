#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "core/image_io.h"
#include "gpu/context.h"

namespace truescatter {

// Of an experiment as its resolved file states it.
std::string experiment_hash(const ExperimentSpec& spec);

// The program as pictures and sources name it: "truescatter 1.2.3 (COMMIT)", or "(COMMIT with changes)" of a
// checkout that had some.
std::string software_name();

// What the program is: version, commit (and whether it had changes), its own content, compiler, build type,
// instruction set and libraries.
nlohmann::json program_provenance();

// Where something comes from that is computed of files alone: program_provenance, the machine, and the
// `inputs`, hash_of_file by their paths. Throws Error (input): see hash_of_file.
nlohmann::json file_provenance(const std::vector<std::filesystem::path>& inputs);

// What the pictures of a result carry of its provenance: "Software" (software_name) and
// "truescatter:experiment", the hash of the experiment. Neither time, machine nor renderer: equal pictures
// are equal files.
ImageTexts picture_origin(const nlohmann::json& provenance);

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
