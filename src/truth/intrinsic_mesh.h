#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace truescatter {

// Counter-clockwise round a triangle.
inline int next_corner(int j) { return j == 2 ? 0 : j + 1; }

// A triangle mesh as geodesics see it: each face laid flat in a frame of its own, with the rigid motion that
// unfolds it onto the neighbour across each edge. Vertices at exactly the same position are one vertex, so
// that a file split at UV seams stays one surface. An open edge bounds the surface.
//
// Corner j of face f lies at corner(f, j), counter-clockwise, corner 0 at the origin and corner 1 on the x
// axis; edge j runs from corner j to corner j + 1 (mod 3), the face on its left.
class IntrinsicMesh {
 public:
  // Positions are unique, as a Mesh has them. Throws Error (input) that names the triangle (by its index,
  // from 0) or the vertex that leaves geodesics without one answer: a triangle without area, an edge of three
  // triangles or more, neighbours of opposite winding, a vertex where two sheets touch, and a vertex in the
  // middle of an open edge (a T-junction: whether a path may cross there cannot be told). `where`: the file
  // that the mesh is from, for these messages.
  IntrinsicMesh(std::span<const Vec3d> positions_mm, std::span<const std::array<int, 3>> triangles,
                const SourceLocation& where = {});

  std::size_t face_count() const { return corners_.size(); }
  std::size_t vertex_count() const { return vertices_.size(); }

  const Vec2d& corner(std::size_t face, int j) const { return corners_[face][static_cast<std::size_t>(j)]; }
  double edge_length(std::size_t face, int edge) const {
    return lengths_[face][static_cast<std::size_t>(edge)];
  }
  int vertex(std::size_t face, int j) const { return faces_[face][static_cast<std::size_t>(j)]; }

  // What lies across an edge: unfolding maps this face's frame to the neighbour's.
  struct Crossing {
    int face = -1;  // -1: nothing, the edge is open
    int edge = 0;   // the neighbour's index of the same edge, run the other way
    double cos = 1.0;
    double sin = 0.0;
    Vec2d shift = Vec2d::Zero();

    Vec2d turn(const Vec2d& direction) const {
      return {cos * direction.x() - sin * direction.y(), sin * direction.x() + cos * direction.y()};
    }
    Vec2d apply(const Vec2d& p) const { return turn(p) + shift; }
  };
  const Crossing& crossing(std::size_t face, int edge) const {
    return crossings_[face][static_cast<std::size_t>(edge)];
  }

  // The fan of faces around a vertex, counter-clockwise.
  struct Vertex {
    int first_face = -1;  // where the fan starts: at the open edge, if there is one
    int first_corner = 0;
    double angle = 0.0;  // of the whole fan
    bool open = false;   // the fan has two ends

    // Shortest paths may turn at it: the fan is wider than a plane, or has an end.
    bool bends_paths() const;
  };
  const Vertex& vertex(int v) const { return vertices_[static_cast<std::size_t>(v)]; }
  // Angle of corner j of a face, and where it starts in its vertex' fan: at the edge from corner j to j + 1.
  double corner_angle(std::size_t face, int j) const { return angles_[face][static_cast<std::size_t>(j)]; }
  double fan_offset(std::size_t face, int j) const { return offsets_[face][static_cast<std::size_t>(j)]; }

 private:
  void lay_flat(std::span<const Vec3d> positions_mm, const SourceLocation& where);
  void connect(const SourceLocation& where);
  void make_fans(std::span<const Vec3d> positions_mm, const SourceLocation& where);
  void refuse_t_junctions(std::span<const Vec3d> positions_mm, const SourceLocation& where) const;

  std::vector<std::array<int, 3>> faces_;  // vertices
  std::vector<std::array<Vec2d, 3>> corners_;
  std::vector<std::array<double, 3>> lengths_;  // of edges
  std::vector<std::array<Vec2d, 3>> edges_;     // from corner to corner, each to its own rounding
  std::vector<std::array<Crossing, 3>> crossings_;
  std::vector<std::array<double, 3>> angles_;
  std::vector<std::array<double, 3>> offsets_;
  std::vector<Vertex> vertices_;
};

}  // namespace truescatter
