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
// - Quadrature: a piece's distances are taken at the nodes of the cheapest rule whose errors over a plane sum
// to at
//   most 0.4 tolerance for the narrowest Gaussian that reaches it (gaussian_error), once for all Gaussians.
//   Where no rule will do, the face takes the exact engine's formula, with its angular quadrature at 1e-3
//   tolerance.
// - Kinks: where two windows cover a node and their paths arrive from directions that differ, the distance
// has a
//   kink somewhere near, and Gaussians lose their Taylor series. If the kink is strong enough to matter, by
//   the bound at `kink_error`, the face takes the exact engine's formula as well.
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
