#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace truescatter {

// Every value of a TOML file by its dotted key, as TOML text: "view.front.width_px" -> "640". An entry of an
// array of tables has its label for a key, else its name, else its index, as in an override.
// Throws Error (input): see read_toml_file.
std::map<std::string, std::string> experiment_values(const std::filesystem::path& file);

}  // namespace truescatter
