#include "report/report.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file.h"
#include "core/image_io.h"
#include "core/parallel.h"
#include "core/plain_pictures.h"
#include "report/embed_text.h"
#include "report/page.h"
#include "report/pictures.h"
#include "report/results_file.h"
#include "report/value_maps.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr int kMaxPictureWidthPx = 640;
constexpr int kMaxBufferWidthPx = 200;
// The whole page is to stay below 40 MB; its pictures take the rest.
constexpr std::size_t kMaxValueBytes = 24'000'000;

std::string title_of(const json& results) {
  const json::json_pointer name("/experiment/name");
  const bool named = results.contains(name) && results.at(name).is_string();
  return (named ? results.at(name).get<std::string>() + " \u00b7 " : std::string()) + "truescatter";
}

// Of the largest view.
double most_pixels(const json& results) {
  double most = 0.0;
  for (const json& view : results.value("views", json::array()))
    most = std::max(most, view.value("width_px", 0.0) * view.value("height_px", 0.0));
  return most;
}

}  // namespace

void write_report(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  try {
    const json results = read_results(folder);
    std::vector<PagePicture> wanted;
    for (const std::string& path : picture_paths(results, file)) wanted.push_back({path, kMaxPictureWidthPx});
    double pixels = most_pixels(results);
    for (const std::string& path : buffer_paths(results, file)) {
      wanted.push_back({path, kMaxBufferWidthPx, true});
      // A map in texture space may be larger than any view.
      const PictureSize size = png_size(folder / path);
      pixels = std::max(pixels, static_cast<double>(size.width) * size.height);
    }
    const JobLimit limit(jobs_within(pixels * kPictureJobBytes, job_count()));
    const json pictures = embedded_pictures(folder, wanted);
    const json values = embedded_values(folder, results, kMaxValueBytes);
    write_text_file(folder / "report.html",
                    make_page({html_escaped(title_of(results)), script_block_json(results.dump()),
                               script_block_json(pictures.dump()), script_block_json(values.dump())}));
  } catch (const json::exception& problem) {
    throw_input_error({file.string()}, "the results are not laid out as their schema says: {}",
                      problem.what());
  }
}

}  // namespace truescatter
