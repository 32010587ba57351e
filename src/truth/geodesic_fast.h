#pragma once

#include <functional>
#include <span>

#include "truth/geodesic_surface.h"

namespace truescatter {

// The geodesic truth that a run uses for every pixel: the same integrals as GeodesicExactEngine to an
// absolute error of `tolerance` times the largest irradiance (and `tolerance` for the mass).
//
// Distances are exact here too; the integrals are not. How the tolerance is spent:
// - Tail: nothing beyond the distance where a plane's remaining mass is tolerance/10.
// - Quadrature: each piece takes the cheapest rule whose errors over a plane sum to at most 0.3 tolerance
//   (gaussian_error), with the least length over the windows that may be the shortest there. Where no rule
//   will do, where r_max cuts a piece, and where the closed form is the cheaper, the piece takes
//   PieceIntegral's formulas, good to 1e-7 (to rounding for tolerances below 1e-5).
// - Kinks: where two windows cover a node and their paths arrive from directions that differ, the distance
// has
//   a kink somewhere near, and Gaussians lose their Taylor series. Each piece's kinks have a mean square
//   error (PieceNodes::kink_variance); until 4 deviations of their sum are within 0.5 tolerance, the pieces
//   that add most are divided, and then take the formula.
class GeodesicFastEngine {
 public:
  GeodesicFastEngine(const GeodesicSurface& surface, double tolerance);

  double tolerance() const { return tolerance_; }

  // Every layer at every point: [layer][point]. `advance`, if set, is told how many of the points x layers
  // are newly done; it is called from any thread. Bitwise the same for any number of jobs.
  TruthValues convolve(std::span<const GeodesicTarget> targets, std::span<const TruthLayer> layers,
                       const std::function<void(std::size_t)>& advance = {}) const;

  // As FastEngine::tail_bound.
  double tail_bound() const;

 private:
  const GeodesicSurface& surface_;
  double tolerance_;
};

}  // namespace truescatter
