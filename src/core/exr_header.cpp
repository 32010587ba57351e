#include "core/exr_header.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>

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

}  // namespace

// After eight bytes a header is a list of attributes, each a name, a type, a size and as many bytes; an empty
// name ends it. A file of several parts has several, and one without attributes at the end.
std::string oversized_exr_attribute(const std::filesystem::path& path) {
  constexpr std::uint32_t kMagic = 20000630;
  constexpr std::uint32_t kSeveralParts = 1U << 12U;
  std::ifstream in(path, std::ios::binary);
  std::uint32_t magic = 0;
  std::uint32_t version = 0;
  if (!read_word(in, magic) || magic != kMagic || !read_word(in, version)) return "";
  const auto bytes = static_cast<std::streamoff>(std::filesystem::file_size(path));
  bool is_first = true;  // of a header's attributes
  std::string name;
  std::string type;
  std::uint32_t size = 0;
  while (read_name(in, name)) {
    if (name.empty()) {
      if (is_first || (version & kSeveralParts) == 0U) return "";
      is_first = true;
      continue;
    }
    is_first = false;
    if (!read_name(in, type) || !read_word(in, size)) return "";
    const std::streamoff left = bytes - in.tellg();
    if (static_cast<std::streamoff>(size) > left)
      return fmt::format("attribute '{}' is of {} bytes, and {} are left of the file", name, size, left);
    in.seekg(size, std::ios::cur);
  }
  return "";
}

}  // namespace truescatter
