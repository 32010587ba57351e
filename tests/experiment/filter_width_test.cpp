// What is left of a Gaussian's variance, where it has a closed form.
#include "experiment/filter_width.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "support/plane_frame.h"
#include "support/render.h"

namespace truescatter::test {
namespace {

constexpr double kStdDevMm = 1.3;  // not the unit of anything
constexpr double kRMaxMm = 4.5;

FilterWidth width_of(const std::string& name, const std::map<std::string, SettingValue>& given = {}) {
  const Method& method = find_method(name);
  // 12 texels of 512 to a standard deviation.
  FilterWidthProbe probe(Scene::context(), one_gaussian(kStdDevMm, kRMaxMm), 512.0 * kStdDevMm / 12.0);
  return probe.measure(method, Settings(method.name, method.settings, given));
}

// The irradiance's error for smooth weights: h^2 / 6 is subtracted, and what is left of it averages out over
// pixels that fall anywhere between vertices; it lies within [-h^2 / 6, h^2 / 12] = [-6e-4, 3e-4] for each.
constexpr double kLinearLight = 6e-4;

// The dense sums end at r_max to a pixel p: the rim's share of the variance is (r^3 / 2 s^3) exp(-r^2 / 2
// s^2) times the deviations that it moves by, r = 3.46 s, p = s / 8: 41.5 / 2 * 2.5e-3 / 16 = 3.3e-3 if all
// of the rim moved by half a pixel. It does not: the pixels inside a circle of 28 pixels' radius differ in
// number from its area by some sqrt(56) = 8 (Gauss's circle problem), of 176 along the rim, a twentieth:
// 2e-4; twice that with slopes.
constexpr double kRim = 4e-4;

TEST(FilterWidth, OfADenseFilterIsTheCutTruths) {
  const double share = cut_variance_share(kStdDevMm * kStdDevMm, kRMaxMm);
  EXPECT_NEAR(share, 0.98498, 1e-5);  // x = 5.99112, e^x = 399.86
  for (const std::string name : {"screen-integral", "cbf"}) {
    const auto sum = name == "cbf" ? std::map<std::string, SettingValue>()
                                   : std::map<std::string, SettingValue>{{"sum", std::string("normalised")}};
    const FilterWidth width = width_of(name, sum);
    EXPECT_NEAR(width.facing, share, kLinearLight + kRim) << name;
    EXPECT_NEAR(width.along_slope, share, kLinearLight + kRim) << name;
    EXPECT_NEAR(width.across_slope, share, kLinearLight + kRim) << name;
  }
}

// Taps in proportion across d' have the slope's depth on top of their distance: s^2 / (1 + sin^2 theta) up
// the slope, 0.571 s^2 at 60 degrees. Cut at r = 3.46 s there: 1 - 2 a r e^(-a^2 r^2 / 2) / sqrt(2 pi) at
// least, with a = sqrt(1.75) the cut is at 4.58 deviations: 1e-4.
TEST(FilterWidth, CountsTheSlopeTwiceWhereTapsLieInProportion) {
  const FilterWidth width = width_of("cbf", {{"spacing", std::string("proportional")}});
  EXPECT_NEAR(width.along_slope, 1.0 / 1.75, 1e-4 + kLinearLight + kRim);
  EXPECT_NEAR(width.facing, cut_variance_share(kStdDevMm * kStdDevMm, kRMaxMm), kLinearLight + kRim);
}

// 13 taps of equal probability: 0.907 of the variance at medians, 0.971 at centroids
// (tests/methods/taps_test.cpp derives both), to the rounding of taps, 0.009.
TEST(FilterWidth, OfThirteenTapsIsLess) {
  EXPECT_NEAR(width_of("pscbf").facing, 0.907, 0.009 + kLinearLight);
  EXPECT_NEAR(width_of("pscbf", {{"placement", std::string("centroid")}}).facing, 0.971,
              0.009 + kLinearLight);
}

// On a flat chart a dense level has its own variance to 1 %, and the seven taps 1.079 of it (tests/methods);
// drawing the irradiance into texels, at their centres, and reading a level bilinearly adds the variance of a
// texel's hat, at most a quarter of its square: 1.7e-3.
TEST(FilterWidth, OfTextureSpaceIsThatOfItsTaps) {
  const std::map<std::string, SettingValue> small = {{"texture_size", 512.0}};
  auto dense = small;
  dense["taps"] = std::string("dense");
  EXPECT_NEAR(width_of("texture-space", dense).facing, 1.0, 0.01 + 1.7e-3 + kLinearLight);
  const FilterWidth seven = width_of("texture-space", small);
  EXPECT_NEAR(seven.facing, 1.079, 0.01 + 1.7e-3 + kLinearLight);
  EXPECT_EQ(seven.along_slope, seven.facing);
}

TEST(FilterWidth, OfNoScatteringIsNone) { EXPECT_NEAR(width_of("none").facing, 0.0, kLinearLight); }

}  // namespace
}  // namespace truescatter::test
