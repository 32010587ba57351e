#include "experiment/pass_files.h"

#include <algorithm>
#include <cmath>
#include <list>
#include <vector>

#include "core/image_io.h"
#include "metrics/map_picture.h"

namespace truescatter {
namespace {

using nlohmann::json;

bool is_light(const NamedTexture& texture) { return texture.channels == "RGB"; }

Image channel_of(const Image& image, int channel) {
  Image one(image.width(), image.height(), 1);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) one.at(x, y, 0) = image.at(x, y, channel);
  }
  return one;
}

// The first three channels, 0 for those that there are not; grey of a single one. Of what is not light the
// magnitudes: a normal that points to the left is no darkness.
Image as_rgb(const Image& image, bool light) {
  Image rgb(image.width(), image.height(), 3);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const int from = image.channels() == 1 ? 0 : c;
        if (from >= image.channels()) continue;
        rgb.at(x, y, c) = light ? image.at(x, y, from) : std::abs(image.at(x, y, from));
      }
    }
  }
  return rgb;
}

// The 99 % quantile of what is a number of what is shown, rounded up so that pictures of alike textures share
// it; 1 where it is not above 0.
double white_of(const Image& image) {
  std::vector<float> values;
  std::copy_if(image.data().begin(), image.data().end(), std::back_inserter(values),
               [](float value) { return std::isfinite(value); });
  if (values.empty()) return 1.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at > 0.0F ? round_range(*at) : 1.0;
}

void write_channels(const std::filesystem::path& path, const NamedTexture& texture,
                    const ImageTexts& origin) {
  std::list<Image> images;
  std::vector<ExrLayer> layers;
  for (int c = 0; c < texture.image.channels(); ++c) {
    images.push_back(channel_of(texture.image, c));
    layers.push_back({std::string(1, texture.channels[static_cast<std::size_t>(c)]), &images.back()});
  }
  write_exr(path, layers, origin);
}

}  // namespace

json write_named_texture(const std::filesystem::path& folder, const std::string& stem,
                         const NamedTexture& texture, double exposure, const ImageTexts& origin) {
  const std::string name = stem + "." + texture.name;
  const bool light = is_light(texture);
  const Image shown = as_rgb(texture.image, light);
  const double white = light ? 1.0 / exposure : white_of(shown);
  write_channels(folder / (name + ".exr"), texture, origin);
  write_png(folder / (name + ".png"), display_picture(shown, 1.0 / white), origin);
  return {{"name", texture.name}, {"shows", texture.shows},           {"channels", texture.channels},
          {"white", white},       {"exr", "passes/" + name + ".exr"}, {"png", "passes/" + name + ".png"}};
}

}  // namespace truescatter
