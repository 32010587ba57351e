#include "metrics/color_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/image.h"

namespace truescatter {
namespace {

// CIE lightness L* of an sRGB-encoded colour; 0.008856 is (6/29)^3, and 903.3 the slope below it.
double lightness(const Vec3d& encoded) {
  const double y = luminance({srgb_decode(encoded.x()), srgb_decode(encoded.y()), srgb_decode(encoded.z())});
  return y > 0.008856 ? 116.0 * std::cbrt(y) - 16.0 : 903.3 * y;
}

TEST(MagnitudeColor, RunsFromBlackToPaleYellow) {
  // The ends of matplotlib's inferno: (0.001462, 0.000466, 0.013866) and (0.988362, 0.998364, 0.644924), here
  // to three decimals.
  EXPECT_LT((magnitude_color(0.0) - Vec3d(0.001462, 0.000466, 0.013866)).cwiseAbs().maxCoeff(), 0.5e-3);
  EXPECT_LT((magnitude_color(1.0) - Vec3d(0.988362, 0.998364, 0.644924)).cwiseAbs().maxCoeff(), 0.5e-3);
  EXPECT_EQ(magnitude_color(2.0), magnitude_color(1.0));
  EXPECT_EQ(magnitude_color(-1.0), magnitude_color(0.0));
}

TEST(MagnitudeColor, GetsLighterWithEveryStep) {
  for (int i = 1; i <= 1024; ++i) {
    ASSERT_GT(lightness(magnitude_color(i / 1024.0)), lightness(magnitude_color((i - 1) / 1024.0))) << i;
  }
}

TEST(SignedColor, IsDarkAtZeroRedAboveAndBlueBelow) {
  EXPECT_EQ(signed_color(0.0), signed_color(-0.0));
  EXPECT_LT(lightness(signed_color(0.0)), 10.0);
  for (int i = 1; i <= 256; ++i) {
    const Vec3d bright = signed_color(i / 256.0) - signed_color(0.0);
    const Vec3d dark = signed_color(-i / 256.0) - signed_color(0.0);
    ASSERT_GT(bright.x(), bright.z()) << i;
    ASSERT_GT(dark.z(), dark.x()) << i;
    ASSERT_GT(lightness(signed_color(i / 256.0)), lightness(signed_color((i - 1) / 256.0))) << i;
  }
  EXPECT_EQ(signed_color(3.0), signed_color(1.0));
  EXPECT_EQ(signed_color(-3.0), signed_color(-1.0));
}

// Neither sign may look larger than the other. Two colours whose L* differs by 1 can just about be told apart
// side by side; here they never lie side by side.
TEST(SignedColor, BothSidesHaveTheSameLightness) {
  double largest = 0.0;
  for (int i = 0; i <= 1024; ++i) {
    largest = std::max(largest,
                       std::abs(lightness(signed_color(i / 1024.0)) - lightness(signed_color(-i / 1024.0))));
  }
  EXPECT_LT(largest, 1.0);
}

}  // namespace
}  // namespace truescatter
