#include "report/results_file.h"

#include <algorithm>
#include <string_view>

#include "core/error.h"
#include "core/file.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr const char* kKnownSchema = "truescatter-results-1";

// Where byte `at` of a file lies, counted from 1.
SourceLocation place_of(const std::filesystem::path& file, std::string_view text, std::size_t at) {
  const std::string_view before = text.substr(0, std::min(at > 0 ? at - 1 : 0, text.size()));
  const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  return {file.string(), 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')),
          1 + static_cast<int>(before.size() - line_start)};
}

}  // namespace

json read_results(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  if (!std::filesystem::is_regular_file(file)) {
    throw_input_error({file.string()}, "no such file; a folder that `run` has written is needed");
  }
  const std::string text = read_text_file(file);
  json results;
  try {
    results = json::parse(text);
  } catch (const json::parse_error& problem) {
    // "[json...] parse error at line 1, column 2: what is wrong": the place is ours to say.
    const std::string_view message = problem.what();
    const std::size_t reason = message.find(": ");
    throw_input_error(place_of(file, text, problem.byte), "this is not valid JSON: {}",
                      reason == std::string_view::npos ? message : message.substr(reason + 2));
  }
  const json schema = results.is_object() ? results.value("schema", json()) : json();
  if (schema != kKnownSchema) {
    throw_input_error({file.string()}, "the schema is {}; this version knows \"{}\"", schema.dump(),
                      kKnownSchema);
  }
  return results;
}

}  // namespace truescatter
