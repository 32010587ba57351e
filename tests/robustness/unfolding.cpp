#include "robustness/unfolding.h"

#include <cmath>
#include <limits>
#include <queue>

namespace truescatter::test {
namespace {

constexpr long double kInfinity = std::numeric_limits<long double>::infinity();
// Rays are known to long double's rounding times the number of unfoldings: what lies that close to a cone
// lies in it.
constexpr long double kSlack = 1e-16L;

}  // namespace

Unfolding::Unfolding(std::span<const Vec3d> positions_mm, std::span<const std::array<int, 3>> triangles)
    : triangles_(triangles.begin(), triangles.end()), corners_of_vertex_(positions_mm.size()) {
  for (const Vec3d& p : positions_mm) positions_mm_.push_back({p.x(), p.y(), p.z()});
  for (std::size_t f = 0; f < triangles_.size(); ++f) {
    for (std::size_t j = 0; j < 3; ++j) {
      face_of_edge_[{triangles_[f][j], triangles_[f][(j + 1) % 3]}] = f;
      corners_of_vertex_[static_cast<std::size_t>(triangles_[f][j])].emplace_back(f, j);
    }
  }
}

long double Unfolding::length(const Flat& a) { return std::sqrt(a.x * a.x + a.y * a.y); }

// From the origin to the segment's line, or to the nearer end where the foot lies outside.
long double Unfolding::distance_to_line(const Flat& a, const Flat& b) {
  const Flat e{b.x - a.x, b.y - a.y};
  const long double square = e.x * e.x + e.y * e.y;
  long double t = -(a.x * e.x + a.y * e.y) / square;
  t = std::min(std::max(t, 0.0L), 1.0L);
  return length({a.x + t * e.x, a.y + t * e.y});
}

namespace {

// Along a -> b and across, of a -> c: in units of length.
std::pair<long double, long double> along_and_across(const std::array<long double, 3>& a,
                                                     const std::array<long double, 3>& b,
                                                     const std::array<long double, 3>& c) {
  std::array<long double, 3> u{};
  std::array<long double, 3> v{};
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = b[i] - a[i];
    v[i] = c[i] - a[i];
  }
  const long double dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  const std::array<long double, 3> w = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                        u[0] * v[1] - u[1] * v[0]};
  const long double edge = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  return {dot / edge, std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) / edge};
}

}  // namespace

// Beyond the edge, as the origin sees it.
Unfolding::Flat Unfolding::third(const Cone& cone, int vertex) const {
  const auto at = [&](int v) -> const std::array<long double, 3>& {
    return positions_mm_[static_cast<std::size_t>(v)];
  };
  const auto [along, across] = along_and_across(at(cone.left_vertex), at(cone.right_vertex), at(vertex));
  Flat u{cone.right.x - cone.left.x, cone.right.y - cone.left.y};
  const long double edge = length(u);
  u = {u.x / edge, u.y / edge};
  return {cone.left.x + along * u.x - across * u.y, cone.left.y + along * u.y + across * u.x};
}

// Counter-clockwise.
std::array<Unfolding::Flat, 3> Unfolding::laid_flat(std::size_t face) const {
  std::array<std::array<long double, 3>, 3> x;
  for (std::size_t j = 0; j < 3; ++j) x[j] = positions_mm_[static_cast<std::size_t>(triangles_[face][j])];
  const long double edge = along_and_across(x[0], x[1], x[1]).first;
  const auto [along, across] = along_and_across(x[0], x[1], x[2]);
  return {Flat{0.0L, 0.0L}, Flat{edge, 0.0L}, Flat{along, across}};
}

int Unfolding::vertex_of(const MeshPoint& point) const {
  for (std::size_t j = 0; j < 3; ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    if (point.barycentric[(i + 1) % 3] == 0.0 && point.barycentric[(i + 2) % 3] == 0.0)
      return triangles_[point.triangle][j];
  }
  return -1;
}

void Unfolding::follow(Cone first, const MeshPoint& target, long double bound, Seen& seen) const {
  std::vector<Cone> open = {first};
  while (!open.empty()) {
    const Cone cone = open.back();
    open.pop_back();
    if (!(distance_to_line(cone.left, cone.right) < bound)) continue;
    // The edge runs from its left end to its right one in the face beyond.
    const auto found = face_of_edge_.find({cone.left_vertex, cone.right_vertex});
    if (found == face_of_edge_.end()) continue;
    const std::size_t face = found->second;
    int opposite = -1;
    for (const int v : triangles_[face]) {
      if (v != cone.left_vertex && v != cone.right_vertex) opposite = v;
    }
    const Flat c = third(cone, opposite);
    const auto sees = [&](const Flat& d) {
      const long double slack = kSlack * length(d);
      return cross(cone.right_ray, d) >= -slack * length(cone.right_ray) &&
             cross(d, cone.left_ray) >= -slack * length(cone.left_ray);
    };
    if (face == target.triangle) {
      Flat x{0.0L, 0.0L};
      for (std::size_t j = 0; j < 3; ++j) {
        const int v = triangles_[face][j];
        const Flat& corner = v == cone.left_vertex ? cone.left : v == cone.right_vertex ? cone.right : c;
        const long double b = target.barycentric[static_cast<Eigen::Index>(j)];
        x = {x.x + b * corner.x, x.y + b * corner.y};
      }
      if (sees(x)) seen.target = std::min(seen.target, length(x));
    }
    if (sees(c)) {
      const auto known = seen.vertices.try_emplace(opposite, length(c)).first;
      known->second = std::min(known->second, length(c));
    }
    const bool to_left = cross(c, cone.left_ray) > 0.0L;
    const bool to_right = cross(cone.right_ray, c) > 0.0L;
    if (to_left)
      open.push_back(
          {cone.left_vertex, opposite, cone.left, c, cone.left_ray, to_right ? c : cone.right_ray});
    if (to_right)
      open.push_back(
          {opposite, cone.right_vertex, c, cone.right, to_left ? c : cone.left_ray, cone.right_ray});
  }
}

void Unfolding::see_from_point(const MeshPoint& source, const MeshPoint& target, long double bound,
                               Seen& seen) const {
  const std::array<Flat, 3> corner = laid_flat(source.triangle);
  std::array<Flat, 3> to{};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t k = 0; k < 3; ++k) {
      const long double b = source.barycentric[static_cast<Eigen::Index>(k)];
      to[j] = {to[j].x + b * (corner[j].x - corner[k].x), to[j].y + b * (corner[j].y - corner[k].y)};
    }
  }
  // Barycentrics round to a sum that is not quite 1; what counts is their proportion.
  const long double sum =
      static_cast<long double>(source.barycentric[0]) + source.barycentric[1] + source.barycentric[2];
  for (Flat& d : to) d = {d.x / sum, d.y / sum};
  if (target.triangle == source.triangle) {
    Flat x{0.0L, 0.0L};
    for (std::size_t j = 0; j < 3; ++j) {
      const long double b = target.barycentric[static_cast<Eigen::Index>(j)];
      x = {x.x + b * to[j].x, x.y + b * to[j].y};
    }
    seen.target = std::min(seen.target, length(x));
  }
  for (std::size_t j = 0; j < 3; ++j) {
    const std::size_t next = (j + 1) % 3;
    const int right = triangles_[source.triangle][j];
    const int left = triangles_[source.triangle][next];
    seen.vertices.try_emplace(right, length(to[j]));
    follow({left, right, to[next], to[j], to[next], to[j]}, target, bound, seen);
  }
}

void Unfolding::see_from_vertex(int vertex, const MeshPoint& target, long double bound, Seen& seen) const {
  for (const auto& [face, j] : corners_of_vertex_[static_cast<std::size_t>(vertex)]) {
    MeshPoint at{face, Vec3d::Zero()};
    at.barycentric[static_cast<Eigen::Index>(j)] = 1.0;
    const std::array<Flat, 3> corner = laid_flat(face);
    const std::size_t k = (j + 1) % 3;
    const std::size_t l = (j + 2) % 3;
    const Flat right{corner[k].x - corner[j].x, corner[k].y - corner[j].y};
    const Flat left{corner[l].x - corner[j].x, corner[l].y - corner[j].y};
    if (face == target.triangle) {
      const long double bk = target.barycentric[static_cast<Eigen::Index>(k)];
      const long double bl = target.barycentric[static_cast<Eigen::Index>(l)];
      seen.target = std::min(seen.target, length({bk * right.x + bl * left.x, bk * right.y + bl * left.y}));
    }
    for (const auto& [v, d] : {std::pair(triangles_[face][k], right), std::pair(triangles_[face][l], left)})
      seen.vertices.try_emplace(v, length(d));
    follow({triangles_[face][l], triangles_[face][k], left, right, left, right}, target, bound, seen);
  }
}

long double Unfolding::distance_mm(const MeshPoint& source, const MeshPoint& target,
                                   long double bound_mm) const {
  long double shortest = kInfinity;
  std::map<int, long double> reached;
  using Event = std::pair<long double, int>;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events;
  const auto take = [&](const Seen& seen, long double offset) {
    shortest = std::min(shortest, offset + seen.target);
    for (const auto& [v, d] : seen.vertices) {
      const long double whole = offset + d;
      if (!(whole < std::min(bound_mm, shortest))) continue;
      const auto [known, fresh] = reached.try_emplace(v, whole);
      if (!fresh && known->second <= whole) continue;
      known->second = whole;
      events.emplace(whole, v);
    }
  };
  const int start = vertex_of(source);
  Seen seen{{}, kInfinity};
  if (start >= 0) {
    see_from_vertex(start, target, bound_mm, seen);
  } else {
    see_from_point(source, target, bound_mm, seen);
  }
  take(seen, 0.0L);
  while (!events.empty()) {
    const auto [offset, v] = events.top();
    events.pop();
    if (offset > reached[v] || !(offset < shortest)) continue;
    Seen beyond{{}, kInfinity};
    see_from_vertex(v, target, std::min(bound_mm, shortest) - offset, beyond);
    take(beyond, offset);
  }
  return shortest;
}

}  // namespace truescatter::test
