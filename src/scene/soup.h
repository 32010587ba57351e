#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// What a file says, before any topology: no face is lost to a non-manifold edge, a repeated vertex or an
// orientation that disagrees with its neighbour's, and the file's order is kept. Internal to the loaders.
struct SoupCorner {
  int position = -1;
  int uv = -1;      // -1: none
  int normal = -1;  // -1: none
};

struct Soup {
  std::vector<Vec3d> positions;  // units of the file
  std::vector<Vec2d> uvs;        // v up
  std::vector<Vec3d> normals;    // not necessarily of unit length
  std::vector<std::array<SoupCorner, 3>> triangles;
  std::vector<int> face_of_triangle;  // index from 0 of the face in the file

  // Appends a face of three or more corners; a polygon is cut into triangles by ear clipping in its mean
  // plane. A convex polygon becomes the fan around its first corner.
  void add_face(int face, const std::vector<SoupCorner>& corners);
};

// Each throws Error (input) naming the file (and the line of a text) for what it cannot read, for
// coordinates that are not finite and for indices out of range.
Soup read_obj(const std::filesystem::path& path);
Soup read_ply(const std::filesystem::path& path);
Soup read_off(const std::filesystem::path& path);
Soup read_assimp(const std::filesystem::path& path);

}  // namespace truescatter
