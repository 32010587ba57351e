#include "core/image.h"

#include <gtest/gtest.h>

#include <limits>

namespace truescatter {
namespace {

TEST(Image, StoresRowsFromTheTopWithChannelsInterleaved) {
  Image image(3, 2, 4, 0.5F);
  EXPECT_EQ(image.pixel_count(), 6U);
  EXPECT_EQ(image.data().size(), 24U);
  image.at(2, 1, 3) = 7.0F;
  EXPECT_EQ(image.data()[(1 * 3 + 2) * 4 + 3], 7.0F);
  image.set_rgb(1, 0, {1.0, 2.0, 3.0});
  EXPECT_EQ(image.rgb(1, 0), Vec3d(1.0, 2.0, 3.0));
  EXPECT_EQ(image.at(1, 0, 3), 0.5F);  // set_rgb leaves the fourth channel
}

TEST(Srgb, HasTheStandardsValues) {
  EXPECT_EQ(srgb_encode(0.0), 0.0);
  EXPECT_EQ(srgb_decode(0.0), 0.0);
  // 1.055 - 0.055 and (1 + 0.055)/1.055 round once or twice each: 4 ulp, which EXPECT_DOUBLE_EQ grants.
  EXPECT_DOUBLE_EQ(srgb_encode(1.0), 1.0);
  EXPECT_DOUBLE_EQ(srgb_decode(1.0), 1.0);
  // The linear piece.
  EXPECT_DOUBLE_EQ(srgb_encode(0.001), 0.01292);
  EXPECT_DOUBLE_EQ(srgb_decode(0.01292), 0.001);
  // The curved piece: 0.5^(1/2.4) = exp(-0.28881132523331055) = 0.74915353843834..., times 1.055, minus
  // 0.055.
  EXPECT_NEAR(srgb_encode(0.5), 0.7353569830524495, 5 * std::numeric_limits<double>::epsilon());
}

TEST(Srgb, ClampsOutsideTheUnitRange) {
  EXPECT_EQ(srgb_encode(-1.0), srgb_encode(0.0));
  EXPECT_EQ(srgb_encode(2.0), srgb_encode(1.0));
  EXPECT_EQ(srgb_decode(-1.0), srgb_decode(0.0));
  EXPECT_EQ(srgb_decode(2.0), srgb_decode(1.0));
}

// Decoding rounds four times, pow included, so its relative error is below 4 eps (pow multiplies its
// argument's two roundings by 2.4: below 8 eps). Encoding has the slope d ln/d ln = 1/2.4 there, and adds as
// many roundings of its own on a value of at most 1.055: together below 16 eps of 1.
TEST(Srgb, EveryEightBitCodeSurvivesARoundTrip) {
  for (int code = 0; code <= 255; ++code) {
    const double encoded = code / 255.0;
    EXPECT_NEAR(srgb_encode(srgb_decode(encoded)), encoded, 16 * std::numeric_limits<double>::epsilon())
        << code;
  }
}

TEST(Luminance, HasRec709Weights) {
  EXPECT_DOUBLE_EQ(luminance({1, 0, 0}), 0.2126);
  EXPECT_DOUBLE_EQ(luminance({0, 1, 0}), 0.7152);
  EXPECT_DOUBLE_EQ(luminance({0, 0, 1}), 0.0722);
  EXPECT_DOUBLE_EQ(luminance({1, 1, 1}), 1.0);
}

}  // namespace
}  // namespace truescatter
