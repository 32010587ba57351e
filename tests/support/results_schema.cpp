#include "support/results_schema.h"

#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

namespace truescatter::test {
namespace {

using valijson::adapters::NlohmannJsonAdapter;

const valijson::Schema& results_schema() {
  static const auto kSchema = [] {
    std::ifstream file(TRUESCATTER_SOURCE_DIR "/src/experiment/results.schema.json");
    const nlohmann::json json = nlohmann::json::parse(file);
    auto schema = std::make_unique<valijson::Schema>();
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(NlohmannJsonAdapter(json), *schema);
    return schema;
  }();
  return *kSchema;
}

}  // namespace

std::string schema_violations(const nlohmann::json& results) {
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  valijson::ValidationResults found;
  if (validator.validate(results_schema(), NlohmannJsonAdapter(results), &found)) return "";
  std::string text;
  for (const auto& error : found) {
    for (const std::string& place : error.context) text += place;
    text += fmt::format(": {}\n", error.description);
  }
  return text;
}

}  // namespace truescatter::test
