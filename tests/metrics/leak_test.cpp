#include "metrics/leak.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace truescatter {
namespace {

// Grey 1/4, 1/8, -1/8 and 5, of which the last is lit: 1/2 in all over three pixels, at most 1/4. Grey has
// its own value for luminance, to a rounding.
TEST(Leak, SumsMagnitudesOfTheDarkPixels) {
  Image exitance(4, 1, 3);
  const std::array<double, 4> greys = {0.25, 0.125, -0.125, 5.0};
  for (int x = 0; x < 4; ++x) exitance.set_rgb(x, 0, Vec3d::Constant(greys[static_cast<std::size_t>(x)]));
  Image dark(4, 1, 1, 1.0F);
  dark.at(3, 0, 0) = 0.0F;
  const LitAlone result = measure_dark(2, exitance, dark);
  EXPECT_EQ(result.component, 2);
  EXPECT_EQ(result.pixels, 3U);
  EXPECT_DOUBLE_EQ(result.dark_light, 0.5);
  EXPECT_DOUBLE_EQ(result.largest_dark, 0.25);
}

// (1 + 3) of (10 + 30) crosses; the largest is 0.5 where the largest irradiance is 2.
TEST(Leak, DividesByTheLightOfAllLitSurfaces) {
  const Leak leak = total_leak({{0, 5, 1.0, 0.25, 10.0}, {1, 5, 3.0, 0.5, 30.0}}, 2.0);
  EXPECT_EQ(leak.energy, 0.1);
  EXPECT_EQ(leak.peak, 0.25);
}

TEST(Leak, IsNotANumberWithoutSurfacesOrLight) {
  EXPECT_TRUE(std::isnan(total_leak({}, 1.0).energy));
  EXPECT_TRUE(std::isnan(total_leak({}, 1.0).peak));
  EXPECT_TRUE(std::isnan(total_leak({{0, 5, 0.0, 0.0, 0.0}}, 1.0).energy));
}

}  // namespace
}  // namespace truescatter
