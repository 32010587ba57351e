#include "metrics/halo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace truescatter {
namespace {

// One row of skin: pixel i lies at a given distance from a contour of a given class. s = 1 mm throughout, and
// a pixel is 0.1 mm, so a bin is max(0.1/4, 1/8) = 1/8 mm and 6 s are 48 bins. Every error is a sum of powers
// of two, so sums and quotients by hand are exact.
struct Line {
  ContourMap contours;
  Image truth;
  Image test;
  Image mask;

  explicit Line(int pixels) : truth(pixels, 1, 3, 1.0F), test(pixels, 1, 3, 1.0F), mask(pixels, 1, 1, 1.0F) {
    contours.width = pixels;
    contours.height = 1;
    contours.contour.assign(static_cast<std::size_t>(pixels), ContourClass::none);
    contours.mask_edge.assign(static_cast<std::size_t>(pixels), 0);
    contours.nearest.assign(static_cast<std::size_t>(pixels), ContourClass::none);
    contours.delta_mm.assign(static_cast<std::size_t>(pixels), kInfinity);
  }
  void set(int x, double delta_mm, ContourClass nearest, double truth_value, double error) {
    contours.delta_mm[static_cast<std::size_t>(x)] = delta_mm;
    contours.nearest[static_cast<std::size_t>(x)] = nearest;
    truth.set_rgb(x, 0, Vec3d::Constant(truth_value));
    test.set_rgb(x, 0, Vec3d::Constant(truth_value + error));
  }
  Halo halo(HaloSide side = HaloSide::all) const {
    return measure_halo(test, truth, mask, contours, 1.0, 0.1, Quantity::red, side);
  }
};

// One pixel in the middle of each of 64 bins (8 mm), truth 1, with an error by bin.
Line one_pixel_per_bin(const std::function<double(int)>& error) {
  Line line(64);
  for (int i = 0; i < 64; ++i) line.set(i, (i + 0.5) / 8.0, ContourClass::outer, 1.0, error(i));
  return line;
}

double example_error(int bin) {
  if (bin == 0) return -0.5;
  if (bin < 8) return -0.25;
  if (bin == 8) return 1.0 / 32.0;                     // 3 %: the last above 1 %
  if (bin < 48) return 1.0 / 256.0;                    // 0.4 %
  return bin % 2 == 0 ? 1.0 / 1024.0 : -1.0 / 1024.0;  // beyond 6 s
}

// Peak 1/2. The last bin above 1 % is bin 8, which ends at 9/8 mm. Within 3 s lie bins 0 to 23:
// energy = (1/2 + 7/4 + 1/32 + 15/256)/24, and with the RMSE beyond 6 s of 1/1024,
// contrast = 1024 sqrt((1/4 + 7/16 + 1/1024 + 15/65536)/24).
TEST(Halo, OfAProfileByHand) {
  const Halo halo = one_pixel_per_bin(example_error).halo();
  EXPECT_EQ(halo.profile.bin_mm, 0.125);
  ASSERT_EQ(halo.profile.relative_error.size(), 48U);
  for (int i = 0; i < 48; ++i) {
    EXPECT_EQ(halo.profile.relative_error[static_cast<std::size_t>(i)], example_error(i)) << i;
    EXPECT_EQ(halo.profile.pixels[static_cast<std::size_t>(i)], 1U);
  }
  EXPECT_EQ(halo.peak, 0.5);
  EXPECT_EQ(halo.width_mm, 1.125);
  EXPECT_EQ(halo.pixels, 24U);
  EXPECT_DOUBLE_EQ(halo.energy, (0.5 + 1.75 + 1.0 / 32.0 + 15.0 / 256.0) / 24.0);
  EXPECT_DOUBLE_EQ(halo.contrast,
                   1024.0 * std::sqrt((0.25 + 7.0 / 16.0 + 1.0 / 1024.0 + 15.0 / 65536.0) / 24.0));
}

// Truth 1 and 3, errors +1/4 and -3/4 in one bin: sum(error)/sum(truth) = -1/8, not the mean of +1/4 and
// -1/4. Energy takes magnitudes: (1/4 + 3/4)/4 = 1/4.
TEST(Halo, ABinDividesSumsAndEnergyTakesMagnitudes) {
  Line line(2);
  line.set(0, 0.05, ContourClass::outer, 1.0, 0.25);
  line.set(1, 0.06, ContourClass::outer, 3.0, -0.75);
  const Halo halo = line.halo();
  EXPECT_EQ(halo.profile.relative_error[0], -0.125);
  EXPECT_EQ(halo.profile.pixels[0], 2U);
  EXPECT_EQ(halo.peak, 0.125);
  EXPECT_EQ(halo.energy, 0.25);
  EXPECT_TRUE(std::isnan(halo.contrast));  // no pixel lies beyond 6 s
  EXPECT_TRUE(std::isnan(halo.profile.relative_error[1]));
}

TEST(Halo, HasNoWidthWithoutAnError) {
  const Halo halo = one_pixel_per_bin([](int) { return 0.0; }).halo();
  EXPECT_EQ(halo.peak, 0.0);
  EXPECT_EQ(halo.width_mm, 0.0);
  EXPECT_EQ(halo.energy, 0.0);
  EXPECT_TRUE(std::isnan(halo.contrast));  // 0 / 0
}

// A disc of skin of 15 mm, 0.1 mm a pixel, before nothing; too bright by 1/5 within 4 mm of its edge, by
// 1/256 beyond 6 s = 9 mm. Its height is that of every bin but the one that the step cuts. Its width is the
// end of the bin of 3/16 mm that holds the farthest pixel in error, whose delta is up to a pixel's diagonal,
// 0.14 mm, less than its distance from the edge: 4 - 0.14 to 4 + 0.19 mm, 4.7 %. Energy weighs rings t from
// the edge by (R - t) dt: (15 * 4 - 4^2 / 2) / (15 * 4.5 - 4.5^2 / 2) / 5 within 3 s, of which half a pixel
// is 1 %.
TEST(Halo, OfASyntheticStepComesBack) {
  constexpr int kPixels = 320;
  constexpr double kRadius_mm = 15.0;
  constexpr double kStepFocal_px = 5000.0;
  constexpr float kDepth_mm = 500.0F;
  Image mask(kPixels, kPixels, 1);
  Image position(kPixels, kPixels, 3);
  Image normal(kPixels, kPixels, 3);
  Image truth(kPixels, kPixels, 3);
  Image test(kPixels, kPixels, 3);
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      const double edge_mm = kRadius_mm - 0.1 * std::hypot(x + 0.5 - kPixels / 2.0, y + 0.5 - kPixels / 2.0);
      if (edge_mm < 0.0) continue;
      mask.at(x, y, 0) = 1.0F;
      position.at(x, y, 2) = -kDepth_mm;
      normal.set_rgb(x, y, Vec3d::UnitZ());
      truth.set_rgb(x, y, Vec3d::Constant(1.0));
      const double error = edge_mm < 4.0 ? 0.2 : edge_mm > 9.0 ? 1.0 / 256.0 : 0.0;
      test.set_rgb(x, y, Vec3d::Constant(1.0 + error));
    }
  }
  const ContourMap contours = find_contours({mask, position, normal, kStepFocal_px});
  const Halo halo = measure_halo(test, truth, mask, contours, 1.5, 0.1, Quantity::luminance, HaloSide::outer);
  const double share = (15.0 * 4.0 - 8.0) / (15.0 * 4.5 - 0.5 * 4.5 * 4.5);
  EXPECT_NEAR(halo.peak, 0.2, 0.05 * 0.2);
  EXPECT_NEAR(halo.width_mm, 4.0, 0.05 * 4.0);
  EXPECT_NEAR(halo.energy, 0.2 * share, 0.05 * 0.2 * share);
  EXPECT_NEAR(halo.contrast, 0.2 * std::sqrt(share) * 256.0, 0.05 * 0.2 * std::sqrt(share) * 256.0);
}

// 1/128 = 0.8 % and 1/64 = 1.6 % lie on either side of the 1 % rule.
TEST(Halo, WidthEndsWhereEveryBinIsWithinOnePercent) {
  EXPECT_EQ(one_pixel_per_bin([](int) { return 1.0 / 128.0; }).halo().width_mm, 0.0);
  EXPECT_EQ(one_pixel_per_bin([](int i) { return i == 20 ? 1.0 / 64.0 : 0.0; }).halo().width_mm, 21.0 / 8.0);
  EXPECT_EQ(one_pixel_per_bin([](int i) { return i == 46 ? -1.0 / 64.0 : 0.0; }).halo().width_mm, 47.0 / 8.0);
  // Still above 1 % at 6 s: there is no such delta.
  EXPECT_TRUE(
      std::isnan(one_pixel_per_bin([](int i) { return i == 47 ? 1.0 / 64.0 : 0.0; }).halo().width_mm));
  // What lies beyond 6 s does not count.
  EXPECT_EQ(one_pixel_per_bin([](int i) { return i >= 48 ? 0.5 : 0.0; }).halo().width_mm, 0.0);
}

TEST(Halo, CountsEachSideApart) {
  Line line(3);
  line.set(0, 0.0, ContourClass::outer, 1.0, 0.5);
  line.set(1, 0.0, ContourClass::inner_near, 1.0, 0.25);
  line.set(2, 0.0, ContourClass::inner_far, 1.0, -0.125);
  EXPECT_EQ(line.halo(HaloSide::outer).energy, 0.5);
  EXPECT_EQ(line.halo(HaloSide::inner_near).energy, 0.25);
  EXPECT_EQ(line.halo(HaloSide::inner_far).energy, 0.125);
  EXPECT_EQ(line.halo(HaloSide::inner_far).profile.relative_error[0], -0.125);
  EXPECT_EQ(line.halo(HaloSide::all).energy, 0.875 / 3.0);
  EXPECT_EQ(line.halo(HaloSide::outer).pixels, 1U);
}

TEST(Halo, LeavesOutWhatTheMaskLeavesOut) {
  Line line(2);
  line.set(0, 0.0, ContourClass::outer, 1.0, 0.5);
  line.set(1, 0.0, ContourClass::outer, 1.0, 100.0);
  line.mask.at(1, 0, 0) = 0.0F;
  EXPECT_EQ(line.halo().energy, 0.5);
  EXPECT_EQ(line.halo().pixels, 1U);
}

void expect_no_halo(const Halo& halo) {
  EXPECT_TRUE(std::isnan(halo.peak));
  EXPECT_TRUE(std::isnan(halo.width_mm));
  EXPECT_TRUE(std::isnan(halo.energy));
  EXPECT_TRUE(std::isnan(halo.contrast));
}

TEST(Halo, IsNotANumberWithoutASilhouette) {
  Line line(4);
  for (int i = 0; i < 4; ++i) line.set(i, kInfinity, ContourClass::none, 1.0, 0.5);
  expect_no_halo(line.halo());
  EXPECT_EQ(line.halo().pixels, 0U);
  // There is one, but of another kind.
  line.set(0, 0.0, ContourClass::outer, 1.0, 0.5);
  expect_no_halo(line.halo(HaloSide::inner_near));
}

TEST(Halo, IsNotANumberWhereNoLightIs) {
  Line line(1);
  line.set(0, 0.0, ContourClass::outer, 0.0, 0.5);
  expect_no_halo(line.halo());
}

// In black, 1e-15 of light against 1e-4 would be a halo of 1e11: it is none. With truth 1 in the other 63
// bins the RMS is 1 but for 1 %, so a bin is dark below 1e-3.
TEST(Halo, ABinCloseToBlackHasNoRelativeError) {
  Line line = one_pixel_per_bin([](int) { return 0.0; });
  line.set(3, 3.5 / 8.0, ContourClass::outer, 1e-15, 1e-4);
  line.set(4, 4.5 / 8.0, ContourClass::outer, 1.0 / 512.0, 1.0 / 1024.0);
  const Halo halo = line.halo();
  EXPECT_TRUE(std::isnan(halo.profile.relative_error[3]));
  EXPECT_EQ(halo.profile.relative_error[4], 0.5);
  EXPECT_EQ(halo.peak, 0.5);
}

// A quarter of a pixel where that is wider than s/8; and 6 s in bins of s/8 are 48 for every s, although
// 6 s / (s/8) rounds to a little more than 48 for some.
TEST(Halo, BinsAreAQuarterPixelOrAnEighthOfS) {
  const Line line = one_pixel_per_bin(example_error);
  const auto profile = [&](double s, double mm_per_px) {
    return measure_halo(line.test, line.truth, line.mask, line.contours, s, mm_per_px, Quantity::red,
                        HaloSide::all)
        .profile;
  };
  EXPECT_EQ(profile(1.0, 2.0).bin_mm, 0.5);
  EXPECT_EQ(profile(1.0, 2.0).relative_error.size(), 12U);
  EXPECT_EQ(profile(1.0, 0.4).bin_mm, 0.125);
  bool one_rounds_up = false;
  for (int i = 1; i <= 500; ++i) {
    const double s = 0.01 * i;
    one_rounds_up = one_rounds_up || 6.0 * s / (s / 8.0) > 48.0;
    ASSERT_EQ(profile(s, 1e-6).relative_error.size(), 48U) << s;
  }
  EXPECT_TRUE(one_rounds_up);  // else the loop has shown nothing
}

}  // namespace
}  // namespace truescatter
