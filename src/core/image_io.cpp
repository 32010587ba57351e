#include "core/image_io.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "core/exr_header.h"
#include "core/file.h"

namespace truescatter {
namespace {

// Colours are written and read as they are, not divided or multiplied by a fourth channel.
constexpr const char* kUnassociatedAlpha = "oiio:UnassociatedAlpha";
// The time would be written otherwise: equal pictures are equal files.
constexpr const char* kDateTime = "DateTime";

std::string channel_name(const ExrLayer& layer, int channel) {
  static constexpr std::array<const char*, 4> kColour = {"R", "G", "B", "A"};
  static constexpr std::array<const char*, 4> kVector = {"X", "Y", "Z", "W"};
  if (layer.image->channels() == 1) return layer.name.empty() ? "Y" : layer.name;
  const auto& suffixes = layer.vector ? kVector : kColour;
  const std::string suffix = suffixes[static_cast<std::size_t>(channel)];
  return layer.name.empty() ? suffix : layer.name + "." + suffix;
}

void put_texts(OIIO::ImageSpec& spec, const ImageTexts& texts) {
  for (const auto& [name, text] : texts) spec.attribute(name, text);
}

// Into memory first: the library's writers close their files without looking whether the last bytes went in,
// which on a full disk leaves half a picture and no word of it.
void write_with_oiio(const std::filesystem::path& path, OIIO::ImageSpec spec, OIIO::TypeDesc format,
                     const void* pixels) {
  OIIO::Filesystem::IOVecOutput encoded;
  OIIO::Filesystem::IOProxy* proxy = &encoded;
  spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path.filename().string());
  if (!output) throw_run_error("{}: no writer for this image format: {}", path.string(), OIIO::geterror());
  if (!output->open(path.filename().string(), spec) || !output->write_image(format, pixels) ||
      !output->close())
    throw_run_error("{}: cannot write image: {}", path.string(), output->geterror());
  const std::vector<unsigned char>& bytes = encoded.buffer();
  write_text_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

void write_exr(const std::filesystem::path& path, const std::vector<ExrLayer>& layers,
               const ImageTexts& texts) {
  assert(!layers.empty());
  const int width = layers.front().image->width();
  const int height = layers.front().image->height();
  int channels = 0;
  OIIO::ImageSpec spec(width, height, 0, OIIO::TypeDesc::FLOAT);
  spec.channelnames.clear();
  for (const ExrLayer& layer : layers) {
    assert(layer.image->width() == width && layer.image->height() == height);
    for (int c = 0; c < layer.image->channels(); ++c) spec.channelnames.push_back(channel_name(layer, c));
    channels += layer.image->channels();
  }
  spec.nchannels = channels;
  spec.attribute("compression", "zip");
  spec.attribute(kDateTime, "");
  put_texts(spec, texts);

  std::vector<float> pixels(static_cast<std::size_t>(channels) * layers.front().image->pixel_count());
  std::size_t offset = 0;
  for (const ExrLayer& layer : layers) {
    const auto count = static_cast<std::size_t>(layer.image->channels());
    const std::span<const float> data = layer.image->data();
    for (std::size_t p = 0; p < layer.image->pixel_count(); ++p) {
      std::copy_n(
          data.begin() + static_cast<std::ptrdiff_t>(p * count), count,
          pixels.begin() + static_cast<std::ptrdiff_t>(p * static_cast<std::size_t>(channels) + offset));
    }
    offset += count;
  }
  write_with_oiio(path, spec, OIIO::TypeDesc::FLOAT, pixels.data());
}

void write_png(const std::filesystem::path& path, const Image& image, const ImageTexts& texts) {
  std::vector<unsigned char> bytes(image.data().size());
  std::transform(image.data().begin(), image.data().end(), bytes.begin(), [](float v) {
    return static_cast<unsigned char>(std::lround(std::clamp(v, 0.0F, 1.0F) * 255.0F));
  });
  OIIO::ImageSpec spec(image.width(), image.height(), image.channels(), OIIO::TypeDesc::UINT8);
  spec.attribute(kUnassociatedAlpha, 1);
  put_texts(spec, texts);
  write_with_oiio(path, spec, OIIO::TypeDesc::UINT8, bytes.data());
}

namespace {

// What a picture may ask for: 4 GiB of values, and no more than its file can hold. Deflated data is at least
// a thousandth of what it stands for; the lossy compressions of EXR get further, but not by as much again.
constexpr double kMostValues = 1024.0 * 1024.0 * 1024.0;
constexpr double kMostValuesPerByte = 65536.0;

void check_size(const std::filesystem::path& path, const OIIO::ImageSpec& spec) {
  const double values = static_cast<double>(spec.width) * spec.height * spec.nchannels;
  if (values > kMostValues) {
    throw_input_error({path.string()}, "the image is {} x {} with {} channels; at most 2^30 values are read",
                      spec.width, spec.height, spec.nchannels);
  }
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  if (values > kMostValuesPerByte * bytes) {
    throw_input_error({path.string()},
                      "says it is {} x {} with {} channels, which a file of {} bytes cannot hold", spec.width,
                      spec.height, spec.nchannels, bytes);
  }
}

Image read_with_spec(const std::filesystem::path& path, OIIO::ImageSpec& spec) {
  if (!std::filesystem::exists(path)) throw_input_error({path.string()}, "no such file");
  if (const std::string wrong = wrong_exr_attribute(path); !wrong.empty())
    throw_input_error({path.string()}, "cannot read this image: {}", wrong);
  OIIO::ImageSpec as_stored;
  as_stored.attribute(kUnassociatedAlpha, 1);
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string(), &as_stored);
  if (!input) throw_input_error({path.string()}, "cannot read this image: {}", OIIO::geterror());
  spec = input->spec();
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 || spec.depth > 1) {
    throw_input_error({path.string()}, "the image is {} x {} x {} with {} channels; a flat image is needed",
                      spec.width, spec.height, spec.depth, spec.nchannels);
  }
  check_size(path, spec);
  Image image(spec.width, spec.height, spec.nchannels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.data().data())) {
    throw_input_error({path.string()}, "cannot read the pixels: {}", input->geterror());
  }
  return image;
}

}  // namespace

ImageTexts read_image_texts(const std::filesystem::path& path) {
  OIIO::ImageSpec spec;
  read_with_spec(path, spec);
  ImageTexts texts;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeDesc::STRING)
      texts.emplace(attribute.name().string(), attribute.get_string());
  }
  return texts;
}

Image read_image(const std::filesystem::path& path, std::vector<std::string>* channel_names) {
  OIIO::ImageSpec spec;
  Image image = read_with_spec(path, spec);
  if (channel_names != nullptr) *channel_names = spec.channelnames;
  return image;
}

double image_values(const std::filesystem::path& path) {
  if (!wrong_exr_attribute(path).empty()) return 0.0;
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string());
  if (!input) {
    OIIO::geterror();  // is kept for whoever asks next, else
    return 0.0;
  }
  const OIIO::ImageSpec& spec = input->spec();
  return static_cast<double>(spec.width) * spec.height * spec.nchannels;
}

Image read_linear_colours(const std::filesystem::path& path, std::vector<std::string>* channel_names) {
  OIIO::ImageSpec spec;
  Image image = read_with_spec(path, spec);
  if (channel_names != nullptr) *channel_names = spec.channelnames;
  if (spec.format.is_floating_point()) return image;
  const int colours = std::min(3, image.channels());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < colours; ++c) {
        float& value = image.at(x, y, c);
        value = static_cast<float>(srgb_decode(static_cast<double>(value)));
      }
    }
  }
  return image;
}

LayeredImage read_layered_image(const std::filesystem::path& path) {
  LayeredImage result{path, {}, {}};
  result.channels = read_linear_colours(path, &result.names);
  return result;
}

Image layer_of(const LayeredImage& image_file, const std::string& layer) {
  const auto& [path, all, names] = image_file;
  std::vector<int> chosen;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const bool inside =
        layer.empty() ? names[c].size() == 1 : names[c] == layer || names[c].starts_with(layer + ".");
    if (inside) chosen.push_back(static_cast<int>(c));
  }
  if (chosen.empty()) {
    throw_input_error({path.string()}, "no layer '{}'; the file's channels are {}", layer,
                      fmt::join(names, ", "));
  }
  Image image(all.width(), all.height(), static_cast<int>(chosen.size()));
  for (int y = 0; y < all.height(); ++y) {
    for (int x = 0; x < all.width(); ++x) {
      for (int c = 0; c < image.channels(); ++c) {
        image.at(x, y, c) = all.at(x, y, chosen[static_cast<std::size_t>(c)]);
      }
    }
  }
  return image;
}

Image rgb_of(const LayeredImage& image_file, const std::string& layer) {
  const std::filesystem::path& path = image_file.path;
  const Image all = layer_of(image_file, layer);
  if (all.channels() < 3) {
    throw_input_error({path.string()}, "has {} {} channels; R, G, B are needed", all.channels(),
                      layer.empty() ? "plain" : "'" + layer + "'");
  }
  Image image(all.width(), all.height(), 3);
  for (int y = 0; y < all.height(); ++y) {
    for (int x = 0; x < all.width(); ++x) image.set_rgb(x, y, all.rgb(x, y));
  }
  for (const float v : image.data()) {
    if (!std::isfinite(v)) throw_input_error({path.string()}, "holds a value that is not finite");
  }
  return image;
}

Image read_exr_layer(const std::filesystem::path& path, const std::string& layer) {
  return layer_of(read_layered_image(path), layer);
}

Image read_rgb(const std::filesystem::path& path, const std::string& layer) {
  return rgb_of(read_layered_image(path), layer);
}

}  // namespace truescatter
