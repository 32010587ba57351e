// Wavefront OBJ. Read here and not by OpenMesh, whose OBJ reader (9.0) rounds positions to float, keeps one
// normal per vertex, drops faces that name a vertex twice (which shifts the index of every later face) and
// says nothing of indices that are out of range.
#include <string>
#include <string_view>

#include "core/error.h"
#include "core/file.h"
#include "scene/soup.h"
#include "scene/text_lines.h"

namespace truescatter {
namespace {

struct Face {
  int line = 0;
  std::vector<SoupCorner> corners;
};

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& path, std::string_view text)
      : name_(path.string()), lines_(name_, text) {}

  Soup read() {
    while (lines_.next()) {
      const std::string_view keyword = lines_.words().front();
      if (keyword == "v") soup_.positions.emplace_back(read_vector("a coordinate"));
      if (keyword == "vn") soup_.normals.emplace_back(read_vector("a normal's component"));
      if (keyword == "vt") soup_.uvs.emplace_back(read_uv());
      if (keyword == "f") read_face();
    }
    // Only now is it known how many there are: a face may come before its vertices.
    for (const Face& face : faces_) check_face(face);
    for (std::size_t i = 0; i < faces_.size(); ++i) soup_.add_face(static_cast<int>(i), faces_[i].corners);
    return std::move(soup_);
  }

 private:
  Vec3d read_vector(std::string_view what) const {
    const auto& words = lines_.words();
    if (words.size() < 4) {
      throw_input_error(lines_.where(), "\"{}\" has {} numbers, and needs 3", words[0], words.size() - 1);
    }
    Vec3d result;
    for (int axis = 0; axis < 3; ++axis) {
      result[axis] = parse_finite(words[static_cast<std::size_t>(axis) + 1], lines_.where(), what);
    }
    return result;
  }

  Vec2d read_uv() const {
    const auto& words = lines_.words();
    if (words.size() < 2) throw_input_error(lines_.where(), "\"vt\" has no number, and needs 1 or more");
    const double u = parse_finite(words[1], lines_.where(), "a texture coordinate");
    const double v = words.size() > 2 ? parse_finite(words[2], lines_.where(), "a texture coordinate") : 0.0;
    return {u, v};
  }

  void read_face() {
    const auto& words = lines_.words();
    if (words.size() < 4) {
      throw_input_error(lines_.where(), "a face has {} corners, and needs 3 or more", words.size() - 1);
    }
    Face face{lines_.line(), {}};
    face.corners.reserve(words.size() - 1);
    for (std::size_t i = 1; i < words.size(); ++i) face.corners.push_back(read_corner(words[i]));
    faces_.push_back(std::move(face));
  }

  // v, v/vt, v//vn or v/vt/vn
  SoupCorner read_corner(std::string_view word) const {
    const std::size_t first = word.find('/');
    const std::string_view vertex = word.substr(0, first);
    const std::string_view tail = first == std::string_view::npos ? "" : word.substr(first + 1);
    const std::size_t second = tail.find('/');
    const std::string_view uv = tail.substr(0, second);
    const std::string_view normal = second == std::string_view::npos ? "" : tail.substr(second + 1);
    SoupCorner corner;
    corner.position = read_index(vertex, soup_.positions.size(), "a vertex index");
    if (!uv.empty()) corner.uv = read_index(uv, soup_.uvs.size(), "a texture coordinate's index");
    if (!normal.empty()) corner.normal = read_index(normal, soup_.normals.size(), "a normal's index");
    return corner;
  }

  // From 1 upwards, or from -1 (the latest so far) downwards, to from 0 upwards.
  int read_index(std::string_view word, std::size_t count_so_far, std::string_view what) const {
    const int index = parse_integer(word, lines_.where(), what);
    const int count = static_cast<int>(count_so_far);
    if (index == 0) throw_input_error(lines_.where(), "0 is not {}: indices count from 1", what);
    if (index < -count) {
      throw_input_error(lines_.where(), "{} is out of range: {} counts back over the {} before it", index,
                        what, count);
    }
    return index > 0 ? index - 1 : count + index;
  }

  void check_face(const Face& face) const {
    for (const SoupCorner& corner : face.corners) {
      check_index(face, corner.position, soup_.positions.size(), "a vertex index");
      check_index(face, corner.uv, soup_.uvs.size(), "a texture coordinate's index");
      check_index(face, corner.normal, soup_.normals.size(), "a normal's index");
    }
  }

  void check_index(const Face& face, int index, std::size_t count, std::string_view what) const {
    if (index < static_cast<int>(count)) return;
    throw_input_error({name_, face.line, 0}, "{} is out of range: {} is at most {} here", index + 1, what,
                      count);
  }

  std::string name_;
  TextLines lines_;
  Soup soup_;
  std::vector<Face> faces_;
};

}  // namespace

Soup read_obj(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  return ObjReader(path, text).read();
}

}  // namespace truescatter
