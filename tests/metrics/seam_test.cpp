#include "metrics/seam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "metrics/halo.h"

namespace truescatter {
namespace {

// A row of ten pixels at a depth of 500 mm, with 1000 pixels per unit: half a millimetre each. A seam passes
// through the third; the last is not skin.
TEST(SeamDistance, IsPixelsTimesDepthOverFocalLength) {
  Image seam(10, 1, 1);
  seam.at(2, 0, 0) = 1.0F;
  Image mask(10, 1, 1, 1.0F);
  mask.at(9, 0, 0) = 0.0F;
  Image position(10, 1, 3);
  for (int x = 0; x < 10; ++x) position.at(x, 0, 2) = -500.0F;
  position.at(5, 0, 2) = -1000.0F;
  const std::vector<double> delta_mm = seam_distance_mm(seam, mask, position, 1000.0);
  EXPECT_EQ(delta_mm[2], 0.0);
  EXPECT_EQ(delta_mm[0], 1.0);
  EXPECT_EQ(delta_mm[4], 1.0);
  EXPECT_EQ(delta_mm[5], 3.0);  // by its own depth
  EXPECT_TRUE(std::isinf(delta_mm[9]));
}

TEST(SeamDistance, IsInfiniteWithoutASeam) {
  const Image mask(3, 1, 1, 1.0F);
  for (const double delta : seam_distance_mm(Image(3, 1, 1), mask, Image(3, 1, 3, -1.0F), 100.0))
    EXPECT_TRUE(std::isinf(delta));
}

// A step beside a seam: truth 1, too bright by 1/8 up to 1 mm from it, right beyond. With s = 1 mm bins are
// 1/8 mm, one pixel in the middle of each. Peak 1/8, width 1 mm (eight bins), and of the 24 bins within 3 s
// eight err: energy (8/8)/24.
TEST(SeamBand, OfAStepOfKnownHeightAndWidth) {
  Image truth(64, 1, 3, 1.0F);
  Image test = truth;
  std::vector<double> delta_mm;
  for (int x = 0; x < 64; ++x) {
    delta_mm.push_back((x + 0.5) / 8.0);
    if (delta_mm.back() < 1.0) test.set_rgb(x, 0, Vec3d::Constant(1.125));
  }
  const Halo seam =
      measure_band(test, truth, Image(64, 1, 1, 1.0F), {delta_mm, {}}, 1.0, 0.1, Quantity::green);
  EXPECT_EQ(seam.peak, 0.125);
  EXPECT_EQ(seam.width_mm, 1.0);
  EXPECT_DOUBLE_EQ(seam.energy, 1.0 / 24.0);
  EXPECT_EQ(seam.pixels, 24U);
}

TEST(SeamBand, IsNotANumberWhereNoSeamIsSeen) {
  const std::vector<double> delta_mm(4, std::numeric_limits<double>::infinity());
  const Image picture(4, 1, 3, 1.0F);
  const Halo seam =
      measure_band(picture, picture, Image(4, 1, 1, 1.0F), {delta_mm, {}}, 1.0, 0.1, Quantity::green);
  EXPECT_TRUE(std::isnan(seam.peak));
  EXPECT_TRUE(std::isnan(seam.energy));
  EXPECT_EQ(seam.pixels, 0U);
}

// Anisotropies 1 1.25 1.5 4 20 inf NaN, the last pixel outside the mask; truths 1 3 2 2 1 1 1, errors +1 -1
// 1/2 0 -1 +1 +3:
//   1 to 1.5: bias 0, rel_rmse sqrt((1 + 1)/(1 + 9)); 1.5 to 2: 1/2 and 1/4; 3 to 5: 0 and 0;
//   16 and beyond: three pixels, bias (-1 + 1 + 3)/3 = 1, rel_rmse sqrt(11/3).
TEST(Stretch, OfSevenPixelsByHand) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<float> ratios = {1.0F, 1.25F, 1.5F, 4.0F, 20.0F, kInfinity, std::nanf(""), 6.0F};
  const std::vector<double> truths = {1, 3, 2, 2, 1, 1, 1, 1};
  const std::vector<double> errors = {1, -1, 0.5, 0, -1, 1, 3, 100};
  Image anisotropy(8, 1, 1);
  Image truth(8, 1, 3);
  Image test(8, 1, 3);
  for (int x = 0; x < 8; ++x) {
    const auto i = static_cast<std::size_t>(x);
    anisotropy.at(x, 0, 0) = ratios[i];
    truth.set_rgb(x, 0, Vec3d::Constant(truths[i]));
    test.set_rgb(x, 0, Vec3d::Constant(truths[i] + errors[i]));
  }
  Image mask(8, 1, 1, 1.0F);
  mask.at(7, 0, 0) = 0.0F;
  const std::vector<StretchBin> bins = measure_stretch(test, truth, mask, anisotropy, Quantity::red);
  ASSERT_EQ(bins.size(), 7U);
  EXPECT_EQ(bins[0].from, 1.0);
  EXPECT_EQ(bins[0].to, 1.5);
  EXPECT_EQ(bins[0].pixels, 2U);
  EXPECT_EQ(bins[0].bias, 0.0);
  EXPECT_DOUBLE_EQ(bins[0].rel_rmse, std::sqrt(0.2));
  EXPECT_EQ(bins[1].pixels, 1U);
  EXPECT_EQ(bins[1].bias, 0.5);
  EXPECT_EQ(bins[1].rel_rmse, 0.25);
  EXPECT_EQ(bins[2].pixels, 0U);
  EXPECT_TRUE(std::isnan(bins[2].bias));
  EXPECT_EQ(bins[3].pixels, 1U);
  EXPECT_EQ(bins[3].rel_rmse, 0.0);
  EXPECT_EQ(bins[4].pixels, 0U);
  EXPECT_TRUE(std::isinf(bins[6].to));
  EXPECT_EQ(bins[6].pixels, 3U);
  EXPECT_EQ(bins[6].bias, 1.0);
  EXPECT_DOUBLE_EQ(bins[6].rel_rmse, std::sqrt(11.0 / 3.0));
}

// A float's rounding below 1 is an isotropic map.
TEST(Stretch, NothingLiesBelowTheFirstBin) {
  const Image picture(1, 1, 3, 1.0F);
  EXPECT_EQ(measure_stretch(picture, picture, Image(1, 1, 1, 1.0F), Image(1, 1, 1, 0.9999999F), Quantity::red)
                .front()
                .pixels,
            1U);
}

}  // namespace
}  // namespace truescatter
