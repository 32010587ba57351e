#include "core/plain_pictures.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <map>
#include <optional>
#include <thread>
#include <tuple>

namespace truescatter {
namespace {

// OpenEXR's own threads, of which a file's lines are compressed; beside parallel_for's, which wait for them.
int exr_threads() {
  static const int kThreads = [] {
    const int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    Imf::setGlobalThreadCount(threads);
    return threads;
  }();
  return kThreads;
}

class MemoryStream : public Imf::OStream {
 public:
  explicit MemoryStream(std::vector<unsigned char>& bytes) : Imf::OStream("memory"), bytes_(bytes) {}

  void write(const char text[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (bytes_.size() < at_ + size) bytes_.resize(at_ + size);
    std::copy_n(text, size, bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ += size;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t position) override { at_ = position; }

 private:
  std::vector<unsigned char>& bytes_;
  std::size_t at_ = 0;
};

Imf::Header header_of(const EncodeRequest& request) {
  Imf::Header header(request.width, request.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const std::string& channel : request.channels)
    header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  for (const auto& [name, text] : request.texts) header.insert(name, Imf::StringAttribute(text));
  return header;
}

// OpenImageIO orders the channels of a layer by their names, in ways of its own for some of them (Alpha,
// Depth, Y without X, ...). Where one of these stands: the same here.
constexpr std::array<const char*, 7> kOrder = {"R", "G", "B", "X", "Y", "Z", "A"};
constexpr std::array<const char*, 21> kOfItsOwn = {"r",  "red", "g",     "green", "b",     "blue", "x",
                                                   "y",  "z",   "a",     "ar",    "ra",    "ag",   "ga",
                                                   "ab", "ba",  "alpha", "depth", "zback", "real", "imag"};

struct ChannelName {
  std::string layer;  // with its dot
  std::string suffix;

  explicit ChannelName(const std::string& channel) : suffix(channel) {
    const std::size_t dot = channel.rfind('.');
    if (dot == std::string::npos) return;
    layer = channel.substr(0, dot + 1);
    suffix = channel.substr(dot + 1);
  }
  // The length of kOrder for names that come last, by the alphabet.
  std::size_t rank() const {
    return static_cast<std::size_t>(std::find(kOrder.begin(), kOrder.end(), suffix) - kOrder.begin());
  }
  bool is_of_its_own() const {
    std::string lower = suffix;
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return rank() == kOrder.size() && std::find(kOfItsOwn.begin(), kOfItsOwn.end(), lower) != kOfItsOwn.end();
  }
  bool operator<(const ChannelName& other) const {
    return std::tuple(layer, rank(), suffix) < std::tuple(other.layer, other.rank(), other.suffix);
  }
};

// Whether these, of one layer, come in that order: X, Y and Z if there are all three, and no A.
bool is_plainly_ordered(const std::vector<ChannelName>& layer) {
  if (layer.size() == 1) return true;
  const auto has = [&](const char* suffix) {
    return std::any_of(layer.begin(), layer.end(), [&](const auto& name) { return name.suffix == suffix; });
  };
  const int spatial = int{has("X")} + int{has("Y")} + int{has("Z")};
  return (spatial == 0 || (spatial == 3 && !has("A"))) &&
         std::none_of(layer.begin(), layer.end(), [](const auto& name) { return name.is_of_its_own(); });
}

bool is_plain(const Imf::Header& header) {
  if (header.hasTileDescription()) return false;
  std::map<std::string, std::vector<ChannelName>> layers;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    const Imf::Channel& channel = it.channel();
    if (channel.type == Imf::UINT || channel.xSampling != 1 || channel.ySampling != 1) return false;
    const ChannelName name(it.name());
    layers[name.layer].push_back(name);
  }
  return std::all_of(layers.begin(), layers.end(),
                     [](const auto& layer) { return is_plainly_ordered(layer.second); });
}

PictureHeader picture_header(const Imf::Header& header) {
  const Imath::Box2i& window = header.dataWindow();
  PictureHeader picture{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, 1, {}, true, {}};
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
    picture.channels.emplace_back(it.name());
  std::sort(picture.channels.begin(), picture.channels.end(),
            [](const std::string& a, const std::string& b) { return ChannelName(a) < ChannelName(b); });
  for (auto it = header.begin(); it != header.end(); ++it) {
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute());
    if (text != nullptr) picture.texts.emplace(it.name(), text->value());
  }
  return picture;
}

void read_pixels(Imf::InputFile& file, const PictureHeader& header, float* pixels) {
  const Imath::Box2i& window = file.header().dataWindow();
  const std::size_t channels = header.channels.size();
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < channels; ++c) {
    buffer.insert(header.channels[c],
                  Imf::Slice::Make(Imf::FLOAT, pixels + c, window, channels * sizeof(float),
                                   channels * sizeof(float) * static_cast<std::size_t>(header.width)));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
}

void append_number(std::string& bytes, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<char>((number >> static_cast<unsigned>(shift)) & 0xFFU));
}

std::string text_chunk(const std::string& name, const std::string& text) {
  const std::string content = "tEXt" + name + '\0' + text;
  std::string chunk;
  append_number(chunk, static_cast<std::uint32_t>(content.size() - 4));
  chunk += content;
  append_number(chunk, static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(content.data()),
                                                        static_cast<uInt>(content.size()))));
  return chunk;
}

constexpr std::size_t kPngSignature = 8;
constexpr std::size_t kPngHeaderEnd = kPngSignature + 4 + 4 + 13 + 4;  // length, "IHDR", content, checksum

}  // namespace

std::string encode_exr(const EncodeRequest& request, std::vector<unsigned char>& encoded) {
  encoded.clear();
  const std::size_t pixel_bytes = request.channels.size() * sizeof(float);
  try {
    MemoryStream stream(encoded);
    Imf::OutputFile file(stream, header_of(request), exr_threads());
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < request.channels.size(); ++c) {
      // OpenEXR only reads from there; its slices are those of reading too.
      char* first = const_cast<char*>(static_cast<const char*>(request.pixels)) + c * sizeof(float);
      buffer.insert(request.channels[c], Imf::Slice(Imf::FLOAT, first, pixel_bytes,
                                                    pixel_bytes * static_cast<std::size_t>(request.width)));
    }
    file.setFrameBuffer(buffer);
    file.writePixels(request.height);
  } catch (const std::exception& problem) {
    return std::string("cannot write image: ") + problem.what();
  }
  return "";
}

std::string encode_png(const EncodeRequest& request, std::vector<unsigned char>& encoded) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(request.width);
  image.height = static_cast<png_uint_32>(request.height);
  const std::size_t channels = request.channels.size();
  image.format = channels == 1 ? PNG_FORMAT_GRAY : channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<unsigned char> bytes(size);
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, request.pixels, 0, nullptr) == 0)
    return std::string("cannot write image: ") + image.message;
  std::string texts;
  for (const auto& [name, text] : request.texts) texts += text_chunk(name, text);
  const auto header_end = bytes.begin() + kPngHeaderEnd;
  encoded.assign(bytes.begin(), header_end);
  encoded.insert(encoded.end(), texts.begin(), texts.end());
  encoded.insert(encoded.end(), header_end, bytes.begin() + static_cast<std::ptrdiff_t>(size));
  return "";
}

bool decode_plain_exr(const std::filesystem::path& path,
                      const std::function<float*(const PictureHeader&)>& storage) {
  std::optional<Imf::InputFile> file;
  PictureHeader header;
  // What is wrong with a file is told by who reads all of them.
  try {
    file.emplace(path.c_str(), exr_threads());
    if (!file->isComplete() || !is_plain(file->header())) return false;
    header = picture_header(file->header());
  } catch (const std::exception&) {
    return false;
  }
  float* pixels = storage(header);
  if (pixels == nullptr) return true;
  try {
    read_pixels(*file, header, pixels);
  } catch (const std::exception&) {
    return false;
  }
  return true;
}

PictureSize png_size(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::array<unsigned char, kPngHeaderEnd> head{};
  stream.read(reinterpret_cast<char*>(head.data()), static_cast<std::streamsize>(head.size()));
  static constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  if (!stream || !std::equal(kSignature.begin(), kSignature.end(), head.begin())) return {};
  const auto number = [&](std::size_t at) {
    return static_cast<int>((unsigned{head[at]} << 24U) | (unsigned{head[at + 1]} << 16U) |
                            (unsigned{head[at + 2]} << 8U) | unsigned{head[at + 3]});
  };
  return {number(kPngSignature + 8), number(kPngSignature + 12)};
}

}  // namespace truescatter
