#include "report/report.h"

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file.h"
#include "report/embed_text.h"
#include "report/page.h"
#include "report/pictures.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr const char* kKnownSchema = "truescatter-results-1";
constexpr int kMaxPictureWidthPx = 640;

json read_results(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) {
    throw_input_error({file.string()}, "no such file; `report` needs a folder that `run` has written");
  }
  json results;
  try {
    results = json::parse(read_text_file(file));
  } catch (const json::exception& problem) {
    throw_input_error({file.string()}, "this is not valid JSON: {}", problem.what());
  }
  const json schema = results.is_object() ? results.value("schema", json()) : json();
  if (schema != kKnownSchema) {
    throw_input_error({file.string()}, "the schema is {}; this version knows \"{}\"", schema.dump(),
                      kKnownSchema);
  }
  return results;
}

std::string title_of(const json& results) {
  const json::json_pointer name("/experiment/name");
  const bool named = results.contains(name) && results.at(name).is_string();
  return (named ? results.at(name).get<std::string>() + " \u00b7 " : std::string()) + "truescatter";
}

}  // namespace

void write_report(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  try {
    const json results = read_results(file);
    const json pictures = embedded_pictures(folder, picture_paths(results, file), kMaxPictureWidthPx);
    write_text_file(folder / "report.html",
                    make_page({html_escaped(title_of(results)), script_block_json(results.dump()),
                               script_block_json(pictures.dump())}));
  } catch (const json::exception& problem) {
    throw_input_error({file.string()}, "the results are not laid out as their schema says: {}",
                      problem.what());
  }
}

}  // namespace truescatter
