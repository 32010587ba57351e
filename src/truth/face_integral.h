#pragma once

#include <array>
#include <span>
#include <vector>

#include "truth/geodesic_surface.h"

namespace truescatter {

// The convolution over the pieces of one face, window by window; the formula stands at GeodesicExactEngine.
class FaceIntegral {
 public:
  // `quadrature_error`: of the mass of a plane, what the quadrature over one stretch of a piece's edge may
  // err by.
  FaceIntegral(const IntrinsicMesh& mesh, const GeodesicField& field, std::size_t face,
               double quadrature_error);

  // Adds each layer's integral over the pieces of `component` to `sums`.
  void add(std::span<const FlatPiece> pieces, int component, std::span<const TruthLayer> layers,
           std::span<Vec4d> sums);

 private:
  void choose(std::size_t w);
  std::vector<double> equal_lengths(const GeodesicWindow& rival, const Vec2d& a, const Vec2d& b) const;
  bool may_take(const GeodesicWindow& rival, const std::vector<Vec2d>& shared) const;
  double owned_up_to(const Vec2d& u) const;
  Vec4d owned(const FlatPiece& piece, const TruthLayer& layer) const;
  template <typename Integrand>
  Vec4d adaptive(const Integrand& integrand, double from, double to, int depth) const;

  std::array<Vec2d, 3> corners_;
  double size_mm_ = 0.0;  // of the face
  double quadrature_error_;
  std::vector<GeodesicWindow> windows_;
  const GeodesicWindow* window_ = nullptr;  // the current one
  std::vector<const GeodesicWindow*> rivals_;
  std::vector<Vec2d> turning_points_;  // seen from the source, directions in which the owner may change
};

}  // namespace truescatter
