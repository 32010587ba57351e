#include "core/image_io.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "core/exr_header.h"
#include "core/file.h"
#include "core/image_codec.h"
#include "core/plain_pictures.h"

namespace truescatter {

std::filesystem::path image_codec_file() {
  std::filesystem::path file =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / kImageCodecFile;
  if (!std::filesystem::exists(file))
    throw_run_error("{}: this part of the program, which reads pictures, is missing", file.string());
  return file;
}

namespace {

// Never closed: the libraries behind it have threads and objects of their own until the program ends.
const ImageCodec* open_codec() {
  void* library = dlopen(image_codec_file().c_str(), RTLD_LAZY | RTLD_LOCAL);
  // POSIX has dlsym's pointer to an object be one to a function.
  void* symbol = library != nullptr ? dlsym(library, kImageCodecFunction) : nullptr;
  if (symbol == nullptr)
    throw_run_error("cannot open the part of the program that reads pictures: {}", dlerror());
  return reinterpret_cast<const ImageCodec* (*)()>(symbol)();
}

std::string channel_name(const ExrLayer& layer, int channel) {
  static constexpr std::array<const char*, 4> kColour = {"R", "G", "B", "A"};
  static constexpr std::array<const char*, 4> kVector = {"X", "Y", "Z", "W"};
  if (layer.image->channels() == 1) return layer.name.empty() ? "Y" : layer.name;
  const auto& suffixes = layer.vector ? kVector : kColour;
  const std::string suffix = suffixes[static_cast<std::size_t>(channel)];
  return layer.name.empty() ? suffix : layer.name + "." + suffix;
}

void write_encoded(const std::filesystem::path& path, const EncodeRequest& request,
                   std::string (*encode)(const EncodeRequest&, std::vector<unsigned char>&)) {
  std::vector<unsigned char> bytes;
  if (const std::string wrong = encode(request, bytes); !wrong.empty())
    throw_run_error("{}: {}", path.string(), wrong);
  write_text_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

const ImageCodec& image_codec() {
  static const ImageCodec* const kCodec = open_codec();
  return *kCodec;
}

void write_exr(const std::filesystem::path& path, const std::vector<ExrLayer>& layers,
               const ImageTexts& texts) {
  assert(!layers.empty());
  const Image& first = *layers.front().image;
  EncodeRequest request{first.width(), first.height(), {}, nullptr, texts};
  for (const ExrLayer& layer : layers) {
    assert(layer.image->width() == first.width() && layer.image->height() == first.height());
    for (int c = 0; c < layer.image->channels(); ++c) request.channels.push_back(channel_name(layer, c));
  }

  const std::size_t channels = request.channels.size();
  std::vector<float> pixels(channels * first.pixel_count());
  std::size_t offset = 0;
  for (const ExrLayer& layer : layers) {
    const auto count = static_cast<std::size_t>(layer.image->channels());
    const std::span<const float> data = layer.image->data();
    for (std::size_t p = 0; p < first.pixel_count(); ++p) {
      std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(p * count), count,
                  pixels.begin() + static_cast<std::ptrdiff_t>(p * channels + offset));
    }
    offset += count;
  }
  request.pixels = pixels.data();
  write_encoded(path, request, encode_exr);
}

void write_png(const std::filesystem::path& path, const Image& image, const ImageTexts& texts) {
  std::vector<unsigned char> bytes(image.data().size());
  std::transform(image.data().begin(), image.data().end(), bytes.begin(), [](float v) {
    return static_cast<unsigned char>(std::lround(std::clamp(v, 0.0F, 1.0F) * 255.0F));
  });
  const std::vector<std::string> unnamed(static_cast<std::size_t>(image.channels()));
  write_encoded(path, {image.width(), image.height(), unnamed, bytes.data(), texts}, encode_png);
}

namespace {

// What a picture may ask for: 4 GiB of values, and no more than its file can hold. Deflated data is at least
// a thousandth of what it stands for; the lossy compressions of EXR get further, but not by as much again.
constexpr double kMostValues = 1024.0 * 1024.0 * 1024.0;
constexpr double kMostValuesPerByte = 65536.0;
// OpenImageIO (2.4) takes memory for 256 rows at once, however many there are: 1 GiB.
constexpr double kMostValuesInRow = 1024.0 * 1024.0;

double value_count(const PictureHeader& header) {
  return static_cast<double>(header.width) * header.height * static_cast<double>(header.channels.size());
}

void check_size(const std::filesystem::path& path, const PictureHeader& header) {
  const double values = value_count(header);
  if (values > kMostValues) {
    throw_input_error({path.string()}, "the image is {} x {} with {} channels; at most 2^30 values are read",
                      header.width, header.height, header.channels.size());
  }
  if (static_cast<double>(header.width) * double(header.channels.size()) > kMostValuesInRow) {
    throw_input_error({path.string()},
                      "the image is {} wide with {} channels; at most 2^20 values in a row are read",
                      header.width, header.channels.size());
  }
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  if (values > kMostValuesPerByte * bytes) {
    throw_input_error({path.string()},
                      "says it is {} x {} with {} channels, which a file of {} bytes cannot hold",
                      header.width, header.height, header.channels.size(), bytes);
  }
}

struct Picture {
  PictureHeader header;
  Image image;
};

Picture read_picture(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) throw_input_error({path.string()}, "no such file");
  if (const std::string wrong = wrong_exr_attribute(path); !wrong.empty())
    throw_input_error({path.string()}, "cannot read this image: {}", wrong);
  Picture picture;
  const auto storage = [&](const PictureHeader& header) {
    if (header.width <= 0 || header.height <= 0 || header.channels.empty() || header.depth > 1) {
      throw_input_error({path.string()}, "the image is {} x {} x {} with {} channels; a flat image is needed",
                        header.width, header.height, header.depth, header.channels.size());
    }
    check_size(path, header);
    picture.header = header;
    picture.image = Image(header.width, header.height, static_cast<int>(header.channels.size()));
    return picture.image.data().data();
  };
  if (decode_plain_exr(path, storage)) return picture;
  if (const std::string wrong = image_codec().decode(path, storage); !wrong.empty())
    throw_input_error({path.string()}, "{}", wrong);
  return picture;
}

}  // namespace

ImageTexts read_image_texts(const std::filesystem::path& path) { return read_picture(path).header.texts; }

Image read_image(const std::filesystem::path& path, std::vector<std::string>* channel_names) {
  Picture picture = read_picture(path);
  if (channel_names != nullptr) *channel_names = std::move(picture.header.channels);
  return std::move(picture.image);
}

double image_values(const std::filesystem::path& path) {
  if (!wrong_exr_attribute(path).empty()) return 0.0;
  double values = 0.0;
  const auto count = [&](const PictureHeader& header) {
    values = value_count(header);
    return static_cast<float*>(nullptr);
  };
  // What is wrong is said by who reads it.
  if (!decode_plain_exr(path, count)) image_codec().decode(path, count);
  return values;
}

Image read_linear_colours(const std::filesystem::path& path, std::vector<std::string>* channel_names) {
  auto [header, image] = read_picture(path);
  if (channel_names != nullptr) *channel_names = std::move(header.channels);
  if (header.is_float) return std::move(image);
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
