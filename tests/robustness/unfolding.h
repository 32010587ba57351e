#pragma once

#include <array>
#include <map>
#include <span>
#include <vector>

#include "irradiance/mesh_point.h"

namespace truescatter::test {

// A third opinion on a geodesic distance, for a few pairs of points: faces are unfolded one after another in
// long double, by their lengths in space, from the source and from every vertex, and everything that is seen
// along a straight line is noted; chains of such lines are put together by Dijkstra's algorithm. No window is
// ever dropped but for its length, and any vertex may bend a path, so that no reasoning on what a shortest
// path may do can be wrong. The mesh is manifold, oriented, and has no triangle without area.
class Unfolding {
 public:
  Unfolding(std::span<const Vec3d> positions_mm, std::span<const std::array<int, 3>> triangles);

  // Infinite where no path is shorter than `bound_mm`. Points on edges lie in either face; a point with
  // barycentric coordinates of exactly 0, 0, 1 is the vertex.
  long double distance_mm(const MeshPoint& source, const MeshPoint& target, long double bound_mm) const;

 private:
  struct Flat {
    long double x;
    long double y;
  };
  // What one place sees in straight lines.
  struct Seen {
    std::map<int, long double> vertices;
    long double target;
  };
  // What lies beyond an edge, seen from the origin between two directions.
  struct Cone {
    int left_vertex;
    int right_vertex;
    Flat left;  // positions of the edge's ends
    Flat right;
    Flat left_ray;
    Flat right_ray;
  };
  static long double cross(const Flat& a, const Flat& b) { return a.x * b.y - a.y * b.x; }
  static long double length(const Flat& a);
  static long double distance_to_line(const Flat& a, const Flat& b);
  Flat third(const Cone& cone, int vertex) const;
  std::array<Flat, 3> laid_flat(std::size_t face) const;

  void see_from_point(const MeshPoint& source, const MeshPoint& target, long double bound, Seen& seen) const;
  void see_from_vertex(int vertex, const MeshPoint& target, long double bound, Seen& seen) const;
  void follow(Cone cone, const MeshPoint& target, long double bound, Seen& seen) const;
  int vertex_of(const MeshPoint& point) const;  // -1: none

  std::vector<std::array<long double, 3>> positions_mm_;
  std::vector<std::array<int, 3>> triangles_;
  std::map<std::pair<int, int>, std::size_t> face_of_edge_;  // by the edge's ends, as the face runs
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> corners_of_vertex_;
};

}  // namespace truescatter::test
