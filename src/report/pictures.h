#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace truescatter {

// Adds `value`, if it is a path, unless it is there already. Throws Error (input), naming `results_file`, for
// a path that leaves the results' folder.
void add_inner_path(const nlohmann::json& value, const std::filesystem::path& results_file,
                    std::vector<std::string>& paths);

// The pictures that a results.json names (irradiance, truths, results, error maps, composites), relative to
// its folder, each once, in the order in which they are named. Throws Error (input), naming `results`, for a
// path that leaves the folder.
std::vector<std::string> picture_paths(const nlohmann::json& results,
                                       const std::filesystem::path& results_file);

// Likewise the buffers of views and methods (`run --buffers`), which the page shows small.
std::vector<std::string> buffer_paths(const nlohmann::json& results,
                                      const std::filesystem::path& results_file);

// A picture in the page, scaled down to a width by an area average of linear light where it is wider.
// `dispensable`: left out where its file is missing, or where such pictures would take more than
// kMaxDispensableBytes together; those that are named first stay.
struct PagePicture {
  std::string path;
  int max_width_px;
  bool dispensable = false;
};
inline constexpr std::size_t kMaxDispensableBytes = 6'000'000;

// {"files": {path: {"data": index, "width": w, "height": h}}, "data": [data URIs]}; the sizes are those of
// the file on disk; equal pictures are held once. Throws Error (input) that names a file which is missing or
// is no picture.
nlohmann::json embedded_pictures(const std::filesystem::path& folder, const std::vector<PagePicture>& wanted);

}  // namespace truescatter
