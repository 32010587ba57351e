#pragma once

#include <map>
#include <string>

#include "config/experiment_spec.h"

namespace truescatter {

// The content of every file that an experiment names (meshes, textures, maps, shaders, tables, fits,
// pictures), a sweep's values included: ContentHash by the path as the experiment has it, for each view and
// profile where pictures have them in their names. Pictures that are not there are left out: their methods
// are skipped. Throws Error (input): see resolve_path, hash_of_file.
std::map<std::string, std::string> input_hashes(const ExperimentSpec& spec);

}  // namespace truescatter
