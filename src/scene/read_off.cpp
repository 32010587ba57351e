// Geomview's OFF as text, with the prefixes ST, C and N. Read here and not by OpenMesh, whose OFF reader
// (9.0) does not return from a file with a comment behind its first line, and rounds positions to float.
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/file.h"
#include "scene/soup.h"
#include "scene/text_lines.h"

namespace truescatter {
namespace {

struct OffHeader {
  bool has_uvs = false;
  bool has_colours = false;
  bool has_normals = false;
  int vertices = 0;
  int faces = 0;
};

void read_keyword(std::string_view keyword, const SourceLocation& where, OffHeader& header) {
  const auto take = [&keyword](std::string_view prefix) {
    const bool found = keyword.substr(0, prefix.size()) == prefix;
    if (found) keyword.remove_prefix(prefix.size());
    return found;
  };
  const std::string_view whole = keyword;
  header.has_uvs = take("ST");
  header.has_colours = take("C");
  header.has_normals = take("N");
  if (keyword != "OFF") {
    throw_input_error(where, "\"{}\" is not the first word of an OFF file: [ST][C][N]OFF", whole);
  }
}

void need_line(TextLines& lines, std::string_view what) {
  if (!lines.next()) throw_input_error(lines.where(), "the file ends where {} should follow", what);
}

OffHeader read_off_header(TextLines& lines) {
  OffHeader header;
  need_line(lines, "\"OFF\"");
  std::vector<std::string_view> words = lines.words();
  read_keyword(words.front(), lines.where(), header);
  words.erase(words.begin());
  if (!words.empty() && words.front() == "BINARY") {
    throw_input_error(lines.where(), "\"BINARY\": only the text form of OFF is read");
  }
  if (words.empty()) {  // the counts may stand on the keyword's line
    need_line(lines, "the counts of vertices, faces and edges");
    words = lines.words();
  }
  if (words.size() < 2) throw_input_error(lines.where(), "the counts of vertices and faces are missing");
  header.vertices = parse_integer(words[0], lines.where(), "the count of vertices");
  header.faces = parse_integer(words[1], lines.where(), "the count of faces");
  if (header.vertices < 0 || header.faces < 0) {
    throw_input_error(lines.where(), "\"{} {}\": a count must not be negative", words[0], words[1]);
  }
  return header;
}

// x y z [nx ny nz] [r g b a] [s t]: the texture coordinates are the last two.
void read_vertex(const TextLines& lines, const OffHeader& header, Soup& soup) {
  const auto& words = lines.words();
  const std::size_t needed = 3 + (header.has_normals ? 3 : 0) + (header.has_uvs ? 2 : 0);
  if (words.size() < needed) {
    throw_input_error(lines.where(), "a vertex has {} numbers, and needs {}", words.size(), needed);
  }
  const auto number = [&](std::size_t i, std::string_view what) {
    return parse_finite(words[i], lines.where(), what);
  };
  soup.positions.emplace_back(number(0, "a coordinate"), number(1, "a coordinate"),
                              number(2, "a coordinate"));
  if (header.has_normals) {
    constexpr std::string_view kWhat = "a normal's component";
    soup.normals.emplace_back(number(3, kWhat), number(4, kWhat), number(5, kWhat));
  }
  if (header.has_uvs) {
    const std::size_t first = header.has_colours ? words.size() - 2 : needed - 2;
    soup.uvs.emplace_back(number(first, "a texture coordinate"), number(first + 1, "a texture coordinate"));
  }
}

void read_face(const TextLines& lines, const OffHeader& header, int face, Soup& soup) {
  const auto& words = lines.words();
  const int count = parse_integer(words[0], lines.where(), "the count of a face's corners");
  if (count < 3) throw_input_error(lines.where(), "a face has {} corners, and needs 3 or more", count);
  if (words.size() < static_cast<std::size_t>(count) + 1) {
    throw_input_error(lines.where(), "a face names {} vertices, and says that it has {}", words.size() - 1,
                      count);
  }
  std::vector<SoupCorner> corners;
  for (std::size_t i = 1; i <= static_cast<std::size_t>(count); ++i) {
    const int index = parse_integer(words[i], lines.where(), "a vertex index");
    if (index < 0 || index >= header.vertices) {
      throw_input_error(lines.where(), "{} is out of range: a vertex index is 0 to {} here", index,
                        header.vertices - 1);
    }
    corners.push_back({index, header.has_uvs ? index : -1, header.has_normals ? index : -1});
  }
  soup.add_face(face, corners);
}

}  // namespace

Soup read_off(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  TextLines lines(path.string(), text);
  const OffHeader header = read_off_header(lines);
  Soup soup;
  for (int i = 0; i < header.vertices; ++i) {
    need_line(lines, "a vertex");
    read_vertex(lines, header, soup);
  }
  for (int i = 0; i < header.faces; ++i) {
    need_line(lines, "a face");
    read_face(lines, header, i, soup);
  }
  return soup;
}

}  // namespace truescatter
