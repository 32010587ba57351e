#include "report/results_file.h"

#include "core/error.h"
#include "core/file.h"
#include "core/json_text.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr const char* kKnownSchema = "truescatter-results-1";

}  // namespace

json read_results(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  if (!std::filesystem::is_regular_file(file)) {
    throw_input_error({file.string()}, "no such file; a folder that `run` has written is needed");
  }
  const json results = parse_json(file.string(), read_text_file(file));
  const json schema = results.is_object() ? results.value("schema", json()) : json();
  if (schema != kKnownSchema) {
    throw_input_error({file.string()}, "the schema is {}; this version knows \"{}\"", schema.dump(),
                      kKnownSchema);
  }
  return results;
}

bool is_time_shared(const json& run) {
  const json::json_pointer shared("/cost/frame_ms/shared");
  return run.contains(shared) && run.at(shared) == true;
}

}  // namespace truescatter
