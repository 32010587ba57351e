#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/image.h"
#include "metrics/error_stats.h"

namespace truescatter {

// Where UV seams lie in a picture, and how UV stretches the surface behind each pixel.
struct UvView {
  std::vector<double> seam_delta_mm;  // row by row: see seam_distance_mm
  Image anisotropy;                   // 1 channel, at least 1: see StretchBin
};

// The distance on screen of each pixel inside the mask to the nearest pixel that a seam passes through, times
// its depth over the focal length, mm; infinite outside the mask, and where no seam is seen. `seam`: 1 where
// one is. `position`: view space, mm, looking along -z.
std::vector<double> seam_distance_mm(const Image& seam, const Image& mask, const Image& position,
                                     double focal_px);

// Errors of the pixels at which the larger singular value of the UV map is `from` to `to` times the smaller.
struct StretchBin {
  double from = 1.0;
  double to = 0.0;  // not in it; infinite for the last
  std::size_t pixels = 0;
  double bias = 0.0;      // (1/n) sum (test - truth); NaN without a pixel
  double rel_rmse = 0.0;  // RMSE / RMS of the truth, both of these pixels; NaN where that is 0
};

inline constexpr std::array<double, 7> kStretchBounds = {1.0, 1.5, 2.0, 3.0, 5.0, 8.0, 16.0};

// One bin from each bound to the next, and one beyond the last, over the pixels where the mask is not 0. A UV
// map without area has an infinite anisotropy, or none (NaN): both count to the last bin.
std::vector<StretchBin> measure_stretch(const Image& test, const Image& truth, const Image& mask,
                                        const Image& anisotropy, Quantity quantity);

}  // namespace truescatter
