#include "composite/beckmann.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace truescatter {
namespace {

constexpr double kSmallest = std::numeric_limits<float>::min();

// Roughnesses and N.H between a table's values, far more of them than it has; `visit(n_h, m)`.
template <typename Visit>
void sweep(double least_n_h, double least_m, const Visit& visit) {
  for (int i = 0; i <= 700; ++i) {
    const double m = least_m * std::pow(1.0 / least_m, i / 700.0);
    for (int j = 0; j <= 5000; ++j) visit(least_n_h + (1.0 - least_n_h) * j / 5000.0, m);
  }
}

TEST(Beckmann, IntegratesToOneOverProjectedSolidAngle) {
  // Over cos(alpha) = c: int D c 2 pi dc, by the midpoint rule; its error is far below 1e-6 at 2e5 steps, for
  // D varies over m^2 / 2 = 0.005 at least.
  for (const double m : {0.1, 0.3, 0.7, 1.0}) {
    constexpr int kSteps = 200000;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double c = (i + 0.5) / kSteps;
      sum += beckmann(c, m) * c;
    }
    EXPECT_NEAR(2.0 * kPi * sum / kSteps, 1.0, 1e-6) << m;
  }
}

TEST(Beckmann, HasNoFacetsThatLookIntoTheSurface) {
  EXPECT_EQ(beckmann(0.0, 0.3), 0.0);
  EXPECT_EQ(beckmann(-0.5, 0.3), 0.0);
  EXPECT_EQ(beckmann(1e-200, 0.3), 0.0);
}

// The bound is derived at BeckmannTable: less than 0.3 %; single floats of ln D, down to -87, add
// 4e-6.
TEST(BeckmannTable, IsWithinAThirdOfAPercentOfTheClosedForm) {
  const BeckmannTable table = make_beckmann_table(BeckmannEncoding::logarithm);
  double worst = 0.0;
  sweep(0.05, 0.1, [&](double n_h, double m) {
    const double closed = beckmann(n_h, m);
    const double read = read_beckmann(table, n_h, m);
    if (closed < kSmallest) {
      // What a single float does not hold is dark in a shader.
      ASSERT_LT(read, 1.01 * kSmallest) << n_h << " " << m;
    } else {
      worst = std::max(worst, std::abs(read / closed - 1.0));
    }
  });
  EXPECT_LT(worst, 0.003);
  EXPECT_GT(worst, 1e-6);  // or nothing was compared
}

// 0.5 D^0.1 is steep where D is small: to 1 % of the largest D at each roughness, but not of D itself.
TEST(BeckmannTable, OfTheTenthRootIsGoodWhereTheLobeIsBright) {
  const BeckmannTable table = make_beckmann_table(BeckmannEncoding::power);
  double worst_of_peak = 0.0;
  double worst_of_itself = 0.0;
  sweep(0.05, 0.1, [&](double n_h, double m) {
    const double closed = beckmann(n_h, m);
    const double error = std::abs(read_beckmann(table, n_h, m) - closed);
    worst_of_peak = std::max(worst_of_peak, error / beckmann(1.0, m));
    if (closed > kSmallest) worst_of_itself = std::max(worst_of_itself, error / closed);
  });
  EXPECT_LT(worst_of_peak, 0.01);
  EXPECT_GT(worst_of_itself, 0.01);
}

}  // namespace
}  // namespace truescatter
