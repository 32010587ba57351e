#include "methods/pscbf/taps.h"

#include <gtest/gtest.h>

#include <algorithm>
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

// Green's and blue's mass in every red bin, by another route: the densities summed over a fine grid, whose
// points fall into the bin that red's mass so far says. A point that falls into the wrong one, and the
// midpoint rule, are worth a step of 1e-4 mm times the largest density, 0.38 / mm for blue: 4e-5, at either
// end.
TEST(EqualProbabilityTaps, WeightsAreTheMassesInEachRedBin) {
  constexpr int kCount = 13;
  constexpr double kStepMm = 1e-4;
  std::vector<Vec3d> mass(kCount, Vec3d::Zero());
  double red_so_far = 0.0;
  for (double x = -12.0 + 0.5 * kStepMm; x < 12.0; x += kStepMm) {
    Vec3d here;
    for (int c = 0; c < 3; ++c)
      here[c] =
          kStepMm * std::exp(-0.5 * x * x / (kTable1[c] * kTable1[c])) / (std::sqrt(2.0 * kPi) * kTable1[c]);
    const int bin = std::min(kCount - 1, static_cast<int>(kCount * (red_so_far + 0.5 * here[0])));
    mass[static_cast<std::size_t>(bin)] += here;
    red_so_far += here[0];
  }
  const std::vector<GaussianTap> taps = equal_probability_taps(kCount, kTable1, TapPlacement::median);
  for (std::size_t i = 0; i < taps.size(); ++i)
    EXPECT_LT((taps[i].weight - mass[i]).cwiseAbs().maxCoeff(), 8e-5) << i;
}

TEST(EqualProbabilityTaps, OfEachChannelAreItsOwnRedTaps) {
  const std::vector<GaussianTap> taps =
      equal_probability_taps_per_channel(5, kTable1, TapPlacement::centroid);
  ASSERT_EQ(taps.size(), 15U);
  for (int c = 0; c < 3; ++c) {
    const auto alone = equal_probability_taps(5, Vec3d::Constant(kTable1[c]), TapPlacement::centroid);
    for (std::size_t i = 0; i < 5; ++i) {
      const GaussianTap& tap = taps[5 * static_cast<std::size_t>(c) + i];
      EXPECT_EQ(tap.offset_mm, alone[i].offset_mm);
      EXPECT_EQ(tap.weight, Vec3d(alone[i].weight[0] * Vec3d::Unit(c)));
    }
  }
}

}  // namespace
}  // namespace truescatter
