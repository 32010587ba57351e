#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "metrics/contours.h"
#include "metrics/error_stats.h"

namespace truescatter {

// Relative error against the distance delta to the silhouette: in each bin sum(test - truth) / sum(truth). A
// bin whose mean true light is less than a thousandth of the picture's RMS has none: that close to black the
// quotient says how dark a shadow is, up to 1e15, and nothing of the method.
struct HaloProfile {
  double bin_mm = 0.0;
  std::vector<double> relative_error;  // bin i covers [i, i + 1) * bin_mm; NaN where no light is to speak of
  std::vector<std::size_t> pixels;
};

// How wrong a picture is along silhouettes (README, Definitions), with s the widest standard deviation.
struct Halo {
  HaloProfile profile;  // to 6 s
  double peak = 0.0;    // largest |relative error| of a bin
  double width_mm =
      0.0;              // smallest delta beyond which every bin up to 6 s is within 1 %; NaN if there is none
  double energy = 0.0;  // sum |test - truth| within 3 s over sum truth there
  double contrast = 0.0;   // RMSE within 3 s over RMSE beyond 6 s
  std::size_t pixels = 0;  // within 3 s
};

// A distance from lines on the picture, by which errors are sorted.
struct Band {
  const std::vector<double>& delta_mm;  // of each pixel, row by row; infinite: none is near
  std::function<bool(std::size_t pixel)>
      counts;  // whether its nearest line is of the kind asked for; empty: yes
};

// The same numbers about any lines: `delta_mm` in place of the distance to silhouettes. Values as those of
// measure_halo.
Halo measure_band(const Image& test, const Image& truth, const Image& mask, const Band& band,
                  double widest_std_dev_mm, double mm_per_px, Quantity quantity);

// Which silhouettes count.
enum class HaloSide { all, outer, inner_near, inner_far };

// Every value is NaN where no pixel with light lies within 3 s of such a silhouette. `mask`: the pixels that
// count. `mm_per_px`: the size of a pixel at the view's median skin depth; bins are a quarter of it, or s/8,
// whichever is larger.
Halo measure_halo(const Image& test, const Image& truth, const Image& mask, const ContourMap& contours,
                  double widest_std_dev_mm, double mm_per_px, Quantity quantity, HaloSide side);

}  // namespace truescatter
