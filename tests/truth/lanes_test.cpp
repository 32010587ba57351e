#include "truth/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace truescatter {
namespace {

// Relative error: of the series as lanes.h derives it, and of rounding: half a unit in the last place for the
// argument's reduction (|f| <= 1/2), some two for the series' last steps.
template <typename Scalar>
void expect_powers_of_two(double series_error) {
  const double allowed = series_error + 3.0 * static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  double worst = 0.0;
  for (int i = 0; i < 80000; i += static_cast<int>(kLanes)) {
    Lanes<Scalar> x{};
    Lanes<Scalar> at{};
    for (std::size_t k = 0; k < kLanes; ++k)
      at[k] = x[k] = static_cast<Scalar>(-1e-3 * (i + static_cast<int>(k)));
    replace_by_exp2<Scalar>(x);
    for (std::size_t k = 0; k < kLanes; ++k) {
      const double exact = std::exp2(static_cast<double>(at[k]));
      worst = std::max(worst, std::abs(static_cast<double>(x[k]) / exact - 1.0));
    }
  }
  EXPECT_LE(worst, allowed);
}

TEST(Lanes, PowersOfTwoInSinglePrecision) { expect_powers_of_two<float>(1.3e-7); }
TEST(Lanes, PowersOfTwoInDoublePrecision) { expect_powers_of_two<double>(1.7e-16); }

TEST(Lanes, FarPowersStayNormal) {
  Lanes<float> x = Lanes<float>{} - 1e9F;
  replace_by_exp2<float>(x);
  for (std::size_t k = 0; k < kLanes; ++k) EXPECT_FLOAT_EQ(x[k], std::exp2(-80.0F));
}

}  // namespace
}  // namespace truescatter
