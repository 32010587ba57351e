#include "metrics/seam.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "metrics/distance_field.h"

namespace truescatter {

std::vector<double> seam_distance_mm(const Image& seam, const Image& mask, const Image& position,
                                     double focal_px) {
  assert(seam.pixel_count() == mask.pixel_count() && position.pixel_count() == mask.pixel_count());
  std::vector<char> flagged(mask.pixel_count());
  for (std::size_t i = 0; i < flagged.size(); ++i) flagged[i] = seam.data()[i] != 0.0F ? 1 : 0;
  const DistanceField field = distance_to(flagged, mask.width(), mask.height());
  std::vector<double> delta_mm(flagged.size(), std::numeric_limits<double>::infinity());
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y, 0) == 0.0F) continue;
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width()) + static_cast<std::size_t>(x);
      delta_mm[i] = std::sqrt(field.squared_px[i]) * -static_cast<double>(position.at(x, y, 2)) / focal_px;
    }
  }
  return delta_mm;
}

std::vector<StretchBin> measure_stretch(const Image& test, const Image& truth, const Image& mask,
                                        const Image& anisotropy, Quantity quantity) {
  assert(anisotropy.pixel_count() == mask.pixel_count());
  std::vector<StretchBin> bins;
  for (std::size_t b = 0; b < kStretchBounds.size(); ++b) {
    const bool last = b + 1 == kStretchBounds.size();
    StretchBin bin;
    bin.from = kStretchBounds[b];
    bin.to = last ? std::numeric_limits<double>::infinity() : kStretchBounds[b + 1];
    Image inside(mask.width(), mask.height(), 1);
    for (std::size_t i = 0; i < mask.data().size(); ++i) {
      const double ratio = anisotropy.data()[i];
      // Rounding may leave an isotropic map just below 1.
      const bool above = b == 0 || ratio >= bin.from || std::isnan(ratio);
      const bool below = last || ratio < bin.to;
      inside.data()[i] = mask.data()[i] != 0.0F && above && below ? 1.0F : 0.0F;
    }
    const ErrorStats stats = error_stats(test, truth, inside, quantity);
    bin.pixels = stats.pixels;
    bin.bias = stats.bias;
    bin.rel_rmse = stats.rel_rmse;
    bins.push_back(bin);
  }
  return bins;
}

}  // namespace truescatter
