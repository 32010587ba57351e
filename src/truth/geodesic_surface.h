#pragma once

#include <span>
#include <vector>

#include "truth/geodesic_field.h"
#include "truth/surface.h"

namespace truescatter {

// A part of a face of the intrinsic mesh with irradiance linear between its corners: a shading triangle. The
// refinement lies in the plane of its face, so distances need the unrefined mesh only.
struct GeodesicPiece {
  std::size_t face = 0;
  std::array<Vec3d, 3> barycentric;  // of its corners, in the face, counter-clockwise
  std::array<Vec3d, 3> irradiance;   // RGB at the corners
  int component = 0;                 // light does not cross from one component to another
};

// The same in its face's frame.
struct FlatPiece {
  std::array<Vec2d, 3> corners_mm;
  std::array<Vec3d, 3> irradiance;
  int component = 0;

  double area_mm2() const;
  Vec2d centroid_mm() const { return (corners_mm[0] + corners_mm[1] + corners_mm[2]) / 3.0; }
  // From the centroid to the farthest corner.
  double radius_mm() const;
};

// The surface S of README, Definitions, as geodesics see it: its pieces on each face of the scene's mesh.
// Paths run over the whole mesh, whatever of it belongs to S.
class GeodesicSurface {
 public:
  GeodesicSurface(IntrinsicMesh mesh, std::span<const GeodesicPiece> pieces);

  const IntrinsicMesh& mesh() const { return mesh_; }
  std::span<const FlatPiece> pieces(std::size_t face) const {
    return std::span(pieces_).subspan(first_[face], first_[face + 1] - first_[face]);
  }
  // All of them, face by face; those of a face begin at first_piece.
  std::span<const FlatPiece> pieces() const { return pieces_; }
  std::size_t first_piece(std::size_t face) const { return first_[face]; }
  // As Surface::largest_irradiance.
  double largest_irradiance() const { return largest_irradiance_; }

 private:
  IntrinsicMesh mesh_;
  std::vector<FlatPiece> pieces_;   // by face
  std::vector<std::size_t> first_;  // by face, and one more
  double largest_irradiance_ = 0.0;
};

// Where a geodesic truth is wanted.
struct GeodesicTarget {
  GeodesicPoint point;
  int component = 0;
};

}  // namespace truescatter
