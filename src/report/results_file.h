#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace truescatter {

// A result folder's results.json. Throws Error (input) that names the file: there is none, it is not valid
// JSON (with line and column), or of a schema that this version does not know.
nlohmann::json read_results(const std::filesystem::path& folder);

// Whether a run was timed beside other work, or on another machine than others of its result: its times are
// then not held against any.
bool is_time_shared(const nlohmann::json& run);

}  // namespace truescatter
