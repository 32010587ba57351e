#include "metrics/map_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "metrics/color_map.h"

namespace truescatter {
namespace {

// Pictures hold floats, so a colour comes back rounded once.
void expect_color(const Image& picture, int x, int y, const Vec3d& expected) {
  for (int c = 0; c < 3; ++c)
    EXPECT_EQ(picture.at(x, y, c), static_cast<float>(expected[c])) << x << " " << y << " " << c;
}

constexpr int kWidth = 160;
constexpr int kHeight = 8;

// The left half is skin, with an error of -1 in every channel, so in luminance too; 0 at (0, 0).
Image example_map() {
  Image map(kWidth, kHeight, 3, -1.0F);
  map.set_rgb(0, 0, Vec3d::Zero());
  return map;
}

Image left_half() {
  Image mask(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) mask.at(x, y, 0) = 1.0F;
  }
  return mask;
}

TEST(MapPicture, ColoursByLuminanceOverTheRange) {
  const Image magnitude = map_picture(example_map(), left_half(), MapKind::magnitude, 2.0, "ERROR");
  const Image with_sign = map_picture(example_map(), left_half(), MapKind::signed_error, 2.0, "ERROR");
  expect_color(magnitude, 0, 0, magnitude_color(0.0));
  expect_color(with_sign, 0, 0, signed_color(0.0));
  // luminance(-1, -1, -1) = -(0.2126 + 0.7152 + 0.0722), which may round beside -1: one ulp of a half, times
  // the colour map's slope (below 8 stops of at most 1), vanishes in a float's 6e-8.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(magnitude.at(5, 5, c), magnitude_color(0.5)[c], 6e-8);
    EXPECT_NEAR(with_sign.at(5, 5, c), signed_color(-0.5)[c], 6e-8);
  }
}

TEST(MapPicture, IsGreyOutsideTheMask) {
  const Image picture = map_picture(example_map(), left_half(), MapKind::magnitude, 2.0, "ERROR");
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) {
      ASSERT_EQ(picture.at(x, y, 0), picture.at(x, y, 1));
      ASSERT_EQ(picture.at(x, y, 1), picture.at(x, y, 2));
      ASSERT_EQ(picture.at(x, y, 0), picture.at(kWidth / 2, 0, 0));
    }
  }
  EXPECT_NE(picture.at(kWidth / 2, 0, 0), picture.at(0, 0, 0));
}

// How many pixels below the map have a given colour, to a float.
int count_below_map(const Image& picture, const Vec3d& color) {
  int count = 0;
  for (int y = kHeight; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      bool same = true;
      for (int c = 0; c < 3; ++c)
        same = same && std::abs(static_cast<double>(picture.at(x, y, c)) - color[c]) < 0.02;
      count += same ? 1 : 0;
    }
  }
  return count;
}

// The bar runs from one end of the range to the other. It is 140 pixels wide, so that its first and last
// pixels lie half a pixel, 1/280 of the range, inside the ends: by the map's slope of at most 8 stops of a
// colour step below 0.35 that is 0.01 (and twice that for the signed map, which has 4 + 4 stops).
TEST(MapPicture, CarriesABarBelow) {
  const Image magnitude = map_picture(example_map(), left_half(), MapKind::magnitude, 2.0, "ERROR");
  const Image with_sign = map_picture(example_map(), left_half(), MapKind::signed_error, 2.0, "ERROR");
  EXPECT_EQ(magnitude.width(), kWidth);
  EXPECT_GT(magnitude.height(), kHeight);
  EXPECT_EQ(magnitude.channels(), 3);
  EXPECT_GT(count_below_map(magnitude, magnitude_color(0.0)), 0);
  EXPECT_GT(count_below_map(magnitude, magnitude_color(1.0)), 0);
  EXPECT_EQ(count_below_map(magnitude, signed_color(-1.0)), 0);
  EXPECT_GT(count_below_map(with_sign, signed_color(-1.0)), 0);
  EXPECT_GT(count_below_map(with_sign, signed_color(1.0)), 0);
}

// color_bar says where: from edge to edge the map's colours, the background's grey around them.
TEST(MapPicture, TheBarLiesWhereColorBarSays) {
  const ColorBar bar = color_bar(kWidth, kHeight);
  const Image picture = map_picture(example_map(), left_half(), MapKind::signed_error, 2.0, "");
  ASSERT_GT(bar.width_px, kWidth / 2);
  ASSERT_GT(bar.height_px, 2);
  const Vec3d grey = picture.rgb(0, picture.height() - 1);
  for (int y = bar.top_px; y < bar.top_px + bar.height_px; ++y) {
    for (int x = 0; x < bar.width_px; ++x)
      expect_color(picture, bar.left_px + x, y, signed_color(2.0 * (x + 0.5) / bar.width_px - 1.0));
    EXPECT_EQ(picture.rgb(bar.left_px - 1, y), grey);
    EXPECT_EQ(picture.rgb(bar.left_px + bar.width_px, y), grey);
  }
  for (int x = 0; x < kWidth; ++x) EXPECT_EQ(picture.rgb(x, bar.top_px - 1), grey);
  for (int x = 0; x < kWidth; ++x) EXPECT_EQ(picture.rgb(x, bar.top_px + bar.height_px), grey);
  EXPECT_EQ(color_bar(1, 1).width_px, 0);
}

// The labels say the range: another range, another bar, though the colours stay.
TEST(MapPicture, TheBarSaysItsRangeAndTitle) {
  const auto bar = [](double range, const std::string& title) {
    const Image picture =
        map_picture(Image(kWidth, 1, 3), Image(kWidth, 1, 1), MapKind::magnitude, range, title);
    return std::vector<float>(picture.data().begin(), picture.data().end());
  };
  EXPECT_EQ(bar(2.0, "ERROR"), bar(2.0, "ERROR"));
  EXPECT_NE(bar(2.0, "ERROR"), bar(5.0, "ERROR"));
  EXPECT_NE(bar(2.0, "ERROR"), bar(2.0, "FLIP"));
}

// Narrower than its own labels, a picture is clipped, not overrun.
TEST(MapPicture, MayBeOnePixelWide) {
  const Image picture = map_picture(Image(1, 1, 3), Image(1, 1, 1, 1.0F), MapKind::magnitude, 1.0, "ERROR");
  EXPECT_EQ(picture.width(), 1);
}

TEST(DisplayPicture, ExposesEncodesAndClips) {
  Image rgb(2, 1, 3);
  rgb.set_rgb(0, 0, {0.25, 0.5, -1.0});
  rgb.set_rgb(1, 0, {1.0, 100.0, 0.0});
  const Image picture = display_picture(rgb, 2.0);
  expect_color(picture, 0, 0, {srgb_encode(0.5), srgb_encode(1.0), 0.0});
  expect_color(picture, 1, 0, {srgb_encode(1.0), srgb_encode(1.0), 0.0});
}

TEST(RoundRange, IsTheNextOfOneTwoFive) {
  EXPECT_DOUBLE_EQ(round_range(1.0), 1.0);
  EXPECT_DOUBLE_EQ(round_range(1.01), 2.0);
  EXPECT_DOUBLE_EQ(round_range(2.0), 2.0);
  EXPECT_DOUBLE_EQ(round_range(2.01), 5.0);
  EXPECT_DOUBLE_EQ(round_range(5.0), 5.0);
  EXPECT_DOUBLE_EQ(round_range(5.01), 10.0);
  EXPECT_DOUBLE_EQ(round_range(0.0301), 0.05);
  EXPECT_DOUBLE_EQ(round_range(123.0), 200.0);
  for (int decade = -12; decade <= 12; ++decade) {
    for (const double step : {1.0, 2.0, 5.0}) {
      const double value = step * std::pow(10.0, decade);
      ASSERT_DOUBLE_EQ(round_range(value), value);
    }
  }
}

}  // namespace
}  // namespace truescatter
