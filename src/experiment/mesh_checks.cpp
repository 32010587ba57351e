#include "experiment/mesh_checks.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "truth/t_junction.h"

namespace truescatter {

void refuse_repeated_triangles(const Mesh& mesh, std::span<const std::size_t> triangles,
                               const SourceLocation& where) {
  std::map<std::array<int, 3>, std::size_t> by_corners;
  for (const std::size_t t : triangles) {
    if (triangle_area_mm2(mesh, t) == 0.0) continue;
    std::array<int, 3> corners = mesh.triangles[t];
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    const auto [first, fresh] = by_corners.try_emplace(corners, t);
    if (fresh) continue;
    const Vec3d& at = mesh.corner(t, 0);
    throw_input_error(
        where,
        "faces {} and {} (from 0) are the same triangle, at ({:.9g}, {:.9g}, {:.9g}): its light "
        "would count twice",
        first->second, t, at.x(), at.y(), at.z());
  }
}

void refuse_parted_surface(const Mesh& mesh, std::span<const std::size_t> triangles,
                           std::span<const int> components, const SourceLocation& where) {
  std::map<std::uint64_t, int> uses;
  for (const auto& t : mesh.triangles) {
    for (std::size_t e = 0; e < 3; ++e) ++uses[edge_key(t[e], t[(e + 1) % 3])];
  }
  std::vector<OpenEdge> open;
  for (const std::size_t t : triangles) {
    const auto& v = mesh.triangles[t];
    for (std::size_t e = 0; e < 3; ++e) {
      if (uses[edge_key(v[e], v[(e + 1) % 3])] == 1) open.push_back({v[e], v[(e + 1) % 3], t});
    }
  }
  const auto found =
      find_t_junction(mesh.positions_mm, open, [&](std::size_t at_vertex, std::size_t at_edge) {
        return components[at_vertex] != components[at_edge];
      });
  if (!found) return;
  const Vec3d& at = mesh.positions_mm[static_cast<std::size_t>(found->vertex)];
  throw_input_error(
      where,
      "the vertex ({:.9g}, {:.9g}, {:.9g}) of face {} lies in the middle of an open edge of face "
      "{} (from 0; a T-junction), and nothing else joins the two: whether light passes from one "
      "to the other cannot be told",
      at.x(), at.y(), at.z(), found->triangle_at_vertex, found->triangle_at_edge);
}

}  // namespace truescatter
