#include "truth/geodesic_field.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace truescatter {
namespace {

constexpr std::size_t kBuckets = 64;
// Two lengths are told apart if they differ by more than this share of the radius: thousands of roundings.
constexpr double kSame = 1e-11;
// A source this close to a corner, in barycentric coordinates, lies on it. On edges of some mm that moves it
// by some 1e-9 mm and a mass by 1e-8 at most; any closer, the faces round the corner, which see the source in
// coordinates of their own, would disagree by as much about the ray through the corner.
constexpr double kOnVertex = 3e-10;
constexpr double kSameAngle = 1e-12;
// An interval narrower than this share of its edge is within the rounding of its ends.
constexpr double kNarrow = 1e-14;

Vec2d rotated(const Vec2d& v, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

// Distance from s to the segment between a and b.
double distance_to_segment(const Vec2d& s, const Vec2d& a, const Vec2d& b) {
  const Vec2d ab = b - a;
  const Vec2d as = s - a;
  const double along = as.dot(ab);
  if (along <= 0.0) return as.norm();
  const double squared = ab.squaredNorm();
  if (along >= squared) return (b - s).norm();
  return std::abs(cross(ab, as)) / std::sqrt(squared);
}

// Where the ray from s along d meets the line through a and b, as a fraction from a to b, kept within [0, 1].
double meets_at(const Vec2d& s, const Vec2d& d, const Vec2d& a, const Vec2d& b) {
  const double at_a = cross(d, a - s);
  const double at_b = cross(d, b - s);
  const double difference = at_a - at_b;
  return difference == 0.0 ? 0.0 : std::clamp(at_a / difference, 0.0, 1.0);
}

}  // namespace

Vec2d flat_position(const IntrinsicMesh& mesh, const GeodesicPoint& point) {
  return point.barycentric[0] * mesh.corner(point.face, 0) +
         point.barycentric[1] * mesh.corner(point.face, 1) +
         point.barycentric[2] * mesh.corner(point.face, 2);
}

GeodesicField::GeodesicField(const IntrinsicMesh& mesh)
    : mesh_(mesh),
      fronts_(kBuckets),
      vertices_(kBuckets),
      stamp_(mesh.face_count(), 0),
      first_(mesh.face_count(), -1),
      seen_(3 * mesh.face_count()),
      state_(mesh.vertex_count()) {}

void GeodesicField::propagate(const GeodesicPoint& source, double radius_mm) {
  assert(radius_mm > 0.0 && std::isfinite(radius_mm));
  ++current_;
  radius_mm_ = radius_mm;
  bucket_mm_ = radius_mm / kBuckets;
  bucket_ = 0;
  windows_.clear();
  covered_.clear();
  for (auto& bucket : fronts_) bucket.clear();
  for (auto& bucket : vertices_) bucket.clear();

  Eigen::Index corner = 0;
  if (source.barycentric.maxCoeff(&corner) >= 1.0 - kOnVertex) {
    const int v = mesh_.vertex(source.face, static_cast<int>(corner));
    VertexState& state = state_[static_cast<std::size_t>(v)];
    state = {current_, 0.0, 0.0, 0.0};
    emit_wedge(v, 0.0, 0.0, mesh_.vertex(v).angle);
  } else {
    leave_source_face(source);
  }
  for (bucket_ = 0; bucket_ < kBuckets; ++bucket_) {
    while (!fronts_[bucket_].empty() || !vertices_[bucket_].empty()) {
      while (!fronts_[bucket_].empty()) {
        const Front front = fronts_[bucket_].back();
        fronts_[bucket_].pop_back();
        enter(front);
      }
      if (vertices_[bucket_].empty()) break;
      const VertexEvent event = vertices_[bucket_].back();
      vertices_[bucket_].pop_back();
      // Only what is still the shortest way to the vertex goes on from it.
      if (event.distance_mm <= vertex_distance(event.vertex)) emit(event.vertex);
    }
  }
}

double GeodesicField::distance(std::size_t face, const Vec2d& x) const {
  double shortest = std::numeric_limits<double>::infinity();
  // A ray's direction is known to rounding, so its place at x to 1e-15 of the radius times the unfoldings.
  const double slack = 1e-11 * radius_mm_;
  double nearest = slack;
  double nearest_length = shortest;
  for (std::int32_t i = first_window(face); i >= 0; i = windows_[static_cast<std::size_t>(i)].next) {
    const GeodesicWindow& window = windows_[static_cast<std::size_t>(i)];
    const double beyond = window.beyond_rays(x);
    if (beyond <= slack) shortest = std::min(shortest, window.distance(x));
    if (beyond < nearest) {
      nearest = beyond;
      nearest_length = window.distance(x);
    }
  }
  return std::min(shortest, nearest_length);
}

double GeodesicField::vertex_distance(int vertex) const {
  const VertexState& state = state_[static_cast<std::size_t>(vertex)];
  return state.stamp == current_ ? state.distance_mm : std::numeric_limits<double>::infinity();
}

void GeodesicField::cover(std::int32_t face, const GeodesicWindow& window) {
  const auto f = static_cast<std::size_t>(face);
  if (stamp_[f] != current_) {
    stamp_[f] = current_;
    first_[f] = -1;
    covered_.push_back(face);
  }
  windows_.push_back(window);
  windows_.back().next = first_[f];
  first_[f] = static_cast<std::int32_t>(windows_.size()) - 1;
}

void GeodesicField::push(double distance_mm, const Front& front) {
  if (!(distance_mm < radius_mm_)) return;
  const auto wanted = static_cast<std::size_t>(distance_mm / bucket_mm_);
  // A part of a window starts no nearer than the window, up to rounding.
  fronts_[std::clamp(wanted, bucket_, kBuckets - 1)].push_back(front);
}

void GeodesicField::leave_source_face(const GeodesicPoint& point) {
  const Vec2d source = flat_position(mesh_, point);
  cover(static_cast<std::int32_t>(point.face), {source, 0.0, Vec2d::Zero(), Vec2d::Zero(), true});
  // From barycentric coordinates, so that the ray to a corner has its full precision however near that is.
  std::array<Vec2d, 3> to_corner;
  for (int j = 0; j < 3; ++j) {
    const Vec2d& corner = mesh_.corner(point.face, j);
    to_corner[static_cast<std::size_t>(j)] =
        point.barycentric[next_corner(j)] * (corner - mesh_.corner(point.face, next_corner(j))) +
        point.barycentric[next_corner(next_corner(j))] *
            (corner - mesh_.corner(point.face, next_corner(next_corner(j))));
  }
  for (int j = 0; j < 3; ++j) {
    const Vec2d& to_right = to_corner[static_cast<std::size_t>(j)];
    const Vec2d& to_left = to_corner[static_cast<std::size_t>(next_corner(j))];
    reach_corner(point.face, j, to_right, 0.0);
    // Seen from the inside, an edge's first corner is to the right.
    pass_on(point.face, j, {source, 0.0, to_left.normalized(), to_right.normalized(), false}, 0.0, 1.0);
  }
}

void GeodesicField::reach_vertex(int vertex, double distance_mm, double arrives_at) {
  if (!(distance_mm < radius_mm_)) return;
  VertexState& state = state_[static_cast<std::size_t>(vertex)];
  if (state.stamp != current_) state = {current_};
  if (distance_mm >= state.distance_mm) return;
  state.distance_mm = distance_mm;
  state.arrives_at = arrives_at;
  if (!mesh_.vertex(vertex).bends_paths()) return;
  const auto wanted = static_cast<std::size_t>(distance_mm / bucket_mm_);
  vertices_[std::clamp(wanted, bucket_, kBuckets - 1)].push_back({vertex, distance_mm});
}

void GeodesicField::reach_corner(std::size_t face, int j, const Vec2d& arriving, double offset_mm) {
  const int vertex = mesh_.vertex(face, j);
  const double distance_mm = offset_mm + arriving.norm();
  if (distance_mm >= std::min(radius_mm_, vertex_distance(vertex))) return;  // as most do: spares the angle
  const Vec2d along = mesh_.corner(face, next_corner(j)) - mesh_.corner(face, j);
  const double angle = std::atan2(-cross(along, arriving), -along.dot(arriving));
  reach_vertex(vertex, distance_mm, mesh_.fan_offset(face, j) + angle);
}

void GeodesicField::pass_on(std::size_t face, int edge, const GeodesicWindow& rays, double from, double to) {
  const Vec2d& source = rays.source;
  const double offset_mm = rays.offset_mm;
  const IntrinsicMesh::Crossing& crossing = mesh_.crossing(face, edge);
  if (crossing.face < 0 || to - from < kNarrow) return;
  const Vec2d& a = mesh_.corner(face, edge);
  const Vec2d& b = mesh_.corner(face, next_corner(edge));
  const Vec2d ab = b - a;
  const Vec2d first = a + from * ab;
  const Vec2d last = a + to * ab;
  const double least = offset_mm + distance_to_segment(source, first, last);
  if (!(least < radius_mm_)) return;
  // Longer all along than a known path along the edge from one of its ends: of no use beyond it either.
  const double at_a = vertex_distance(mesh_.vertex(face, edge));
  const double at_b = vertex_distance(mesh_.vertex(face, next_corner(edge)));
  if (at_a < radius_mm_ || at_b < radius_mm_) {
    const double slack = kSame * radius_mm_;
    const double length = mesh_.edge_length(face, edge);
    // Whether a path of length `other` beats the window's to x.
    const auto beats = [&](double other, const Vec2d& x) {
      const double left = other + slack - offset_mm;
      return left < 0.0 || left * left < (x - source).squaredNorm();
    };
    if (beats(at_a + to * length, last) || beats(at_b + (1.0 - from) * length, first)) return;
  }
  const GeodesicWindow unfolded{crossing.apply(source), offset_mm, crossing.turn(rays.left),
                                crossing.turn(rays.right), false};
  push(least, {crossing.face, crossing.edge, unfolded, 1.0 - to, 1.0 - from});
}

void GeodesicField::enter(const Front& front) {
  const auto f = static_cast<std::size_t>(front.face);
  const int k = front.edge;
  const int opposite = next_corner(next_corner(k));
  const GeodesicWindow& rays = front.rays;
  const Vec2d& s = rays.source;
  const Vec2d& a = mesh_.corner(f, k);
  const Vec2d& b = mesh_.corner(f, next_corner(k));
  const Vec2d& v = mesh_.corner(f, opposite);
  cover(front.face, rays);

  const Vec2d to_v = v - s;
  const double over_left = cross(rays.left, to_v);    // positive: the vertex lies to the left of all rays
  const double over_right = cross(to_v, rays.right);  // positive: to the right
  bool goes_left = over_left < 0.0;
  bool goes_right = over_right < 0.0;
  const bool splits = goes_left && goes_right;
  const double rounding = kSame * radius_mm_;
  const double distance = rays.offset_mm + to_v.norm();
  // A vertex on a ray is reached too.
  if (over_left <= rounding && over_right <= rounding) reach_corner(f, opposite, to_v, rays.offset_mm);
  if (over_left < -rounding && over_right < -rounding) {
    Seen& seen = seen_[3 * f + static_cast<std::size_t>(k)];
    const double crosses_at = meets_at(s, to_v, a, b);
    if (seen.stamp != current_ || distance < seen.distance_mm) {
      seen = {current_, distance, crosses_at};
    } else if (distance > seen.distance_mm + rounding && std::abs(crosses_at - seen.crosses_at) > 1e-9) {
      (crosses_at < seen.crosses_at ? goes_right : goes_left) = false;
    }
  }
  // The left edge runs from v to a, the right one from b to v; a window that straddles v ends there.
  if (goes_left) {
    GeodesicWindow part = rays;
    if (splits) part.right = to_v.normalized();
    pass_on(f, opposite, part, splits ? 0.0 : meets_at(s, rays.right, v, a), meets_at(s, rays.left, v, a));
  }
  if (goes_right) {
    GeodesicWindow part = rays;
    if (splits) part.left = to_v.normalized();
    pass_on(f, next_corner(k), part, meets_at(s, rays.right, b, v),
            splits ? 1.0 : meets_at(s, rays.left, b, v));
  }
}

void GeodesicField::emit(int vertex) {
  VertexState& state = state_[static_cast<std::size_t>(vertex)];
  if (state.emitted_mm <= state.distance_mm) return;
  state.emitted_mm = state.distance_mm;
  const IntrinsicMesh::Vertex& v = mesh_.vertex(vertex);
  const double straight_on = state.arrives_at + kPi;
  const double other_way = state.arrives_at - kPi;
  if (v.open) {
    // The fan has ends: all that lies behind the straight continuations, on either side.
    if (straight_on < v.angle) emit_wedge(vertex, state.distance_mm, std::max(0.0, straight_on), v.angle);
    if (other_way > 0.0) emit_wedge(vertex, state.distance_mm, 0.0, std::min(v.angle, other_way));
  } else if (other_way + v.angle > straight_on) {
    emit_wedge(vertex, state.distance_mm, straight_on, other_way + v.angle);
  }
}

void GeodesicField::emit_wedge(int vertex, double offset_mm, double from, double to) {
  const IntrinsicMesh::Vertex& v = mesh_.vertex(vertex);
  int face = v.first_face;
  int j = v.first_corner;
  do {
    const auto f = static_cast<std::size_t>(face);
    const double begin = mesh_.fan_offset(f, j);
    const double width = mesh_.corner_angle(f, j);
    // The wedge may run past the end of a closed fan, once round.
    for (const double turn : {-v.angle, 0.0, v.angle}) {
      if (v.open && turn != 0.0) continue;
      const double low = std::max(from + turn - begin, 0.0);
      double high = std::min(to + turn - begin, width);
      // The end of an open fan is its last face's edge, and rounding must not part the two: paths along a
      // boundary edge would be lost, and all that lies behind its far end.
      if (high > width - kSameAngle) high = width;
      if (!(high > low)) continue;
      const Vec2d& s = mesh_.corner(f, j);
      const Vec2d& b = mesh_.corner(f, next_corner(j));
      const Vec2d& c = mesh_.corner(f, next_corner(next_corner(j)));
      const Vec2d along = (b - s).normalized();
      const Vec2d right = low > 0.0 ? rotated(along, low) : along;
      const Vec2d left = high < width ? rotated(along, high) : Vec2d((c - s).normalized());
      const GeodesicWindow rays{s, offset_mm, left, right, false};
      cover(face, rays);
      if (low <= 0.0) reach_corner(f, next_corner(j), b - s, offset_mm);
      if (high >= width) reach_corner(f, next_corner(next_corner(j)), c - s, offset_mm);
      const double first = low > 0.0 ? meets_at(s, right, b, c) : 0.0;
      const double last = high < width ? meets_at(s, left, b, c) : 1.0;
      pass_on(f, next_corner(j), rays, first, last);
    }
    const IntrinsicMesh::Crossing& across = mesh_.crossing(f, next_corner(next_corner(j)));
    face = across.face;
    j = across.edge;
  } while (face >= 0 && !(face == v.first_face && j == v.first_corner));
}

}  // namespace truescatter
