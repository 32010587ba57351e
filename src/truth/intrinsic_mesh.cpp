#include "truth/intrinsic_mesh.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/error.h"
#include "truth/t_junction.h"

namespace truescatter {
namespace {

// A fan is as wide as a plane if its angles sum to 2 pi within what rounding makes of them.
constexpr double kFlat = 1e-10;

std::uint64_t directed_key(int from, int to) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(from)) << 32U) |
         static_cast<std::uint32_t>(to);
}

std::string text_of(const Vec3d& p) { return fmt::format("({:.9g}, {:.9g}, {:.9g})", p.x(), p.y(), p.z()); }

}  // namespace

bool IntrinsicMesh::Vertex::bends_paths() const { return open || angle > 2.0 * kPi + kFlat; }

IntrinsicMesh::IntrinsicMesh(std::span<const Vec3d> positions_mm,
                             std::span<const std::array<int, 3>> triangles, const SourceLocation& where)
    : faces_(triangles.begin(), triangles.end()), vertices_(positions_mm.size()) {
  lay_flat(positions_mm, where);
  connect(where);
  refuse_t_junctions(positions_mm, where);
  make_fans(positions_mm, where);
}

void IntrinsicMesh::lay_flat(std::span<const Vec3d> positions_mm, const SourceLocation& where) {
  corners_.reserve(faces_.size());
  edges_.reserve(faces_.size());
  angles_.reserve(faces_.size());
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    std::array<Vec3d, 3> x;
    for (std::size_t j = 0; j < 3; ++j) x[j] = positions_mm[static_cast<std::size_t>(faces_[f][j])];
    const Vec3d a = x[1] - x[0];
    const Vec3d b = x[2] - x[0];
    const double length = a.norm();
    const double twice_area = a.cross(b).norm();
    // Unfolding turns by angles that a needle's rounding leaves without meaning.
    const double longest = std::max({length, b.norm(), (x[2] - x[1]).norm()});
    if (!(twice_area > 1e-12 * longest * longest)) {
      throw_input_error(where, "triangle {} at {} has no area: geodesics cannot be unfolded across it", f,
                        text_of(x[0]));
    }
    corners_.push_back({Vec2d::Zero(), Vec2d(length, 0.0), Vec2d(a.dot(b) / length, twice_area / length)});
    lengths_.push_back({length, (x[2] - x[1]).norm(), b.norm()});
    // From differences in space: those of corners would give a needle's short edge a direction that is off by
    // rounding of the long ones over its length, and so would turn all that is unfolded across it.
    const Vec3d c = x[2] - x[1];
    edges_.push_back({Vec2d(length, 0.0), Vec2d(c.dot(a) / length, twice_area / length),
                      Vec2d(-b.dot(a) / length, -twice_area / length)});
    std::array<double, 3> angle;
    for (std::size_t j = 0; j < 3; ++j) {
      const Vec3d u = x[(j + 1) % 3] - x[j];
      const Vec3d v = x[(j + 2) % 3] - x[j];
      angle[j] = std::atan2(u.cross(v).norm(), u.dot(v));
    }
    angles_.push_back(angle);
  }
}

void IntrinsicMesh::connect(const SourceLocation& where) {
  std::unordered_map<std::uint64_t, std::pair<int, int>> by_edge;
  by_edge.reserve(3 * faces_.size());
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (int j = 0; j < 3; ++j) {
      const auto [found, fresh] =
          by_edge.try_emplace(directed_key(vertex(f, j), vertex(f, next_corner(j))), static_cast<int>(f), j);
      if (!fresh) {
        throw_input_error(where,
                          "triangles {} and {} run along one edge in the same direction: an edge of three "
                          "triangles, or neighbours of opposite winding, leaves geodesics without one answer",
                          found->second.first, f);
      }
    }
  }
  crossings_.resize(faces_.size());
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (int j = 0; j < 3; ++j) {
      const auto found = by_edge.find(directed_key(vertex(f, next_corner(j)), vertex(f, j)));
      if (found == by_edge.end()) continue;
      const auto [g, k] = found->second;
      Crossing& crossing = crossings_[f][static_cast<std::size_t>(j)];
      crossing.face = g;
      crossing.edge = k;
      // Corner j here is corner k + 1 there, corner j + 1 here is corner k there.
      const Vec2d& here = edges_[f][static_cast<std::size_t>(j)];
      const Vec2d there = -edges_[static_cast<std::size_t>(g)][static_cast<std::size_t>(k)];
      const double scale = 1.0 / (here.norm() * there.norm());
      crossing.cos = here.dot(there) * scale;
      crossing.sin = (here.x() * there.y() - here.y() * there.x()) * scale;
      const Vec2d middle_here = 0.5 * (corner(f, j) + corner(f, next_corner(j)));
      const Vec2d middle_there = 0.5 * (corner(static_cast<std::size_t>(g), k) +
                                        corner(static_cast<std::size_t>(g), next_corner(k)));
      crossing.shift = middle_there - crossing.apply(middle_here);
    }
  }
}

void IntrinsicMesh::make_fans(std::span<const Vec3d> positions_mm, const SourceLocation& where) {
  offsets_.resize(faces_.size());
  std::vector<int> uses(vertices_.size(), 0);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (int j = 0; j < 3; ++j) {
      Vertex& v = vertices_[static_cast<std::size_t>(vertex(f, j))];
      ++uses[static_cast<std::size_t>(vertex(f, j))];
      // A fan starts at its open edge; a closed one anywhere.
      if (v.first_face < 0 || crossing(f, j).face < 0) {
        v.first_face = static_cast<int>(f);
        v.first_corner = j;
        v.open = crossing(f, j).face < 0;
      }
    }
  }
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    Vertex& v = vertices_[i];
    int face = v.first_face;
    int j = v.first_corner;
    int count = 0;
    while (face >= 0) {
      const auto f = static_cast<std::size_t>(face);
      offsets_[f][static_cast<std::size_t>(j)] = v.angle;
      v.angle += corner_angle(f, j);
      ++count;
      // On across the edge that comes in at the corner; there it is the one that leaves it.
      const Crossing& across = crossing(f, next_corner(next_corner(j)));
      face = across.face;
      j = across.edge;
      if (face == v.first_face && j == v.first_corner) break;
    }
    if (count != uses[i]) {
      throw_input_error(where, "at the vertex {} two sheets touch: geodesics have no one answer there",
                        text_of(positions_mm[i]));
    }
  }
}

void IntrinsicMesh::refuse_t_junctions(std::span<const Vec3d> positions_mm,
                                       const SourceLocation& where) const {
  std::vector<OpenEdge> open;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (int j = 0; j < 3; ++j) {
      if (crossing(f, j).face < 0) open.push_back({vertex(f, j), vertex(f, next_corner(j)), f});
    }
  }
  const auto found = find_t_junction(positions_mm, open, [](std::size_t, std::size_t) { return true; });
  if (!found) return;
  throw_input_error(where,
                    "the vertex {} lies in the middle of an open edge of triangle {} (a T-junction): whether "
                    "geodesics cross there cannot be told",
                    text_of(positions_mm[static_cast<std::size_t>(found->vertex)]), found->triangle_at_edge);
}

}  // namespace truescatter
