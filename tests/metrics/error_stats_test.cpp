#include "metrics/error_stats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace truescatter {
namespace {

// Images of one row; every value below is exact in binary.
Image row(const std::vector<Vec3d>& pixels) {
  Image image(static_cast<int>(pixels.size()), 1, 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) image.set_rgb(static_cast<int>(i), 0, pixels[i]);
  return image;
}

Image all_inside(const Image& image) { return {image.width(), image.height(), 1, 1.0F}; }

// Red: truth 1 2 3 4, error +1/2 -1/4 0 +1. The fifth pixel is wildly wrong and outside the mask.
//   bias      (1/2 - 1/4 + 0 + 1)/4 = 5/16
//   mae       (1/2 + 1/4 + 0 + 1)/4 = 7/16
//   rmse      sqrt((1/4 + 1/16 + 0 + 1)/4) = sqrt(21/64)
//   rel_rmse  sqrt((21/16) / (1 + 4 + 9 + 16)) = sqrt(21/480)
//   quantiles of 0 1/4 1/2 1, nearest rank: p50 is rank ceil(2) = 2, p95 ceil(3.8) = 4, p99 ceil(3.96) = 4
TEST(ErrorStats, OfFourPixelsByHand) {
  const Image truth = row({{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {1, 0, 0}});
  const Image test = row({{1.5, 0, 0}, {1.75, 0, 0}, {3, 0, 0}, {5, 0, 0}, {1000, 0, 0}});
  Image mask = all_inside(truth);
  mask.at(4, 0, 0) = 0.0F;
  const ErrorStats stats = error_stats(test, truth, mask, Quantity::red);
  EXPECT_EQ(stats.pixels, 4U);
  EXPECT_EQ(stats.bias, 5.0 / 16.0);
  EXPECT_EQ(stats.mae, 7.0 / 16.0);
  EXPECT_DOUBLE_EQ(stats.rmse, std::sqrt(21.0 / 64.0));
  EXPECT_DOUBLE_EQ(stats.rel_rmse, std::sqrt(21.0 / 480.0));
  EXPECT_EQ(stats.p50, 0.25);
  EXPECT_EQ(stats.p95, 1.0);
  EXPECT_EQ(stats.p99, 1.0);
  EXPECT_EQ(stats.max, 1.0);
}

// A ramp 1 ... 8 (in 1/8) a quarter too bright: e = truth/4, so every quantile is a quarter of the truth's,
// of ranks 4 and 8, bias and MAE of its mean 36/64, and the relative RMSE is 1/4 whatever the truth.
TEST(ErrorStats, OfAScaledPictureByHand) {
  std::vector<Vec3d> truth;
  std::vector<Vec3d> test;
  for (int i = 1; i <= 8; ++i) {
    truth.push_back(Vec3d::Constant(i / 8.0));
    test.push_back(1.25 * truth.back());
  }
  const ErrorStats stats = error_stats(row(test), row(truth), all_inside(row(truth)), Quantity::green);
  EXPECT_EQ(stats.bias, 9.0 / 64.0);
  EXPECT_EQ(stats.mae, 9.0 / 64.0);
  EXPECT_DOUBLE_EQ(stats.rmse, 0.25 * std::sqrt(204.0 / 64.0 / 8.0));  // 1 + 4 + ... + 64 = 204
  EXPECT_DOUBLE_EQ(stats.rel_rmse, 0.25);
  EXPECT_EQ(stats.p50, 1.0 / 8.0);
  EXPECT_EQ(stats.p95, 1.0 / 4.0);
  EXPECT_EQ(stats.p99, 1.0 / 4.0);
  EXPECT_EQ(stats.max, 1.0 / 4.0);
}

// The same ramp shifted by a pixel, the last value repeated: seven pixels too bright by 1/8 and one right.
TEST(ErrorStats, OfAShiftedPictureByHand) {
  std::vector<Vec3d> truth;
  std::vector<Vec3d> test;
  for (int i = 1; i <= 8; ++i) {
    truth.push_back(Vec3d::Constant(i / 8.0));
    test.push_back(Vec3d::Constant(std::min(i + 1, 8) / 8.0));
  }
  const ErrorStats stats = error_stats(row(test), row(truth), all_inside(row(truth)), Quantity::green);
  EXPECT_EQ(stats.bias, 7.0 / 64.0);
  EXPECT_EQ(stats.mae, 7.0 / 64.0);
  EXPECT_DOUBLE_EQ(stats.rmse, std::sqrt(7.0 / 8.0) / 8.0);
  EXPECT_DOUBLE_EQ(stats.rel_rmse, std::sqrt(7.0 / 204.0));
  for (const double v : {stats.p50, stats.p95, stats.p99, stats.max}) EXPECT_EQ(v, 1.0 / 8.0);
}

// A constant too dark by 1/4 where the truth is 1/2: every magnitude is 1/4, and half of the truth.
TEST(ErrorStats, OfAConstantOffsetByHand) {
  const Image truth(3, 2, 3, 0.5F);
  const ErrorStats stats = error_stats(Image(3, 2, 3, 0.25F), truth, all_inside(truth), Quantity::blue);
  EXPECT_EQ(stats.bias, -0.25);
  for (const double v : {stats.mae, stats.rmse, stats.p50, stats.p95, stats.p99, stats.max})
    EXPECT_EQ(v, 0.25);
  EXPECT_EQ(stats.rel_rmse, 0.5);
}

// |e| = 1/128 ... 100/128 in shuffled order and with alternating signs: rank q n of 100 is q n exactly.
TEST(ErrorStats, QuantilesAreNearestRanksOfMagnitudes) {
  std::vector<Vec3d> errors;
  for (int i = 0; i < 100; ++i) {
    const double magnitude = ((i * 37) % 100 + 1) / 128.0;  // 37 and 100 are coprime: each occurs once
    errors.push_back(Vec3d::Constant(i % 2 == 0 ? magnitude : -magnitude));
  }
  const Image test = row(errors);
  const Image truth(100, 1, 3, 0.0F);
  const ErrorStats stats = error_stats(test, truth, all_inside(truth), Quantity::blue);
  EXPECT_EQ(stats.p50, 50.0 / 128.0);
  EXPECT_EQ(stats.p95, 95.0 / 128.0);
  EXPECT_EQ(stats.p99, 99.0 / 128.0);
  EXPECT_EQ(stats.max, 100.0 / 128.0);
}

TEST(ErrorStats, OfOnePixelIsThatPixel) {
  const Image truth = row({{2, 2, 2}});
  const ErrorStats stats = error_stats(row({{1, 1, 1}}), truth, all_inside(truth), Quantity::green);
  EXPECT_EQ(stats.bias, -1.0);
  EXPECT_EQ(stats.p50, 1.0);
  EXPECT_EQ(stats.p99, 1.0);
  EXPECT_EQ(stats.rel_rmse, 0.5);
}

// Each channel alone is wrong by 1: the luminance error is that channel's weight of Rec. 709. A channel's
// error of +1 in red and -1 in green does not cancel.
TEST(ErrorStats, LuminanceIsTakenBeforeTheMagnitude) {
  const Image truth = row({{1, 1, 1}});
  const auto bias_of = [&](const Vec3d& test) {
    return error_stats(row({test}), truth, all_inside(truth), Quantity::luminance).bias;
  };
  // A difference of two sums near 1, each rounded three times.
  constexpr double kRounding = 6 * 2.3e-16;
  EXPECT_NEAR(bias_of({2, 1, 1}), 0.2126, kRounding);
  EXPECT_NEAR(bias_of({1, 2, 1}), 0.7152, kRounding);
  EXPECT_NEAR(bias_of({1, 1, 2}), 0.0722, kRounding);
  EXPECT_NEAR(bias_of({2, 0, 1}), 0.2126 - 0.7152, kRounding);
}

TEST(ErrorStats, ReadsTheChannelThatItIsAskedFor) {
  const Image truth = row({{0, 0, 0}});
  const Image test = row({{1, 2, 4}});
  EXPECT_EQ(error_stats(test, truth, all_inside(truth), Quantity::red).bias, 1.0);
  EXPECT_EQ(error_stats(test, truth, all_inside(truth), Quantity::green).bias, 2.0);
  EXPECT_EQ(error_stats(test, truth, all_inside(truth), Quantity::blue).bias, 4.0);
  EXPECT_EQ(name_of(Quantity::luminance), "luminance");
  EXPECT_EQ(name_of(Quantity::red), "r");
  EXPECT_EQ(name_of(Quantity::green), "g");
  EXPECT_EQ(name_of(Quantity::blue), "b");
}

TEST(ErrorStats, AreNotANumberWithoutAPixel) {
  const Image image = row({{1, 1, 1}});
  const ErrorStats stats = error_stats(image, image, Image(1, 1, 1, 0.0F), Quantity::luminance);
  EXPECT_EQ(stats.pixels, 0U);
  for (const double v :
       {stats.bias, stats.mae, stats.rmse, stats.rel_rmse, stats.p50, stats.p95, stats.p99, stats.max}) {
    EXPECT_TRUE(std::isnan(v));
  }
}

// Relative to nothing: no number; the absolute ones stay.
TEST(ErrorStats, RelativeErrorIsNotANumberWhereTheTruthIsDark) {
  const Image truth = row({{0, 0, 0}, {0, 0, 0}});
  const ErrorStats stats = error_stats(row({{3, 3, 3}, {4, 4, 4}}), truth, all_inside(truth), Quantity::red);
  EXPECT_TRUE(std::isnan(stats.rel_rmse));
  EXPECT_DOUBLE_EQ(stats.rmse, std::sqrt(12.5));  // (9 + 16)/2
}

TEST(SignedError, IsZeroOutsideTheMask) {
  const Image truth = row({{1, 2, 3}, {1, 2, 3}});
  const Image test = row({{2, 2, 1}, {9, 9, 9}});
  Image mask = all_inside(truth);
  mask.at(1, 0, 0) = 0.0F;
  const Image error = signed_error(test, truth, mask);
  EXPECT_EQ(error.rgb(0, 0), Vec3d(1, 0, -2));
  EXPECT_EQ(error.rgb(1, 0), Vec3d(0, 0, 0));
}

}  // namespace
}  // namespace truescatter
