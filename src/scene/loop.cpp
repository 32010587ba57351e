#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

#include "scene/load_mesh.h"

namespace truescatter {
namespace {

struct Edge {
  int low = 0;
  int high = 0;
  std::vector<int> opposite;  // the third vertex of each triangle at the edge
  // A boundary, or an edge of three and more triangles: the limit curve depends on the edge alone.
  bool is_crease() const { return opposite.size() != 2; }
};

struct EdgeTable {
  std::vector<Edge> edges;
  std::vector<std::array<int, 3>> of_triangle;  // edge c runs from corner c to corner c + 1
};

EdgeTable build_edges(const Mesh& mesh) {
  using Side = std::tuple<int, int, std::size_t>;  // low vertex, high vertex, 3 * triangle + corner
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < 3 * mesh.triangles.size(); ++i) {
    const auto [low, high] = std::minmax(mesh.triangles[i / 3][i % 3], mesh.triangles[i / 3][(i + 1) % 3]);
    sides.emplace_back(low, high, i);
  }
  std::sort(sides.begin(), sides.end());
  EdgeTable table;
  table.of_triangle.resize(mesh.triangles.size());
  for (const auto& [low, high, i] : sides) {
    if (table.edges.empty() || table.edges.back().low != low || table.edges.back().high != high) {
      table.edges.push_back({low, high, {}});
    }
    table.edges.back().opposite.push_back(mesh.triangles[i / 3][(i + 2) % 3]);
    table.of_triangle[i / 3][i % 3] = static_cast<int>(table.edges.size()) - 1;
  }
  return table;
}

const Vec3d& at(const Mesh& mesh, int vertex) { return mesh.positions_mm[static_cast<std::size_t>(vertex)]; }

// 3/8, 3/8, 1/8, 1/8 inside; the midpoint on a crease.
Vec3d edge_point(const Mesh& mesh, const Edge& edge) {
  const Vec3d ends = at(mesh, edge.low) + at(mesh, edge.high);
  if (edge.is_crease()) return 0.5 * ends;
  return 0.375 * ends + 0.125 * (at(mesh, edge.opposite[0]) + at(mesh, edge.opposite[1]));
}

// What lies around a vertex.
struct Ring {
  Vec3d neighbours = Vec3d::Zero();  // their sum
  int neighbour_count = 0;
  Vec3d crease_neighbours = Vec3d::Zero();
  int crease_count = 0;
};

std::vector<Ring> build_rings(const Mesh& mesh, const std::vector<Edge>& edges) {
  std::vector<Ring> rings(mesh.positions_mm.size());
  const auto add = [&](int vertex, int neighbour, bool crease) {
    Ring& ring = rings[static_cast<std::size_t>(vertex)];
    ring.neighbours += at(mesh, neighbour);
    ++ring.neighbour_count;
    if (!crease) return;
    ring.crease_neighbours += at(mesh, neighbour);
    ++ring.crease_count;
  };
  for (const Edge& edge : edges) {
    add(edge.low, edge.high, edge.is_crease());
    add(edge.high, edge.low, edge.is_crease());
  }
  return rings;
}

Vec3d vertex_point(const Vec3d& position, const Ring& ring) {
  if (ring.neighbour_count == 0) return position;
  if (ring.crease_count == 2) return 0.75 * position + 0.125 * ring.crease_neighbours;
  if (ring.crease_count != 0) return position;  // a corner: creases end or meet here
  const double n = ring.neighbour_count;
  const double beta = ring.neighbour_count == 3 ? 3.0 / 16.0 : 3.0 / (8.0 * n);  // Warren
  return (1.0 - n * beta) * position + beta * ring.neighbours;
}

// Corner triangles first, in the order of the corners, then the one in the middle.
template <typename T>
std::array<std::array<T, 3>, 4> split(const std::array<T, 3>& corner, const std::array<T, 3>& middle) {
  return {{{corner[0], middle[0], middle[2]},
           {middle[0], corner[1], middle[1]},
           {middle[2], middle[1], corner[2]},
           {middle[0], middle[1], middle[2]}}};
}

}  // namespace

Mesh loop_subdivide(const Mesh& mesh) {
  const EdgeTable table = build_edges(mesh);
  const std::vector<Ring> rings = build_rings(mesh, table.edges);
  const int first_edge_point = static_cast<int>(mesh.positions_mm.size());

  Mesh result;
  result.positions_mm.reserve(mesh.positions_mm.size() + table.edges.size());
  for (std::size_t v = 0; v < rings.size(); ++v) {
    result.positions_mm.push_back(vertex_point(mesh.positions_mm[v], rings[v]));
  }
  for (const Edge& edge : table.edges) result.positions_mm.push_back(edge_point(mesh, edge));

  result.triangles.reserve(4 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<int, 3> middle = table.of_triangle[t];
    for (int& vertex : middle) vertex += first_edge_point;
    for (const auto& child : split(mesh.triangles[t], middle)) result.triangles.push_back(child);
  }
  if (mesh.corner_uvs) {
    result.corner_uvs.emplace();
    result.corner_uvs->reserve(4 * mesh.triangles.size());
    for (const std::array<Vec2d, 3>& uv : *mesh.corner_uvs) {
      const std::array<Vec2d, 3> middle{0.5 * (uv[0] + uv[1]), 0.5 * (uv[1] + uv[2]), 0.5 * (uv[2] + uv[0])};
      for (const auto& child : split(uv, middle)) result.corner_uvs->push_back(child);
    }
  }
  set_angle_weighted_normals(result);
  return result;
}

}  // namespace truescatter
