#pragma once

#include <vector>

#include "core/vec.h"
#include "methods/settings.h"

namespace truescatter {

enum class TapPlacement { median, centroid };

// One tap of a one-dimensional Gaussian filter that is shared by three channels.
struct GaussianTap {
  double offset_mm;
  Vec3d weight;         // per channel; sums to 1 over the taps
  double low_mm = 0.0;  // its bin's ends; the outermost are infinite
  double high_mm = 0.0;
};

// Mikkelsen 2010, section 5: `count` taps of equal probability under the first channel's Gaussian, each at
// its bin's median or centroid; the other channels' weights are the masses of their own Gaussians in the same
// bins.
std::vector<GaussianTap> equal_probability_taps(int count, const Vec3d& std_dev_mm, TapPlacement placement);

// The same for each channel by itself: 3 `count` taps, each of weight 1 / count in one channel and 0 in the
// others.
std::vector<GaussianTap> equal_probability_taps_per_channel(int count, const Vec3d& std_dev_mm,
                                                            TapPlacement placement);

// What the methods with such taps share: the settings "taps" (N, 13) and "placement".
SettingSpec taps_setting();
SettingSpec placement_setting();
TapPlacement tap_placement(const Settings& settings);

}  // namespace truescatter
