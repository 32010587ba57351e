#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace truescatter::test {

// Each place of a results.json that is not laid out as src/experiment/results.schema.json says, with what is
// wrong there, a line each; empty: all of it is.
std::string schema_violations(const nlohmann::json& results);

}  // namespace truescatter::test
