#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace truescatter {

// The JSON that `text`, the content of `file`, holds. Throws Error (input) that names file, line and column.
nlohmann::json parse_json(const std::string& file, std::string_view text);

}  // namespace truescatter
