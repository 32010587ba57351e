// The settings of pscbf and pscbf-mip, on a plane that faces the camera.
#include <gtest/gtest.h>

#include <cmath>

#include "methods/pscbf/taps.h"
#include "support/plane_frame.h"

namespace truescatter {
namespace {

using test::PlaneFrame;
using test::PlaneView;

constexpr double kWavelengthMm = 10.0;
constexpr double kWaveNumber = 2.0 * kPi / kWavelengthMm;

double wave(double u) { return 0.5 + 0.5 * std::cos(kWaveNumber * u); }

const PlaneView kView{.mm_per_px = 0.1, .px = 128};

Image exitance(const PlaneView& view, const std::string& method, const Profile& profile,
               const std::map<std::string, SettingValue>& settings = {}) {
  return PlaneFrame(view, wave).run(find_method(method), profile, settings);
}

double largest_difference(const Image& a, int channel_a, const Image& b, int channel_b) {
  double largest = 0.0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x)
      largest =
          std::max(largest, std::abs(static_cast<double>(a.at(x, y, channel_a)) - b.at(x, y, channel_b)));
  }
  return largest;
}

// How much of the light's wave is left in the middle row, away from the picture's ends: of 1/2 cos(k u), by
// projection onto it and its sine. `margin` leaves a whole number of wavelengths of the 100 pixels that make
// one.
double transfer(const PlaneView& view, const Image& result) {
  const int first = (view.px - 100) / 2;
  double sum = 0.0;
  for (int x = first; x < first + 100; ++x)
    sum += result.at(x, view.px / 2, 0) * std::cos(kWaveNumber * view.along(x, view.px / 2));
  return sum * 4.0 / 100.0;
}

// A dense pass is a Gaussian cut off at +-r_max and normalised; along y the light does not change. Its
// transfer, int cos(k t) g dt / int g dt over [-r_max, r_max], by the midpoint rule, is met to the filter's
// own sum over pixels: a tenth of s apart, so smooth but at the two ends, whose kinks are worth h^2 / 12
// times the density's slope there, r_max / s^2 exp(-2) / sqrt(2 pi) = 0.108 of either end: 2e-4 for both.
// Single precision: 1e-5.
TEST(Pscbf, DenseTapsAreACutOffGaussian) {
  constexpr double kRMaxMm = 2.0;
  PlaneView view = kView;
  view.px = 144;
  double cosine = 0.0;
  double mass = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double t = kRMaxMm * (2.0 * (i + 0.5) / kSteps - 1.0);
    cosine += std::cos(kWaveNumber * t) * std::exp(-0.5 * t * t);
    mass += std::exp(-0.5 * t * t);
  }
  const Image result = exitance(view, "pscbf", test::one_gaussian(1.0, 9.0),
                                {{"sampling", std::string("dense")}, {"r_max_mm", kRMaxMm}});
  EXPECT_NEAR(transfer(view, result), cosine / mass, 2.1e-4);
  // The profile's 9 mm would have left the whole Gaussian's transfer, which is another number.
  EXPECT_GT(std::abs(cosine / mass - std::exp(-0.5 * kWaveNumber * kWaveNumber)), 0.01);
}

TEST(Pscbf, TheProfilesRadiusIsTheDefault) {
  for (const char* method : {"pscbf", "pscbf-mip", "screen-integral", "cbf", "cbf-unnormalised"}) {
    const PlaneView view{.mm_per_px = 0.4, .px = 40};
    const Image of_profile = exitance(view, method, test::one_gaussian(1.0, 2.5));
    const Image of_setting = exitance(view, method, test::one_gaussian(1.0, 9.0), {{"r_max_mm", 2.5}});
    EXPECT_EQ(largest_difference(of_profile, 0, of_setting, 0), 0.0) << method;
    const OwnTarget target = find_method(method).own_target(
        test::one_gaussian(1.0, 9.0), Settings(method, find_method(method).settings, {{"r_max_mm", 2.5}}));
    EXPECT_EQ(target.r_max_mm, 2.5) << method;
  }
}

// With taps of its own green is filtered as if it were red. (Sharing red's taps it is not.) To the rounding
// of the offsets, which are the same numbers by way of another product: exact but for ties, of which there
// are none here.
TEST(Pscbf, UnsharedTapsAreEachChannelsOwn) {
  Profile profile = test::one_gaussian(1.0, 4.5);
  profile.terms[0].variance_mm2 = Vec3d(2.3, 1.4, 1.1);
  const Image unshared = exitance(kView, "pscbf", profile, {{"sharing", std::string("none")}});
  const Image shared = exitance(kView, "pscbf", profile);
  for (int c = 0; c < 3; ++c) {
    Profile alone = profile;
    alone.terms[0].variance_mm2 = Vec3d::Constant(profile.terms[0].variance_mm2[c]);
    const Image expected = exitance(kView, "pscbf", alone);
    EXPECT_LE(largest_difference(unshared, c, expected, 0), 1e-6) << c;
    if (c > 0) {
      EXPECT_GT(largest_difference(shared, c, expected, 0), 1e-4) << c;
    }
  }
}

// A write in half precision rounds by 2^-11 of itself at most. Of at most 1 there are four: two passes, the
// first layer (0) and the sum.
TEST(Pscbf, SixteenBitTargetsRoundToHalfPrecision) {
  const Profile profile = test::one_gaussian(1.0, 4.5);
  const Image half = exitance(kView, "pscbf", profile, {{"targets", std::string("16-bit")}});
  const Image full = exitance(kView, "pscbf", profile);
  const double difference = largest_difference(half, 0, full, 0);
  EXPECT_LE(difference, 4.0 * 0x1.0p-11);
  EXPECT_GT(difference, 0x1.0p-14);
}

// A symmetric filter takes cos(k u) to T cos(k u), T = sum over the taps of w_i cos(k t_i).
double transfer_of_taps(const std::vector<GaussianTap>& taps) {
  double sum = 0.0;
  for (const GaussianTap& tap : taps) sum += tap.weight[0] * std::cos(kWaveNumber * tap.offset_mm);
  return sum;
}

// Taps are rounded to pixels of 0.1 mm, so each moves by 0.05 mm at most and cos(k t) by 0.05 k.
TEST(Pscbf, TapsLieWhereTheyShould) {
  PlaneView view = kView;
  view.px = 160;
  for (const TapPlacement placement : {TapPlacement::median, TapPlacement::centroid}) {
    const std::string name = placement == TapPlacement::median ? "median" : "centroid";
    const Image result = exitance(view, "pscbf", test::one_gaussian(1.0, 4.5), {{"placement", name}});
    EXPECT_NEAR(transfer(view, result),
                transfer_of_taps(equal_probability_taps(13, Vec3d::Ones(), placement)), 0.05 * kWaveNumber)
        << name;
  }
}

// What a tap reads of the chain has its mean at the tap, for linear interpolation keeps it, and a spread: of
// a texel, 4^L / 12 px^2, and of the interpolation between two, at most 4^L / 4. Between the levels around
// log2 of the bin's width w, 4^L is at most 1.27 w^2 on average (the chord of 4^f over its curve); at level
// 0, 1/4 px^2 in all. So cos(k t) falls short by no more than k^2 / 2 (0.42 w^2 + 1/4 px^2).
TEST(PscbfMip, ReadsAroundEachTapAsWideAsItsBin) {
  PlaneView view = kView;
  view.px = 256;
  constexpr double kRMaxMm = 4.5;
  const std::vector<GaussianTap> taps = equal_probability_taps(13, Vec3d::Ones(), TapPlacement::median);
  double spread_mm2 = 0.0;
  for (const GaussianTap& tap : taps) {
    const double width_mm = std::min(tap.high_mm, kRMaxMm) - std::max(tap.low_mm, -kRMaxMm);
    spread_mm2 += tap.weight[0] * (0.42 * width_mm * width_mm + 0.25 * view.mm_per_px * view.mm_per_px);
  }
  const double measured = transfer(view, exitance(view, "pscbf-mip", test::one_gaussian(1.0, kRMaxMm)));
  EXPECT_NEAR(measured, transfer_of_taps(taps), 0.5 * kWaveNumber * kWaveNumber * spread_mm2);
  // It does read around them.
  EXPECT_LT(measured, transfer_of_taps(taps) - 0.01);
}

}  // namespace
}  // namespace truescatter
