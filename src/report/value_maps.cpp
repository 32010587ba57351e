#include "report/value_maps.h"

#include <zlib.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/image_io.h"
#include "core/parallel.h"
#include "report/embed_text.h"
#include "report/pictures.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr int kLevels = 16383;
constexpr int kMaxStride = 32;
// Pixels with less mass are not measured by any metric.
constexpr float kSmallMass = 0.5F;

struct Source {
  std::string path;
  bool is_truth = false;
};

std::vector<Source> sources_of(const json& results, const std::filesystem::path& results_file) {
  std::vector<Source> sources;
  std::vector<std::string> paths;
  for (const bool is_truth : {true, false}) {
    for (const json& item : results.value(is_truth ? "truths" : "runs", json::array())) {
      const json files = item.value("files", json::object());
      const std::size_t known = paths.size();
      add_inner_path(files.value("exr", json()), results_file, paths);
      if (paths.size() > known) sources.push_back({paths.back(), is_truth});
    }
  }
  return sources;
}

Image measured_pixels(const LayeredImage& file, bool is_truth) {
  Image mask = layer_of(file, "mask");
  if (!is_truth) return mask;
  const Image mass = layer_of(file, "mass");
  for (std::size_t i = 0; i < mask.data().size(); ++i) {
    if (mass.data()[i] < kSmallMass) mask.data()[i] = 0.0F;
  }
  return mask;
}

// Residuals of one plane, in its pixels' order.
void add_residuals(const QuantizedImage& image, std::size_t plane, std::vector<std::uint16_t>& residuals) {
  const auto width = static_cast<std::size_t>(image.width);
  const std::size_t start = plane * width * static_cast<std::size_t>(image.height);
  for (std::size_t i = 0; i < width * static_cast<std::size_t>(image.height); ++i) {
    const bool has_left = i % width > 0;
    const bool has_above = i >= width;
    const std::uint16_t* code = image.codes.data() + start + i;
    const int left = has_left ? code[-1] : 0;
    const int above = has_above ? *(code - width) : 0;
    const int above_left = has_left && has_above ? *(code - width - 1) : 0;
    const auto residual =
        static_cast<std::int16_t>(static_cast<std::uint16_t>(*code - (left + above - above_left)));
    residuals.push_back(static_cast<std::uint16_t>(residual < 0 ? -2 * residual - 1 : 2 * residual));
  }
}

std::string deflated(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string result(size, '\0');
  const int status =
      compress2(reinterpret_cast<Bytef*>(result.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                bytes.size(), Z_DEFAULT_COMPRESSION);
  if (status != Z_OK) throw_run_error("the pictures' values cannot be packed: zlib's status is {}", status);
  result.resize(size);
  return result;
}

json value_map(const std::filesystem::path& path, bool is_truth, int stride) {
  // Decoded once: that is most of the work.
  const LayeredImage file = read_layered_image(path);
  const QuantizedImage image = quantized(rgb_of(file), measured_pixels(file, is_truth), stride);
  return {{"width", image.width},
          {"height", image.height},
          {"low", image.low},
          {"step", image.step},
          {"data", base64(packed(image))}};
}

std::vector<json> value_maps(const std::filesystem::path& folder, const std::vector<Source>& sources,
                             int stride) {
  std::vector<json> maps(sources.size());
  parallel_for(sources.size(), [&](std::size_t i) {
    maps[i] = value_map(folder / sources[i].path, sources[i].is_truth, stride);
  });
  return maps;
}

std::size_t size_of(const std::vector<json>& maps) {
  std::size_t bytes = 0;
  for (const json& map : maps) bytes += map["data"].get_ref<const std::string&>().size();
  return bytes;
}

}  // namespace

QuantizedImage quantized(const Image& rgb, const Image& mask, int stride) {
  assert(rgb.channels() == 3 && mask.width() == rgb.width() && mask.height() == rgb.height() && stride > 0);
  QuantizedImage result{
      (rgb.width() + stride - 1) / stride, (rgb.height() + stride - 1) / stride, 0.0, 0.0, {}};
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto for_each_pixel = [&](const auto& visit) {
    for (int y = 0; y < rgb.height(); y += stride) {
      for (int x = 0; x < rgb.width(); x += stride) visit(x, y);
    }
  };
  for_each_pixel([&](int x, int y) {
    if (mask.at(x, y, 0) == 0.0F) return;
    low = std::min(low, rgb.rgb(x, y).minCoeff());
    high = std::max(high, rgb.rgb(x, y).maxCoeff());
  });
  if (low <= high) {
    result.low = low;
    result.step = (high - low) / (kLevels - 1);
  }
  for (int c = 0; c < 3; ++c) {
    for_each_pixel([&](int x, int y) {
      const double level = result.step > 0.0 ? std::round((rgb.at(x, y, c) - low) / result.step) : 0.0;
      result.codes.push_back(mask.at(x, y, 0) == 0.0F ? std::uint16_t{0}
                                                      : static_cast<std::uint16_t>(1.0 + level));
    });
  }
  return result;
}

std::string packed(const QuantizedImage& image) {
  std::vector<std::uint16_t> residuals;
  residuals.reserve(image.codes.size());
  for (std::size_t plane = 0; plane < 3; ++plane) add_residuals(image, plane, residuals);
  std::string bytes;
  bytes.reserve(2 * residuals.size());
  for (const std::uint16_t r : residuals) bytes += static_cast<char>(r & 0xFFU);
  for (const std::uint16_t r : residuals) bytes += static_cast<char>(r >> 8U);
  return deflated(bytes);
}

json embedded_values(const std::filesystem::path& folder, const json& results, std::size_t max_bytes) {
  std::vector<Source> sources = sources_of(results, folder / "results.json");
  json missing = json::array();
  std::erase_if(sources, [&](const Source& source) {
    const bool is_missing = !std::filesystem::exists(folder / source.path);
    if (is_missing) missing.push_back(source.path);
    return is_missing;
  });
  // Bytes fall about as 1 / stride^2; a step at a time from there on.
  int stride = 1;
  std::vector<json> maps = value_maps(folder, sources, stride);
  while (size_of(maps) > max_bytes && stride < kMaxStride) {
    const double ratio = static_cast<double>(size_of(maps)) / static_cast<double>(max_bytes);
    stride = std::clamp(static_cast<int>(stride * std::sqrt(ratio)), stride + 1, kMaxStride);
    maps = value_maps(folder, sources, stride);
  }
  json result = {{"stride", stride}, {"maps", json::object()}, {"missing", missing}};
  for (std::size_t i = 0; i < sources.size(); ++i) result["maps"][sources[i].path] = std::move(maps[i]);
  return result;
}

}  // namespace truescatter
