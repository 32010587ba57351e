#pragma once

#include <vector>

#include "core/vec.h"

namespace truescatter {

enum class TapPlacement { median, centroid };

// One tap of a one-dimensional Gaussian filter that is shared by three channels.
struct GaussianTap {
  double offset_mm;
  Vec3d weight;  // per channel; sums to 1 over the taps
};

// Mikkelsen 2010, section 5: `count` taps of equal probability under the first channel's Gaussian, each at
// its bin's median or centroid; the other channels' weights are the masses of their own Gaussians in the same
// bins.
std::vector<GaussianTap> equal_probability_taps(int count, const Vec3d& std_dev_mm, TapPlacement placement);

}  // namespace truescatter
