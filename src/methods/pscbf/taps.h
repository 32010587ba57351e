#pragma once

#include <vector>

#include "core/vec.h"
#include "gpu/program.h"
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

// Taps as the shaders' uniforms tap_offset (shares of r_max), tap_weight and depth_factor (-1 / 2 variance).
struct TapUniforms {
  std::vector<float> offsets;
  std::vector<Vec3f> weights;
  Vec3d depth_factor;

  TapUniforms(const std::vector<GaussianTap>& taps, const Vec3d& variance_mm2, double r_max_mm);
  // The program must be in use.
  void set(const gpu::Program& program) const;
};

// What the methods with such taps share: the settings "taps" (N, 13) and "placement".
inline constexpr int kMaxTaps = 64;  // of one channel or of all
SettingSpec taps_setting();
SettingSpec placement_setting();
TapPlacement tap_placement(const Settings& settings);

}  // namespace truescatter
