#include "core/exr_header.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <string_view>

namespace truescatter {
namespace {

// Names have 255 characters at most; what is longer is for OpenEXR to refuse.
constexpr std::size_t kLongestName = 255;

// A text that a zero ends. False where it does not end within what a name may have.
bool read_name(std::istream& in, std::string& name) {
  name.clear();
  for (char c = 0; name.size() <= kLongestName && in.get(c);) {
    if (c == '\0') return true;
    name += c;
  }
  return false;
}

// Little-endian, as all numbers of the format.
bool read_word(std::istream& in, std::uint32_t& word) {
  std::array<char, 4> bytes{};
  if (!in.read(bytes.data(), bytes.size())) return false;
  word = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) word = (word << 8U) | static_cast<unsigned char>(bytes[i]);
  return true;
}

struct Attribute {
  std::string name;
  std::string type;
  std::uint32_t size = 0;  // bytes that it says it has
};

// Values of one length, by their types' names (OpenEXR's file layout, "Predefined Attribute Types").
const std::map<std::string_view, std::uint32_t> kFixedSizes = {{"box2i", 16},
                                                               {"box2f", 16},
                                                               {"chromaticities", 32},
                                                               {"compression", 1},
                                                               {"deepImageState", 1},
                                                               {"double", 8},
                                                               {"envmap", 1},
                                                               {"float", 4},
                                                               {"int", 4},
                                                               {"keycode", 28},
                                                               {"lineOrder", 1},
                                                               {"m33f", 36},
                                                               {"m33d", 72},
                                                               {"m44f", 64},
                                                               {"m44d", 128},
                                                               {"rational", 8},
                                                               {"tiledesc", 9},
                                                               {"timecode", 8},
                                                               {"v2i", 8},
                                                               {"v2f", 8},
                                                               {"v2d", 16},
                                                               {"v3i", 12},
                                                               {"v3f", 12},
                                                               {"v3d", 24}};

// The bytes of a list of channels: a name and 16 bytes each, and an empty name. It ends where the file does,
// else.
std::uint64_t channel_list_bytes(std::istream& in) {
  constexpr std::streamoff kChannel = 16;
  std::uint64_t bytes = 0;
  std::string name;
  while (read_name(in, name)) {
    bytes += name.size() + 1;
    if (name.empty()) break;
    in.seekg(kChannel, std::ios::cur);
    bytes += kChannel;
  }
  return bytes;
}

// A picture of 8-bit RGBA after its width and height.
std::uint64_t preview_bytes(std::istream& in) {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  if (!read_word(in, width) || !read_word(in, height)) return 0;
  constexpr std::uint64_t kMost = std::uint64_t{1} << 16U;  // more, and the product is more than any size
  return width > kMost || height > kMost ? UINT64_MAX : 8 + 4 * std::uint64_t{width} * height;
}

// Texts, each after its length.
std::uint64_t texts_bytes(std::istream& in, std::uint32_t size) {
  std::uint64_t bytes = 0;
  std::uint32_t length = 0;
  while (bytes < size && read_word(in, length)) {
    bytes += 4 + std::uint64_t{length};
    in.seekg(length, std::ios::cur);
  }
  return bytes;
}

// What OpenEXR reads for an attribute: it goes by the type, whatever size is said. Leaves `in` anywhere.
std::uint64_t bytes_by_type(std::istream& in, const Attribute& attribute) {
  if (const auto fixed = kFixedSizes.find(attribute.type); fixed != kFixedSizes.end()) return fixed->second;
  if (attribute.type == "chlist") return channel_list_bytes(in);
  if (attribute.type == "preview") return preview_bytes(in);
  if (attribute.type == "stringvector") return texts_bytes(in, attribute.size);
  return attribute.size;
}

// What is wrong with the length of an attribute whose value begins here, and `left` bytes before the file's
// end; empty: nothing. Leaves `in` behind the value.
std::string wrong_length(std::istream& in, const Attribute& attribute, std::streamoff left) {
  const std::streamoff value = in.tellg();
  if (static_cast<std::streamoff>(attribute.size) > left)
    return fmt::format("attribute '{}' is of {} bytes, and {} are left of the file", attribute.name,
                       attribute.size, left);
  if (bytes_by_type(in, attribute) != attribute.size)
    return fmt::format("attribute '{}' is said to be of {} bytes, which is not what its type {} takes",
                       attribute.name, attribute.size, attribute.type);
  in.clear();
  in.seekg(value + static_cast<std::streamoff>(attribute.size));
  return "";
}

}  // namespace

// After eight bytes a header is a list of attributes, each a name, a type, a size and as many bytes; an empty
// name ends it. A file of several parts has several, and one without attributes at the end.
std::string wrong_exr_attribute(const std::filesystem::path& path) {
  constexpr std::uint32_t kMagic = 20000630;
  constexpr std::uint32_t kSeveralParts = 1U << 12U;
  std::ifstream in(path, std::ios::binary);
  std::uint32_t magic = 0;
  std::uint32_t version = 0;
  if (!read_word(in, magic) || magic != kMagic || !read_word(in, version)) return "";
  const auto bytes = static_cast<std::streamoff>(std::filesystem::file_size(path));
  bool is_first = true;  // of a header's attributes
  Attribute attribute;
  while (read_name(in, attribute.name)) {
    if (attribute.name.empty()) {
      if (is_first || (version & kSeveralParts) == 0U) return "";
      is_first = true;
      continue;
    }
    is_first = false;
    if (!read_name(in, attribute.type) || !read_word(in, attribute.size)) return "";
    if (const std::string wrong = wrong_length(in, attribute, bytes - in.tellg()); !wrong.empty())
      return wrong;
  }
  return "";
}

}  // namespace truescatter
