#include "report/report.h"

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file.h"
#include "report/embed_text.h"
#include "report/page.h"
#include "report/pictures.h"
#include "report/results_file.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr int kMaxPictureWidthPx = 640;

std::string title_of(const json& results) {
  const json::json_pointer name("/experiment/name");
  const bool named = results.contains(name) && results.at(name).is_string();
  return (named ? results.at(name).get<std::string>() + " \u00b7 " : std::string()) + "truescatter";
}

}  // namespace

void write_report(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  try {
    const json results = read_results(folder);
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
