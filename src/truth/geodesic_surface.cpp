#include "truth/geodesic_surface.h"

#include <algorithm>
#include <utility>

namespace truescatter {

double FlatPiece::area_mm2() const {
  const Vec2d a = corners_mm[1] - corners_mm[0];
  const Vec2d b = corners_mm[2] - corners_mm[0];
  return 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
}

double FlatPiece::radius_mm() const {
  const Vec2d centroid = centroid_mm();
  double radius = 0.0;
  for (const Vec2d& corner : corners_mm) radius = std::max(radius, (corner - centroid).norm());
  return radius;
}

GeodesicSurface::GeodesicSurface(IntrinsicMesh mesh, std::span<const GeodesicPiece> pieces)
    : mesh_(std::move(mesh)), pieces_(pieces.size()), first_(mesh_.face_count() + 1, 0) {
  largest_irradiance_ = std::numeric_limits<double>::min();
  for (const GeodesicPiece& piece : pieces) ++first_[piece.face + 1];
  for (std::size_t f = 0; f < mesh_.face_count(); ++f) first_[f + 1] += first_[f];
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (const GeodesicPiece& piece : pieces) {
    FlatPiece& flat = pieces_[next[piece.face]++];
    for (std::size_t c = 0; c < 3; ++c) {
      flat.corners_mm[c] = flat_position(mesh_, {piece.face, piece.barycentric[c]});
      flat.irradiance[c] = piece.irradiance[c];
      largest_irradiance_ = std::max(largest_irradiance_, piece.irradiance[c].cwiseAbs().maxCoeff());
    }
    flat.component = piece.component;
  }
}

}  // namespace truescatter
