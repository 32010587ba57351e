// PLY, text and binary of either byte order. Read here and not by OpenMesh, whose PLY reader (9.0) reads
// binary double coordinates as zeros, takes the wrong number of bytes for face properties, and does not
// return from a header that is cut short.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/file.h"
#include "scene/soup.h"
#include "scene/text_lines.h"

namespace truescatter {
namespace {

enum class PlyFormat { ascii, little_endian, big_endian };
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  std::optional<PlyType> count_type;  // of a list
};

struct PlyElement {
  std::string name;
  int count = 0;
  std::vector<PlyProperty> properties;
};

PlyType parse_type(std::string_view word, const SourceLocation& where) {
  constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{{
      {"char", PlyType::int8},
      {"int8", PlyType::int8},
      {"uchar", PlyType::uint8},
      {"uint8", PlyType::uint8},
      {"short", PlyType::int16},
      {"int16", PlyType::int16},
      {"ushort", PlyType::uint16},
      {"uint16", PlyType::uint16},
      {"int", PlyType::int32},
      {"int32", PlyType::int32},
      {"uint", PlyType::uint32},
      {"uint32", PlyType::uint32},
      {"float", PlyType::float32},
      {"float32", PlyType::float32},
      {"double", PlyType::float64},
      {"float64", PlyType::float64},
  }};
  for (const auto& [name, type] : kTypes) {
    if (word == name) return type;
  }
  throw_input_error(where, "\"{}\" is not a type of PLY", word);
}

// The values of the body, one after the other, whatever the format.
class PlyValues {
 public:
  PlyValues(TextLines& lines, PlyFormat format) : lines_(lines), format_(format), bytes_(lines.rest()) {}

  double finite(PlyType type, std::string_view what) {
    if (format_ == PlyFormat::ascii) return parse_finite(word(what), where(), what);
    const double value = binary(type, what);
    if (!std::isfinite(value)) {
      throw_input_error(where(), "{} {}: {} is not finite: {} must be a finite number", element_, entry_,
                        value, what);
    }
    return value;
  }

  int integer(PlyType type, std::string_view what) {
    if (format_ == PlyFormat::ascii) return parse_integer(word(what), where(), what);
    const double value = binary(type, what);
    if (!(std::abs(value) <= 2147483647.0) || value != std::floor(value)) {
      throw_input_error(where(), "{} is not a whole number that {} can be", value, what);
    }
    return static_cast<int>(value);
  }

  void skip(PlyType type) {
    if (format_ == PlyFormat::ascii) {
      word("a value");
    } else {
      binary(type, "a value");
    }
  }

  // What is being read, for the messages of a binary body.
  void set_entry(std::string_view element, int entry) {
    element_ = element;
    entry_ = entry;
  }

  // A binary body has no lines.
  SourceLocation where() const {
    SourceLocation result = lines_.where();
    if (format_ != PlyFormat::ascii) result.line = 0;
    return result;
  }

 private:
  std::string_view word(std::string_view what) {
    while (next_word_ >= words_in_line_) {
      if (!lines_.next()) throw_input_error(where(), "the file ends where {} should follow", what);
      next_word_ = 0;
      words_in_line_ = lines_.words().size();
    }
    return lines_.words()[next_word_++];
  }

  double binary(PlyType type, std::string_view what) {
    switch (type) {
      case PlyType::int8:
        return static_cast<double>(take<std::int8_t>(what));
      case PlyType::uint8:
        return static_cast<double>(take<std::uint8_t>(what));
      case PlyType::int16:
        return static_cast<double>(take<std::int16_t>(what));
      case PlyType::uint16:
        return static_cast<double>(take<std::uint16_t>(what));
      case PlyType::int32:
        return static_cast<double>(take<std::int32_t>(what));
      case PlyType::uint32:
        return static_cast<double>(take<std::uint32_t>(what));
      case PlyType::float32:
        return static_cast<double>(take<float>(what));
      case PlyType::float64:
        return take<double>(what);
    }
    return 0.0;
  }

  template <typename T>
  T take(std::string_view what) {
    if (bytes_.size() < sizeof(T)) throw_input_error(where(), "the file ends where {} should follow", what);
    std::array<char, sizeof(T)> raw{};
    std::copy_n(bytes_.begin(), sizeof(T), raw.begin());
    bytes_.remove_prefix(sizeof(T));
    const bool file_is_little = format_ == PlyFormat::little_endian;
    if (file_is_little != (std::endian::native == std::endian::little)) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  TextLines& lines_;
  PlyFormat format_;
  std::string_view bytes_;
  std::string_view element_;
  int entry_ = 0;
  std::size_t next_word_ = 0;
  std::size_t words_in_line_ = 0;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
};

PlyFormat parse_format(const TextLines& lines) {
  const auto& words = lines.words();
  if (words.size() > 1 && words[1] == "ascii") return PlyFormat::ascii;
  if (words.size() > 1 && words[1] == "binary_little_endian") return PlyFormat::little_endian;
  if (words.size() > 1 && words[1] == "binary_big_endian") return PlyFormat::big_endian;
  throw_input_error(lines.where(), "\"{}\" is not ascii, binary_little_endian or binary_big_endian",
                    words.size() > 1 ? words[1] : "");
}

PlyElement parse_element(const TextLines& lines) {
  const auto& words = lines.words();
  if (words.size() < 3) throw_input_error(lines.where(), "an element needs a name and a count");
  PlyElement element{std::string(words[1]), parse_integer(words[2], lines.where(), "an element's count"), {}};
  if (element.count < 0) throw_input_error(lines.where(), "\"{}\": a count must not be negative", words[2]);
  return element;
}

PlyProperty parse_property(const TextLines& lines) {
  const auto& words = lines.words();
  const bool is_list = words.size() > 1 && words[1] == "list";
  if (words.size() < (is_list ? 5U : 3U))
    throw_input_error(lines.where(), "a property needs a type and a name");
  if (!is_list) return {std::string(words[2]), parse_type(words[1], lines.where()), std::nullopt};
  return {std::string(words[4]), parse_type(words[3], lines.where()), parse_type(words[2], lines.where())};
}

PlyHeader read_ply_header(TextLines& lines) {
  if (!lines.next() || (lines.words()[0] != "ply" && lines.words()[0] != "PLY")) {
    throw_input_error(lines.where(), "the first line of a PLY file must be \"ply\"");
  }
  PlyHeader header;
  while (lines.next()) {
    const std::string_view keyword = lines.words()[0];
    if (keyword == "end_header") return header;
    if (keyword == "format") {
      header.format = parse_format(lines);
    } else if (keyword == "element") {
      header.elements.push_back(parse_element(lines));
    } else if (keyword == "property") {
      if (header.elements.empty()) throw_input_error(lines.where(), "a property must follow an element");
      header.elements.back().properties.push_back(parse_property(lines));
    } else if (keyword != "comment" && keyword != "obj_info") {
      throw_input_error(lines.where(), "\"{}\" is not a keyword of a PLY header", keyword);
    }
  }
  throw_input_error(lines.where(), "the file ends before \"end_header\"");
}

// Where a vertex property goes: axis 0..2 of the position, 3..5 of the normal, 6..7 of the UV; -1: nowhere.
int vertex_slot(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, int>, 14> kSlots{{{"x", 0},
                                                                     {"y", 1},
                                                                     {"z", 2},
                                                                     {"nx", 3},
                                                                     {"ny", 4},
                                                                     {"nz", 5},
                                                                     {"u", 6},
                                                                     {"v", 7},
                                                                     {"s", 6},
                                                                     {"t", 7},
                                                                     {"texture_u", 6},
                                                                     {"texture_v", 7},
                                                                     {"texture_s", 6},
                                                                     {"texture_t", 7}}};
  for (const auto& [key, slot] : kSlots) {
    if (name == key) return slot;
  }
  return -1;
}

class PlyReader {
 public:
  PlyReader(const std::filesystem::path& path, std::string_view text)
      : lines_(path.string(), text), header_(read_ply_header(lines_)), values_(lines_, header_.format) {
    std::set<std::string_view> seen;
    for (const PlyElement& element : header_.elements) {
      if (!seen.insert(element.name).second)
        throw_input_error({path.string()}, "the header has the element \"{}\" twice", element.name);
      if (element.name == "vertex") inspect_vertex_element(element);
    }
  }

  Soup read() {
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;  // nothing is there to read, however many there are
      for (int i = 0; i < element.count; ++i) read_entry(element, i);
    }
    soup_.uvs.insert(soup_.uvs.end(), wedge_uvs_.begin(), wedge_uvs_.end());
    for (std::size_t i = 0; i < faces_.size(); ++i) soup_.add_face(static_cast<int>(i), faces_[i]);
    return std::move(soup_);
  }

 private:
  // Faces may come before the vertices, so this is known from the header.
  void inspect_vertex_element(const PlyElement& element) {
    std::array<bool, 8> has{};
    for (const PlyProperty& property : element.properties) {
      const int slot = property.count_type ? -1 : vertex_slot(property.name);
      if (slot >= 0) has[static_cast<std::size_t>(slot)] = true;
    }
    if (!has[0] || !has[1] || !has[2]) {
      throw_input_error({lines_.where().file, 0, 0},
                        "the element \"vertex\" needs the properties x, y and z");
    }
    vertex_count_ = element.count;
    vertices_have_normals_ = has[3] && has[4] && has[5];
    vertices_have_uvs_ = has[6] && has[7];
    vertex_uv_count_ = vertices_have_uvs_ ? element.count : 0;
  }

  void read_entry(const PlyElement& element, int index) {
    values_.set_entry(element.name, index);
    if (element.name == "vertex") {
      read_vertex(element);
    } else if (element.name == "face") {
      read_face(element, index);
    } else {
      for (const PlyProperty& property : element.properties) skip(property);
    }
  }

  void skip(const PlyProperty& property) {
    const int count = property.count_type ? values_.integer(*property.count_type, "a list's length") : 1;
    for (int i = 0; i < count; ++i) values_.skip(property.type);
  }

  void read_vertex(const PlyElement& element) {
    std::array<double, 8> slots{};
    for (const PlyProperty& property : element.properties) {
      const int slot = property.count_type ? -1 : vertex_slot(property.name);
      if (slot < 0) {
        skip(property);
      } else {
        const auto what = slot < 3   ? "a coordinate"
                          : slot < 6 ? "a normal's component"
                                     : "a texture coordinate";
        slots[static_cast<std::size_t>(slot)] = values_.finite(property.type, what);
      }
    }
    soup_.positions.emplace_back(slots[0], slots[1], slots[2]);
    if (vertices_have_normals_) soup_.normals.emplace_back(slots[3], slots[4], slots[5]);
    if (vertices_have_uvs_) soup_.uvs.emplace_back(slots[6], slots[7]);
  }

  void read_face(const PlyElement& element, int face) {
    std::vector<int> indices;
    std::vector<Vec2d> wedge_uvs;
    for (const PlyProperty& property : element.properties) {
      if (property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index")) {
        indices = read_indices(property);
      } else if (property.count_type && property.name == "texcoord") {
        wedge_uvs = read_wedge_uvs(property);
      } else {
        skip(property);
      }
    }
    if (indices.size() < 3) {
      throw_input_error(values_.where(), "face {} has {} corners, and needs 3 or more", face, indices.size());
    }
    add_face(indices, wedge_uvs);
  }

  std::vector<int> read_indices(const PlyProperty& property) {
    const int count = values_.integer(*property.count_type, "the count of a face's corners");
    std::vector<int> indices;
    for (int i = 0; i < count; ++i) {
      indices.push_back(values_.integer(property.type, "a vertex index"));
      if (indices.back() < 0 || indices.back() >= vertex_count_) {
        throw_input_error(values_.where(), "{} is out of range: a vertex index is 0 to {} here",
                          indices.back(), vertex_count_ - 1);
      }
    }
    return indices;
  }

  // u v of each corner, as MeshLab writes them.
  std::vector<Vec2d> read_wedge_uvs(const PlyProperty& property) {
    const int count = values_.integer(*property.count_type, "a list's length");
    std::vector<double> numbers;
    numbers.reserve(static_cast<std::size_t>(std::clamp(count, 0, 256)));  // not more on a broken file's word
    for (int i = 0; i < count; ++i) numbers.push_back(values_.finite(property.type, "a texture coordinate"));
    std::vector<Vec2d> uvs;
    uvs.reserve(numbers.size() / 2);
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) uvs.emplace_back(numbers[i], numbers[i + 1]);
    return uvs;
  }

  // A corner's own UV wins over its vertex's.
  void add_face(const std::vector<int>& indices, const std::vector<Vec2d>& wedge_uvs) {
    std::vector<SoupCorner> corners;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      SoupCorner corner{indices[i], vertices_have_uvs_ ? indices[i] : -1,
                        vertices_have_normals_ ? indices[i] : -1};
      if (wedge_uvs.size() == indices.size()) {
        corner.uv = vertex_uv_count_ + static_cast<int>(wedge_uvs_.size());
        wedge_uvs_.push_back(wedge_uvs[i]);
      }
      corners.push_back(corner);
    }
    faces_.push_back(std::move(corners));
  }

  TextLines lines_;
  PlyHeader header_;
  PlyValues values_;
  Soup soup_;
  std::vector<std::vector<SoupCorner>> faces_;
  std::vector<Vec2d> wedge_uvs_;
  int vertex_count_ = 0;
  int vertex_uv_count_ = 0;
  bool vertices_have_normals_ = false;
  bool vertices_have_uvs_ = false;
};

}  // namespace

Soup read_ply(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  return PlyReader(path, text).read();
}

}  // namespace truescatter
