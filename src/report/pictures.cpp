#include "report/pictures.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/file.h"
#include "core/image.h"
#include "core/image_io.h"
#include "core/parallel.h"
#include "core/plain_pictures.h"
#include "report/embed_text.h"

namespace truescatter {
namespace {

using nlohmann::json;

// How much of each source pixel a target pixel covers along one axis: `first`, and one weight per pixel.
struct Coverage {
  int first = 0;
  std::vector<float> weight;
};

std::vector<Coverage> coverage_of(int source, int target) {
  const double step = static_cast<double>(source) / target;
  std::vector<Coverage> rows(static_cast<std::size_t>(target));
  for (int i = 0; i < target; ++i) {
    const double low = i * step;
    const double high = std::min((i + 1) * step, static_cast<double>(source));
    Coverage& row = rows[static_cast<std::size_t>(i)];
    row.first = static_cast<int>(low);
    for (int k = row.first; k < source && k < high; ++k) {
      row.weight.push_back(static_cast<float>((std::min(high, k + 1.0) - std::max(low, k + 0.0)) / step));
    }
  }
  return rows;
}

Image scaled_columns(const Image& image, int width) {
  const std::vector<Coverage> coverage = coverage_of(image.width(), width);
  Image result(width, image.height(), image.channels());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < width; ++x) {
      const Coverage& from = coverage[static_cast<std::size_t>(x)];
      for (std::size_t k = 0; k < from.weight.size(); ++k) {
        for (int c = 0; c < image.channels(); ++c) {
          result.at(x, y, c) += from.weight[k] * image.at(from.first + static_cast<int>(k), y, c);
        }
      }
    }
  }
  return result;
}

Image scaled_rows(const Image& image, int height) {
  const std::vector<Coverage> coverage = coverage_of(image.height(), height);
  Image result(image.width(), height, image.channels());
  for (int y = 0; y < height; ++y) {
    const Coverage& from = coverage[static_cast<std::size_t>(y)];
    for (std::size_t k = 0; k < from.weight.size(); ++k) {
      for (int x = 0; x < image.width(); ++x) {
        for (int c = 0; c < image.channels(); ++c) {
          result.at(x, y, c) += from.weight[k] * image.at(x, from.first + static_cast<int>(k), c);
        }
      }
    }
  }
  return result;
}

// A function on [0, 1] by table; the last entry stands for 1.
template <std::size_t N>
class Table {
 public:
  explicit Table(double (*function)(double)) {
    for (std::size_t i = 0; i < N; ++i) {
      values_[i] = static_cast<float>(function(static_cast<double>(i) / static_cast<double>(N - 1)));
    }
  }
  float operator()(float x) const {
    return values_[static_cast<std::size_t>(std::clamp(x, 0.0F, 1.0F) * static_cast<float>(N - 1) + 0.5F)];
  }

 private:
  std::array<float, N> values_{};
};

// The file's bytes are sRGB-encoded; light adds up before that. 256 values go in, and the tables' steps are
// well below one of the 256 that come out.
Image scaled_down(Image image, int width) {
  static const Table<256> decode(srgb_decode);
  static const Table<16384> encode(srgb_encode);
  for (float& v : image.data()) v = decode(v);
  const double ratio = static_cast<double>(width) / image.width();
  const int height = std::max(1, static_cast<int>(std::lround(image.height() * ratio)));
  Image result = scaled_rows(scaled_columns(image, width), height);
  for (float& v : result.data()) v = encode(v);
  return result;
}

std::string png_bytes(const Image& image, std::size_t index) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("truescatter-report-{}-{}.png", ::getpid(), index);
  write_png(file, image);
  std::string bytes = read_text_file(file);
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  return bytes;
}

struct Picture {
  int width = 0;
  int height = 0;
  std::string uri;
};

Picture load_picture(const std::filesystem::path& file, std::size_t index, int max_width_px) {
  constexpr const char* kStart = "data:image/png;base64,";
  if (const PictureSize size = png_size(file); size.width > 0 && size.width <= max_width_px)
    return {size.width, size.height, kStart + base64(read_text_file(file))};
  Image image = read_image(file);
  const int width = image.width();
  const int height = image.height();
  return {width, height,
          kStart + base64(png_bytes(scaled_down(std::move(image), std::min(width, max_width_px)), index))};
}

}  // namespace

void add_inner_path(const json& value, const std::filesystem::path& results_file,
                    std::vector<std::string>& paths) {
  if (!value.is_string()) return;
  const std::string path = value.get<std::string>();
  const std::filesystem::path parts(path);
  const bool leaves = parts.is_absolute() || std::find(parts.begin(), parts.end(), "..") != parts.end();
  if (leaves)
    throw_input_error({results_file.string()}, "the file '{}' lies outside of the results' folder", path);
  if (std::find(paths.begin(), paths.end(), path) == paths.end()) paths.push_back(path);
}

std::vector<std::string> picture_paths(const json& results, const std::filesystem::path& results_file) {
  std::vector<std::string> paths;
  const auto add_group = [&](const json& of, const char* group, const std::vector<const char*>& kinds) {
    for (const json& item : of.value(group, json::array())) {
      const json files = item.value("files", json::object());
      for (const char* kind : kinds) add_inner_path(files.value(kind, json()), results_file, paths);
    }
  };
  add_group(results, "views", {"irradiance"});
  add_group(results, "truths", {"picture", "composite"});
  add_group(results, "runs", {"picture", "magnitude", "signed", "composite", "visible"});
  for (const json& ladder : results.value("ladders", json::array())) add_group(ladder, "rungs", {"signed"});
  return paths;
}

std::vector<std::string> buffer_paths(const json& results, const std::filesystem::path& results_file) {
  std::vector<std::string> paths;
  const auto add = [&](const char* group, const char* key) {
    for (const json& item : results.value(group, json::array())) {
      for (const json& buffer : item.value("files", json::object()).value(key, json::array()))
        add_inner_path(buffer.value("png", json()), results_file, paths);
    }
  };
  add("views", "buffers");
  add("runs", "passes");
  return paths;
}

json embedded_pictures(const std::filesystem::path& folder, const std::vector<PagePicture>& wanted) {
  std::vector<Picture> pictures(wanted.size());
  parallel_for(wanted.size(), [&](std::size_t i) {
    const std::filesystem::path file = folder / wanted[i].path;
    if (wanted[i].dispensable && !std::filesystem::exists(file)) return;
    pictures[i] = load_picture(file, i, wanted[i].max_width_px);
  });
  std::size_t dispensable_bytes = 0;
  json result = {{"files", json::object()}, {"data", json::array()}};
  std::map<std::string, std::size_t> known;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i].dispensable) {
      if (pictures[i].uri.empty() || dispensable_bytes + pictures[i].uri.size() > kMaxDispensableBytes)
        continue;
      dispensable_bytes += pictures[i].uri.size();
    }
    const auto [entry, is_new] = known.try_emplace(pictures[i].uri, known.size());
    if (is_new) result["data"].push_back(pictures[i].uri);
    result["files"][wanted[i].path] = {
        {"data", entry->second}, {"width", pictures[i].width}, {"height", pictures[i].height}};
  }
  return result;
}

}  // namespace truescatter
