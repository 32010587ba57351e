#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "truth/intrinsic_mesh.h"

namespace truescatter {

// A point of the surface: a face of the intrinsic mesh and barycentric coordinates in the order of its
// corners.
struct GeodesicPoint {
  std::size_t face = 0;
  Vec3d barycentric = Vec3d(1.0, 0.0, 0.0);
};

Vec2d flat_position(const IntrinsicMesh& mesh, const GeodesicPoint& point);

// A bundle of straight paths that covers a part of one face: those from `source`, unfolded into the face's
// frame, between two rays. At x the paths are offset + |x - source| long.
struct GeodesicWindow {
  Vec2d source;
  double offset_mm;  // length of the path up to the (pseudo-)source
  Vec2d left;   // rays from the source, unit; what lies between them, counter-clockwise from right to left,
  Vec2d right;  // is covered
  bool all_round;          // the whole face is covered: the face that the source lies in
  std::int32_t next = -1;  // of the same face

  // How far x lies beyond the rays; 0 or less: covered.
  double beyond_rays(const Vec2d& x) const {
    if (all_round) return 0.0;
    const Vec2d d = x - source;
    const double over_left = left.x() * d.y() - left.y() * d.x();
    const double over_right = d.x() * right.y() - d.y() * right.x();
    return std::max(over_left, over_right);
  }
  double distance(const Vec2d& x) const { return offset_mm + (x - source).norm(); }
};

// Exact polyhedral distances from one point, up to a radius, by propagation of windows (Mitchell, Mount &
// Papadimitriou 1987; Chen & Han 1990) through triangles, open vertices and saddles, which are
// pseudo-sources. A window that is dropped cannot hold a shortest path of a length up to the radius; those
// that are kept are real paths, so the least length over a face's windows is the distance.
//
// Windows are dropped where they start beyond the radius, where they are longer over their whole interval
// than a known path through an end of the edge, and by "one angle, one split": of two windows that cross one
// edge and both see the opposite vertex, strictly, only the shorter one passes on both sides (the other's
// rays on the side of the shorter one's path would have to cross that path).
//
// The work is proportional to what lies within the radius. One field serves one thread, source after source.
class GeodesicField {
 public:
  explicit GeodesicField(const IntrinsicMesh& mesh);

  // Forgets the last source. `radius_mm` is positive and finite.
  void propagate(const GeodesicPoint& source, double radius_mm);

  // The faces that some window covers, each once, in the order in which they were reached.
  std::span<const std::int32_t> faces() const { return covered_; }
  // The first window of a face, or -1; follow GeodesicWindow::next.
  std::int32_t first_window(std::size_t face) const { return stamp_[face] == current_ ? first_[face] : -1; }
  const GeodesicWindow& window(std::int32_t i) const { return windows_[static_cast<std::size_t>(i)]; }
  std::size_t window_count() const { return windows_.size(); }

  // The distance to a point given in a face's frame; infinite where it lies beyond the radius and was not
  // reached. Points closer than the radius are exact to rounding.
  double distance(std::size_t face, const Vec2d& x) const;

 private:
  // Paths about to enter a face through one of its edges, between two points of the edge.
  struct Front {
    std::int32_t face;
    std::int32_t edge;
    GeodesicWindow rays;  // in the face's frame; the edge's first corner is to their left
    double from;          // fractions of the edge, from its first corner
    double to;
  };
  struct VertexEvent {
    std::int32_t vertex;
    double distance_mm;
  };
  // The shortest window that sees the vertex opposite an edge, entering through that edge.
  struct Seen {
    std::uint32_t stamp = 0;
    double distance_mm = 0.0;
    double crosses_at = 0.0;  // fraction of the edge
  };
  struct VertexState {
    std::uint32_t stamp = 0;
    double distance_mm = std::numeric_limits<double>::infinity();
    double arrives_at = 0.0;  // direction back along the shortest path, as an angle of the vertex' fan
    double emitted_mm = std::numeric_limits<double>::infinity();
  };

  void cover(std::int32_t face, const GeodesicWindow& window);
  void leave_source_face(const GeodesicPoint& point);
  void enter(const Front& front);
  // Rays in `face` pass into the neighbour, through the part [from, to] of an edge. Their directions are
  // carried along, never taken from where they meet an edge: close to a vertex those places say little about
  // directions.
  void pass_on(std::size_t face, int edge, const GeodesicWindow& rays, double from, double to);
  void reach_vertex(int vertex, double distance_mm, double arrives_at);
  // `arriving`: from the (pseudo-)source to the corner.
  void reach_corner(std::size_t face, int j, const Vec2d& arriving, double offset_mm);
  void emit(int vertex);
  // Rays between two angles of a vertex' fan, offset_mm being the distance to the vertex.
  void emit_wedge(int vertex, double offset_mm, double from, double to);
  double vertex_distance(int vertex) const;
  void push(double distance_mm, const Front& front);

  const IntrinsicMesh& mesh_;
  std::uint32_t current_ = 0;
  double radius_mm_ = 0.0;
  double bucket_mm_ = 1.0;
  std::size_t bucket_ = 0;
  std::vector<std::vector<Front>> fronts_;          // by distance
  std::vector<std::vector<VertexEvent>> vertices_;  // by distance
  std::vector<GeodesicWindow> windows_;
  std::vector<std::int32_t> covered_;
  std::vector<std::uint32_t> stamp_;  // of first_
  std::vector<std::int32_t> first_;
  std::vector<Seen> seen_;  // by 3 face + edge
  std::vector<VertexState> state_;
};

}  // namespace truescatter
