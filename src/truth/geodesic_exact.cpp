#include "truth/geodesic_exact.h"

#include <algorithm>
#include <vector>

#include "core/parallel.h"
#include "truth/piece_integral.h"

namespace truescatter {
namespace {
// Of the mass of a plane: how far Gauss and Kronrod may differ over one stretch of an edge. For a smooth
// integrand the finer of the two is then good to (200 * 1e-12)^1.5 = 3e-15.
constexpr double kQuadratureError = 1e-12;
}  // namespace

std::vector<Vec4d> GeodesicExactEngine::convolve(GeodesicField& field, const GeodesicTarget& target,
                                                 std::span<const TruthLayer> layers) const {
  double radius_mm = 0.0;
  for (const TruthLayer& layer : layers)
    radius_mm = std::max(radius_mm, std::min(layer.r_max_mm, search_std_devs_ * layer.std_dev_mm));
  field.propagate(target.point, radius_mm);
  std::vector<Vec4d> sums(layers.size(), Vec4d::Zero());
  PieceIntegral integral({true, kQuadratureError, search_std_devs_, surface_.largest_irradiance()});
  std::vector<const GeodesicWindow*> windows;
  for (const std::int32_t face : field.faces()) {
    windows.clear();
    for (std::int32_t i = field.first_window(static_cast<std::size_t>(face)); i >= 0;
         i = field.window(i).next)
      windows.push_back(&field.window(i));
    for (const FlatPiece& piece : surface_.pieces(static_cast<std::size_t>(face))) {
      if (piece.component == target.component) integral.add(piece, windows, layers, sums);
    }
  }
  return sums;
}

TruthValues GeodesicExactEngine::convolve(std::span<const GeodesicTarget> targets,
                                          std::span<const TruthLayer> layers) const {
  TruthValues values(layers.size(), std::vector<Vec4d>(targets.size(), Vec4d::Zero()));
  constexpr std::size_t kChunk = 8;
  parallel_for((targets.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    GeodesicField field(surface_.mesh());
    for (std::size_t i = chunk * kChunk; i < std::min(targets.size(), (chunk + 1) * kChunk); ++i) {
      const std::vector<Vec4d> sums = convolve(field, targets[i], layers);
      for (std::size_t l = 0; l < layers.size(); ++l) values[l][i] = sums[l];
    }
  });
  return values;
}

}  // namespace truescatter
