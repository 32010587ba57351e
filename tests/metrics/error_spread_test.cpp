#include "metrics/error_spread.h"

#include <gtest/gtest.h>

#include <cmath>

namespace truescatter {
namespace {

// Point 0 has the errors 1, 2, 3, 6: mean 3, squares 4 + 1 + 0 + 9 = 14, spread sqrt(14 / 4). Point 1 has -1
// and 1: spread 1. Point 2 is seen once and point 3 never: neither has a spread.
TEST(ErrorSpread, IsTheStandardDeviationOverTheViewsOfAPoint) {
  ErrorSpread spread(4);
  for (const double error : {1.0, 2.0, 3.0, 6.0}) spread.add(0, error);
  for (const double error : {-1.0, 1.0}) spread.add(1, error);
  spread.add(2, 100.0);
  const SpreadStats stats = spread.stats();
  EXPECT_EQ(stats.points, 2U);
  EXPECT_NEAR(stats.rms, std::sqrt((3.5 + 1.0) / 2.0), 1e-15);
  EXPECT_NEAR(stats.max, std::sqrt(3.5), 1e-15);
  EXPECT_EQ(stats.p95, stats.max);  // of two: rank ceil(1.9) = 2
}

// An error that never changes is no spread, however large; not even by rounding.
TEST(ErrorSpread, IsExactlyZeroOfErrorsThatDoNotChange) {
  ErrorSpread spread(3);
  for (int view = 0; view < 7; ++view) {
    spread.add(0, 0.0);
    spread.add(1, 1.0 / 3.0);
    spread.add(2, -1e5 / 7.0);
  }
  const SpreadStats stats = spread.stats();
  EXPECT_EQ(stats.points, 3U);
  EXPECT_EQ(stats.rms, 0.0);
  EXPECT_EQ(stats.max, 0.0);
}

// Spreads 1..100 once each: p95 is the 95th, the RMS sqrt(sum k^2 / 100) = sqrt(101 * 201 / 6).
TEST(ErrorSpread, TakesQuantilesByNearestRank) {
  ErrorSpread spread(100);
  for (std::size_t i = 0; i < 100; ++i) {
    spread.add(i, 5.0 + static_cast<double>(i + 1));
    spread.add(i, 5.0 - static_cast<double>(i + 1));
  }
  const SpreadStats stats = spread.stats();
  EXPECT_NEAR(stats.p95, 95.0, 1e-12);
  EXPECT_NEAR(stats.max, 100.0, 1e-12);
  EXPECT_NEAR(stats.rms, std::sqrt(101.0 * 201.0 / 6.0), 1e-12);
}

TEST(ErrorSpread, IsNoNumberWhereNoPointIsSeenTwice) {
  ErrorSpread spread(2);
  spread.add(0, 1.0);
  EXPECT_EQ(spread.stats().points, 0U);
  EXPECT_TRUE(std::isnan(spread.stats().rms));
  EXPECT_TRUE(std::isnan(spread.stats().max));
}

}  // namespace
}  // namespace truescatter
