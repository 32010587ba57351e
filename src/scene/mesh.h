#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// A triangle mesh in millimetres. Vertices are unique by position: exactly coincident positions of a file
// (a file split at UV seams) are one vertex here; what may differ between the triangles around a vertex
// (UVs, normals) is stored per corner, in the order of the triangle's vertices.
struct Mesh {
  std::vector<Vec3d> positions_mm;
  std::vector<std::array<int, 3>> triangles;                    // counter-clockwise seen from outside
  std::vector<std::array<Vec3d, 3>> corner_normals;             // unit length, one per triangle corner
  std::optional<std::vector<std::array<Vec2d, 3>>> corner_uvs;  // v up: (0, 0) is the image's bottom left
  // How many characters it holds: copies of one mesh, of as many triangles each, one after the other. They
  // share no vertex, even where their positions coincide, and all have the same UVs.
  std::size_t characters = 1;

  std::size_t triangle_count() const { return triangles.size(); }
  bool has_uvs() const { return corner_uvs.has_value(); }
  std::size_t character_of(std::size_t triangle) const { return triangle / (triangles.size() / characters); }
  const Vec3d& corner(std::size_t triangle, int c) const {
    return positions_mm[static_cast<std::size_t>(triangles[triangle][static_cast<std::size_t>(c)])];
  }
};

// The corners of triangles by vertex, as 3 * triangle + corner, ascending.
class CornersByVertex {
 public:
  CornersByVertex(std::size_t vertices, std::size_t triangles,
                  const std::function<std::array<int, 3>(std::size_t triangle)>& vertices_of);

  std::span<const std::size_t> around(int vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    return std::span(corners_).subspan(first_[v], first_[v + 1] - first_[v]);
  }

 private:
  std::vector<std::size_t> first_;  // of each vertex, in corners_
  std::vector<std::size_t> corners_;
};

// Unit normal by the right-hand rule; zero for a degenerate triangle.
Vec3d triangle_normal(const Mesh& mesh, std::size_t triangle);
double triangle_area_mm2(const Mesh& mesh, std::size_t triangle);
double surface_area_mm2(const Mesh& mesh);
// The triangle's interior angle at its corner c.
double corner_angle_rad(const Mesh& mesh, std::size_t triangle, int c);

// The key of the edge between two vertices (indices, not negative), whichever way it runs.
std::uint64_t edge_key(int a, int b);

// The connected component of each triangle: those that share an edge are of one; numbered from 0 in the order
// of their first triangle. -1 where `included` is false, through which nothing connects.
std::vector<int> label_components(std::size_t triangles,
                                  const std::function<std::array<int, 3>(std::size_t triangle)>& vertices_of,
                                  const std::function<bool(std::size_t triangle)>& included);

// The exact squared distance of a point from a triangle: from its plane where the foot of the perpendicular
// lies inside, else from the nearest edge.
double squared_distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

// Sets every corner's normal to the angle-weighted mean of the face normals around its vertex, taken over
// those faces only that are joined to the corner's face by edges whose dihedral deviation is at most
// `crease_angle_deg` (180: one smooth normal per vertex).
void set_angle_weighted_normals(Mesh& mesh, double crease_angle_deg = 180.0);

// Merges exactly coincident positions. Returns the new vertex of every old one.
std::vector<int> weld_coincident_positions(Mesh& mesh);

}  // namespace truescatter
