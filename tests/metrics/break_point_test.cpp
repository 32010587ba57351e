#include "metrics/break_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace truescatter {
namespace {

// From 1 % at 10 to 3 % at 20: 2 % halfway, at 15, or at sqrt(200) where the axis is logarithmic.
TEST(BreakPoint, LiesBetweenTheValuesAroundIt) {
  EXPECT_NEAR(break_point({{0.0, 10.0, 20.0, 30.0}, {0.005, 0.01, 0.03, 0.2}}, 0.02).value.value(), 15.0,
              1e-12);
  EXPECT_NEAR(break_point({{5.0, 10.0, 20.0}, {0.005, 0.01, 0.03}, true}, 0.02).value.value(),
              std::sqrt(200.0), 1e-12);
  // From 3 % at 20 to 20 % at 30: 10 % after 7 of 17 parts.
  EXPECT_NEAR(break_point({{0.0, 10.0, 20.0, 30.0}, {0.005, 0.01, 0.03, 0.2}}, 0.10).value.value(),
              20.0 + 70.0 / 17.0, 1e-12);
  // A difficulty that grows as the axis falls.
  EXPECT_NEAR(break_point({{8.0, 4.0, 2.0}, {0.0, 0.01, 0.05}}, 0.02).value.value(), 3.5, 1e-12);
}

TEST(BreakPoint, SaysWhyThereIsNone) {
  const BreakPoint never = break_point({{1.0, 2.0, 3.0}, {0.001, 0.019, 0.01}}, 0.02);
  EXPECT_FALSE(never.value);
  EXPECT_EQ(never.reason, "never: 1.9 % at most");
  const BreakPoint always = break_point({{1.0, 2.0}, {0.031, 0.2}}, 0.02);
  EXPECT_FALSE(always.value);
  EXPECT_EQ(always.reason, "above from the start: 3.1 % at the easy end");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(break_point({{1.0, 2.0}, {nan, nan}}, 0.02).reason, "nothing was measured");
}

// The first passing counts, whatever comes after; and what was not measured is stepped over: from 0 at 1 to
// 4 % at 3, 2 % at 2.
TEST(BreakPoint, TakesTheFirstPassingOfWhatWasMeasured) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NEAR(break_point({{1.0, 2.0, 3.0, 4.0, 5.0}, {0.0, nan, 0.04, 0.01, 0.3}}, 0.02).value.value(), 2.0,
              1e-12);
}

TEST(BreakPoint, KnowsWhetherACurveRises) {
  EXPECT_TRUE(only_rises({{1.0, 2.0, 3.0}, {0.1, 0.1, 0.2}}, 0.0));
  EXPECT_FALSE(only_rises({{1.0, 2.0, 3.0}, {0.1, 0.3, 0.2}}, 0.05));
  EXPECT_TRUE(only_rises({{1.0, 2.0, 3.0}, {0.1, 0.21, 0.2}}, 0.05));
}

}  // namespace
}  // namespace truescatter
