#include "methods/pscbf/taps.h"

#include <gtest/gtest.h>

#include <cmath>

namespace truescatter {
namespace {

struct Moments {
  Vec3d sum = Vec3d::Zero();
  double mean = 0.0;
  double variance = 0.0;
};

Moments moments(const std::vector<GaussianTap>& taps) {
  Moments m;
  for (const GaussianTap& tap : taps) {
    m.sum += tap.weight;
    m.mean += tap.weight[0] * tap.offset_mm;
    m.variance += tap.weight[0] * tap.offset_mm * tap.offset_mm;
  }
  return m;
}

const Vec3d kTable1 = Vec3d(2.3, 1.4, 1.1).cwiseSqrt();

TEST(EqualProbabilityTaps, WeightsAreProbabilities) {
  for (const TapPlacement placement : {TapPlacement::median, TapPlacement::centroid}) {
    const std::vector<GaussianTap> taps = equal_probability_taps(13, kTable1, placement);
    const Moments m = moments(taps);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(m.sum[c], 1.0, 1e-14);
    EXPECT_NEAR(m.mean, 0.0, 1e-14);
    for (const GaussianTap& tap : taps) EXPECT_NEAR(tap.weight[0], 1.0 / 13.0, 1e-14);
  }
}

TEST(EqualProbabilityTaps, VarianceOfThirteen) {
  // Of the red variance: 0.907 with medians, 0.971 with centroids (design, to three digits).
  EXPECT_NEAR(moments(equal_probability_taps(13, kTable1, TapPlacement::median)).variance / 2.3, 0.907, 5e-4);
  EXPECT_NEAR(moments(equal_probability_taps(13, kTable1, TapPlacement::centroid)).variance / 2.3, 0.971,
              5e-4);
}

TEST(EqualProbabilityTaps, OtherChannelsWeighTheRedBins) {
  // The middle bin of 13 spans the quantiles 6/13 and 7/13 of red: +-0.0965586 s_red. Green's mass there is
  // erf(0.0965586 s_red / (s_green sqrt 2)).
  const std::vector<GaussianTap> taps = equal_probability_taps(13, kTable1, TapPlacement::median);
  const double half_bin = 0.0965586;  // inverse normal distribution of 7/13
  const double expected = std::erf(half_bin * std::sqrt(2.3 / 1.4) / std::sqrt(2.0));
  EXPECT_NEAR(taps[6].weight[1], expected, 1e-6);
  EXPECT_EQ(taps[6].offset_mm, 0.0);
  // Narrower channels weigh the outer bins less.
  EXPECT_LT(taps[0].weight[2], taps[0].weight[1]);
  EXPECT_LT(taps[0].weight[1], taps[0].weight[0]);
}

}  // namespace
}  // namespace truescatter
