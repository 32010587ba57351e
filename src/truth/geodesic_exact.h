#pragma once

#include <span>

#include "truth/geodesic_surface.h"

namespace truescatter {

// The geodesic convolution to rounding: the certifier, slow.
//
// PieceIntegral over every piece in reach, to rounding: the formulas stand there.
class GeodesicExactEngine {
 public:
  // `search_std_devs`: see ExactEngine.
  explicit GeodesicExactEngine(const GeodesicSurface& surface, double search_std_devs = 8.6)
      : surface_(surface), search_std_devs_(search_std_devs) {}

  // (M_r, M_g, M_b, m) of each layer; `field` is scratch, and one serves one thread.
  std::vector<Vec4d> convolve(GeodesicField& field, const GeodesicTarget& target,
                              std::span<const TruthLayer> layers) const;
  // Every layer at every point, in parallel: [layer][point].
  TruthValues convolve(std::span<const GeodesicTarget> targets, std::span<const TruthLayer> layers) const;

 private:
  const GeodesicSurface& surface_;
  double search_std_devs_;
};

}  // namespace truescatter
