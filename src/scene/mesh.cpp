#include "scene/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace truescatter {
namespace {

// Twice the area, along the normal.
Vec3d area_vector(const Mesh& mesh, std::size_t triangle) {
  const Vec3d& a = mesh.corner(triangle, 0);
  return (mesh.corner(triangle, 1) - a).cross(mesh.corner(triangle, 2) - a);
}

double angle_between(const Vec3d& a, const Vec3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

double squared_distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - (a + t * ab)).squaredNorm();
}

// Sets of items that were joined: of corners that share a normal, of triangles that are connected.
class JoinedSets {
 public:
  explicit JoinedSets(std::size_t items) : parent_(items) { std::iota(parent_.begin(), parent_.end(), 0U); }

  std::size_t root(std::size_t item) {
    while (parent_[item] != item) {
      parent_[item] = parent_[parent_[item]];
      item = parent_[item];
    }
    return item;
  }

  void join(std::size_t a, std::size_t b) {
    const std::size_t root_a = root(a);
    const std::size_t root_b = root(b);
    // The lower index wins, so that the result does not depend on the order of joining.
    parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  }

 private:
  std::vector<std::size_t> parent_;
};

// One side of an edge: the triangle's corner at the edge's lower vertex and at its higher one.
struct EdgeSide {
  int low = 0;
  int high = 0;
  std::size_t low_corner = 0;
  std::size_t high_corner = 0;
};

std::vector<EdgeSide> sorted_edge_sides(const Mesh& mesh) {
  std::vector<EdgeSide> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3;
      EdgeSide side{mesh.triangles[t][c], mesh.triangles[t][next], 3 * t + c, 3 * t + next};
      if (side.low > side.high) {
        std::swap(side.low, side.high);
        std::swap(side.low_corner, side.high_corner);
      }
      sides.push_back(side);
    }
  }
  std::sort(sides.begin(), sides.end(), [](const EdgeSide& a, const EdgeSide& b) {
    return std::tie(a.low, a.high, a.low_corner) < std::tie(b.low, b.high, b.low_corner);
  });
  return sides;
}

void join_across_soft_edges(const Mesh& mesh, const std::vector<Vec3d>& face_normals, double crease_angle_deg,
                            JoinedSets& sets) {
  const double crease_angle = crease_angle_deg * kPi / 180.0;
  const std::vector<EdgeSide> sides = sorted_edge_sides(mesh);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t j = i + 1; j < sides.size(); ++j) {
      if (sides[j].low != sides[i].low || sides[j].high != sides[i].high) break;
      const Vec3d& a = face_normals[sides[i].low_corner / 3];
      const Vec3d& b = face_normals[sides[j].low_corner / 3];
      // A degenerate triangle has no direction: it joins nobody, and takes the smooth normal below.
      if (a.isZero(0.0) || b.isZero(0.0) || angle_between(a, b) > crease_angle) continue;
      sets.join(sides[i].low_corner, sides[j].low_corner);
      sets.join(sides[i].high_corner, sides[j].high_corner);
    }
  }
}

void join_at_vertices(const Mesh& mesh, JoinedSets& sets) {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> first(mesh.positions_mm.size(), kNone);
  for (std::size_t corner = 0; corner < 3 * mesh.triangles.size(); ++corner) {
    std::size_t& entry = first[static_cast<std::size_t>(mesh.triangles[corner / 3][corner % 3])];
    if (entry == kNone) entry = corner;
    sets.join(entry, corner);
  }
}

// The normalised sum, or the first direction of the others that has a length.
Vec3d unit_or(const Vec3d& sum, const Vec3d& second, const Vec3d& third) {
  for (const Vec3d* candidate : {&sum, &second, &third}) {
    const double length = candidate->norm();
    if (length > 0.0) return *candidate / length;
  }
  return Vec3d::UnitZ();
}

using PositionKey = std::array<std::uint64_t, 3>;

PositionKey position_key(const Vec3d& position) {
  PositionKey key{};
  for (int axis = 0; axis < 3; ++axis) {
    const double value = position[axis] + 0.0;  // -0.0 + 0.0 is 0.0
    std::memcpy(&key[static_cast<std::size_t>(axis)], &value, sizeof(value));
  }
  return key;
}

struct PositionHash {
  std::size_t operator()(const PositionKey& key) const {
    std::uint64_t hash = 0;
    for (const std::uint64_t part : key) {
      hash = (hash ^ part) * 0x9E3779B97F4A7C15ULL;
      hash ^= hash >> 29U;
    }
    return static_cast<std::size_t>(hash);
  }
};

}  // namespace

CornersByVertex::CornersByVertex(std::size_t vertices, std::size_t triangles,
                                 const std::function<std::array<int, 3>(std::size_t triangle)>& vertices_of)
    : first_(vertices + 1, 0), corners_(3 * triangles) {
  for (std::size_t t = 0; t < triangles; ++t) {
    for (const int v : vertices_of(t)) ++first_[static_cast<std::size_t>(v) + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<std::size_t> next = first_;
  for (std::size_t t = 0; t < triangles; ++t) {
    const std::array<int, 3> of_triangle = vertices_of(t);
    for (std::size_t c = 0; c < 3; ++c)
      corners_[next[static_cast<std::size_t>(of_triangle[c])]++] = 3 * t + c;
  }
}

Vec3d triangle_normal(const Mesh& mesh, std::size_t triangle) {
  const Vec3d vector = area_vector(mesh, triangle);
  const double length = vector.norm();
  if (length > 0.0) return vector / length;
  return Vec3d::Zero();
}

double triangle_area_mm2(const Mesh& mesh, std::size_t triangle) {
  return 0.5 * area_vector(mesh, triangle).norm();
}

double surface_area_mm2(const Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) sum += triangle_area_mm2(mesh, t);
  return sum;
}

double corner_angle_rad(const Mesh& mesh, std::size_t triangle, int c) {
  const Vec3d& at = mesh.corner(triangle, c);
  return angle_between(mesh.corner(triangle, (c + 1) % 3) - at, mesh.corner(triangle, (c + 2) % 3) - at);
}

std::uint64_t edge_key(int a, int b) {
  const auto low = static_cast<std::uint64_t>(std::min(a, b));
  const auto high = static_cast<std::uint64_t>(std::max(a, b));
  return (high << 32U) | low;
}

std::vector<int> label_components(std::size_t triangles,
                                  const std::function<std::array<int, 3>(std::size_t triangle)>& vertices_of,
                                  const std::function<bool(std::size_t triangle)>& included) {
  JoinedSets sets(triangles);
  std::unordered_map<std::uint64_t, std::size_t> first_with_edge;
  for (std::size_t t = 0; t < triangles; ++t) {
    if (!included(t)) continue;
    const std::array<int, 3> vertices = vertices_of(t);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [entry, fresh] =
          first_with_edge.try_emplace(edge_key(vertices[c], vertices[(c + 1) % 3]), t);
      if (!fresh) sets.join(entry->second, t);
    }
  }
  std::vector<int> component(triangles, -1);
  int count = 0;
  for (std::size_t t = 0; t < triangles; ++t) {
    if (!included(t)) continue;
    const std::size_t root = sets.root(t);  // the set's first triangle
    component[t] = root == t ? count++ : component[root];
  }
  return component;
}

double squared_distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d normal = (b - a).cross(c - a);
  const double length2 = normal.squaredNorm();
  // Twice the areas that the foot of the perpendicular makes with the edges, times |normal|.
  const bool inside = length2 > 0.0 && normal.dot((b - a).cross(p - a)) >= 0.0 &&
                      normal.dot((c - b).cross(p - b)) >= 0.0 && normal.dot((a - c).cross(p - c)) >= 0.0;
  if (inside) {
    const double height = normal.dot(p - a);
    return height * height / length2;
  }
  return std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                   squared_distance_to_segment(p, c, a)});
}

void set_angle_weighted_normals(Mesh& mesh, double crease_angle_deg) {
  const std::size_t triangles = mesh.triangles.size();
  std::vector<Vec3d> face_normals(triangles);
  for (std::size_t t = 0; t < triangles; ++t) face_normals[t] = triangle_normal(mesh, t);

  JoinedSets sets(3 * triangles);
  if (crease_angle_deg >= 180.0) {
    join_at_vertices(mesh, sets);
  } else {
    join_across_soft_edges(mesh, face_normals, crease_angle_deg, sets);
  }

  std::vector<Vec3d> set_sums(3 * triangles, Vec3d::Zero());
  std::vector<Vec3d> vertex_sums(mesh.positions_mm.size(), Vec3d::Zero());
  for (std::size_t corner = 0; corner < 3 * triangles; ++corner) {
    const std::size_t t = corner / 3;
    if (face_normals[t].isZero(0.0)) continue;
    const Vec3d weighted = corner_angle_rad(mesh, t, static_cast<int>(corner % 3)) * face_normals[t];
    set_sums[sets.root(corner)] += weighted;
    vertex_sums[static_cast<std::size_t>(mesh.triangles[t][corner % 3])] += weighted;
  }

  mesh.corner_normals.resize(triangles);
  for (std::size_t corner = 0; corner < 3 * triangles; ++corner) {
    const std::size_t t = corner / 3;
    const Vec3d& smooth = vertex_sums[static_cast<std::size_t>(mesh.triangles[t][corner % 3])];
    mesh.corner_normals[t][corner % 3] = unit_or(set_sums[sets.root(corner)], face_normals[t], smooth);
  }
}

std::vector<int> weld_coincident_positions(Mesh& mesh) {
  std::unordered_map<PositionKey, int, PositionHash> known;
  known.reserve(mesh.positions_mm.size());
  std::vector<Vec3d> unique;
  std::vector<int> new_vertex;
  new_vertex.reserve(mesh.positions_mm.size());
  for (const Vec3d& position : mesh.positions_mm) {
    const auto [entry, is_new] = known.try_emplace(position_key(position), static_cast<int>(unique.size()));
    if (is_new) unique.push_back(position);
    new_vertex.push_back(entry->second);
  }
  mesh.positions_mm = std::move(unique);
  for (std::array<int, 3>& triangle : mesh.triangles) {
    for (int& vertex : triangle) vertex = new_vertex[static_cast<std::size_t>(vertex)];
  }
  return new_vertex;
}

}  // namespace truescatter
