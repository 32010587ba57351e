// The screen-space filters on an endless plane, where the truth has a closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "support/error_of.h"
#include "support/plane_frame.h"

namespace truescatter {
namespace {

using test::PlaneFrame;
using test::PlaneView;

constexpr double kStdDevMm = 1.0;
struct Filter {
  std::string name;
  std::map<std::string, SettingValue> settings;
  bool normalised;
};

const Filter kScreenIntegral{"screen-integral", {}, false};
const Filter kUnnormalised{"cbf-unnormalised", {}, false};
const Filter kCbf{"cbf", {}, true};
const Filter kDensePscbf{"pscbf", {{"sampling", std::string("dense")}}, true};

// The largest error under 1/2 + 1/2 cos(2 pi u / wavelength), over pixels whose whole reach is in the
// picture.
double cosine_error(const Filter& filter, const PlaneView& view, double r_max_mm, double wavelength_mm,
                    int margin) {
  const auto wave = [&](double u) { return 0.5 * std::cos(2.0 * kPi * u / wavelength_mm); };
  const PlaneFrame frame(view, [&](double u) { return 0.5 + wave(u); });
  const Image result =
      frame.run(find_method(filter.name), test::one_gaussian(kStdDevMm, r_max_mm), filter.settings);
  const double mass = test::plane_transfer(kStdDevMm, r_max_mm, kInfinity);
  const double transfer = test::plane_transfer(kStdDevMm, r_max_mm, wavelength_mm);
  double worst = 0.0;
  for (int y = margin; y < view.px - margin; ++y) {
    for (int x = margin; x < view.px - margin; ++x) {
      const double truth = 0.5 * mass + transfer * wave(view.along(x, y));
      const double exitance = truth / (filter.normalised ? mass : 1.0);
      worst = std::max(worst, std::abs(result.rgb(x, y).maxCoeff() - exitance));
    }
  }
  return worst;
}

int margin_px(const PlaneView& view, double r_max_mm) {
  return static_cast<int>(std::ceil(r_max_mm / view.mm_per_px)) + 1;
}

// What every method keeps to on a plane that faces the camera: 1e-3 of the largest irradiance, at wavelengths
// of 16 px and more. A fifteenth of s a pixel, cut-offs from where it takes 13 % of the light to where it
// takes none.
TEST(Plane, CosineLightIsFilteredAsTheTruthIs) {
  for (const Filter& filter : {kScreenIntegral, kUnnormalised, kCbf}) {
    for (const double r_max_mm : {2.0, 3.0, 4.5}) {
      PlaneView view;
      const int margin = margin_px(view, r_max_mm);
      view.px = 2 * margin + 20;
      for (const double wavelength_px : {16.0, 64.0}) {
        EXPECT_LE(cosine_error(filter, view, r_max_mm, wavelength_px * view.mm_per_px, margin), 1e-3)
            << filter.name << " r_max " << r_max_mm << " wavelength " << wavelength_px;
      }
    }
  }
}

// Its two passes are cut off by a square: at 4 s and more that leaves 3e-4 between it and the disc.
TEST(Plane, DenseTapsFilterCosineLightAsTheTruthDoes) {
  for (const double r_max_mm : {4.0, 5.0}) {
    PlaneView view;
    const int margin = margin_px(view, r_max_mm);
    view.px = 2 * margin + 20;
    for (const double wavelength_px : {16.0, 64.0}) {
      EXPECT_LE(cosine_error(kDensePscbf, view, r_max_mm, wavelength_px * view.mm_per_px, margin), 1e-3)
          << "r_max " << r_max_mm << " wavelength " << wavelength_px;
    }
  }
}

// Equations 1 to 3 in strong perspective (60 mm away) and on slopes, one of them not along the picture's
// axes: what is summed is the integral over the surface, so that w(p) is right. The bound goes to 0 with the
// pixel: the rim of the cut-off, 3 G(r_max) r_max h (manual of screen-integral), and light taken as even on a
// footprint. Across an edge h the product of the Gaussian and I is off by h^2 (|G'| |I'| / 12 + G |I''| /
// 24); the integral of |G'| in one direction is sqrt(2 / pi) / s; I' and I'' are at most k / 2 and k^2 / 2.
// Two edges: twice. The corner of the 4 mm that are compared, and 3 mm on, is atan((2 sqrt(2) + 3) / 60) =
// 6 degrees off the axis, which lengthens h = mm_per_px / cos(tilt) to mm_per_px / (cos(tilt + 6 degrees)
// cos(6 degrees)^2).
TEST(Plane, TheAreaWeightIsRightInPerspectiveAndOnSlopes) {
  constexpr double kRMaxMm = 3.0;
  constexpr double kWavelengthMm = 8.0;
  const double k = 2.0 * kPi / kWavelengthMm;
  const double at_rim = std::exp(-0.5 * kRMaxMm * kRMaxMm) / (2.0 * kPi);
  for (const double tilt_deg : {0.0, 60.0}) {
    for (const Vec3d& axis : {Vec3d(0.0, 1.0, 0.0), Vec3d(0.6, 0.8, 0.0)}) {
      double finest = 0.0;
      for (const double mm_per_px : {0.4, 0.2, 0.1}) {
        PlaneView view{.distance_mm = 60.0, .mm_per_px = mm_per_px, .tilt_deg = tilt_deg, .tilt_axis = axis};
        const int margin = margin_px(view, 1.1 * kRMaxMm);
        view.px = 2 * margin + static_cast<int>(4.0 / mm_per_px);
        constexpr double kOff = 6.0 * kPi / 180.0;
        const double h = mm_per_px / std::cos(tilt_deg * kPi / 180.0 + kOff) / std::pow(std::cos(kOff), 2);
        const double bound = 3.0 * at_rim * kRMaxMm * std::min(h, 0.5 * kStdDevMm) +
                             2.0 * h * h * (std::sqrt(2.0 / kPi) / kStdDevMm * k / 24.0 + k * k / 48.0);
        finest = cosine_error(kScreenIntegral, view, kRMaxMm, kWavelengthMm, margin);
        EXPECT_LE(finest, bound) << tilt_deg << " degrees, " << mm_per_px << " mm a pixel";
      }
      EXPECT_LE(finest, 1e-3) << tilt_deg << " degrees";
    }
  }
  // The test can tell: with w(p_o) for w(p) the tilted plane's light comes out wrong by more than that.
  PlaneView view{.distance_mm = 60.0, .mm_per_px = 0.1, .tilt_deg = 60.0};
  const int margin = margin_px(view, 1.1 * kRMaxMm);
  view.px = 2 * margin + 40;
  const Filter constant{"screen-integral", {{"area", std::string("constant")}}, false};
  EXPECT_GT(cosine_error(constant, view, kRMaxMm, kWavelengthMm, margin), 2e-3);
}

// An area takes the face's normal, K and d' the interpolated one: turned by 25 degrees it changes nothing for
// the first and something for the second.
TEST(Plane, AreasTakeTheFacesNormal) {
  PlaneView view{.mm_per_px = 0.3, .px = 40, .tilt_deg = 30.0};
  PlaneView turned = view;
  turned.shading_tilt_deg = 25.0;
  for (const Filter& filter : {kScreenIntegral, kUnnormalised, kCbf}) {
    const auto exitance = [&](const PlaneView& of) {
      return PlaneFrame(of, [](double u) { return 0.5 + 0.5 * std::cos(u); })
          .run(find_method(filter.name), test::one_gaussian(kStdDevMm, 3.0), filter.settings);
    };
    const Image before = exitance(view);
    const Image after = exitance(turned);
    EXPECT_EQ(std::ranges::equal(before.data(), after.data()), filter.name == "screen-integral")
        << filter.name;
  }
}

// I = 1 for u > 0. Taking a footprint's light from its middle moves the edge by half a footprint at most, and
// a row's share of light there is that of the one-dimensional Gaussian's peak: an error of h / (2 s sqrt(2
// pi)), of first order. r_max = 4.5 s leaves out 4e-5.
TEST(Plane, AStepConvergesAtFirstOrder) {
  constexpr double kRMaxMm = 4.5;
  for (const Filter& filter : {kScreenIntegral, kUnnormalised, kCbf, kDensePscbf}) {
    for (const double mm_per_px : {0.6, 0.3, 0.15}) {
      PlaneView view{.mm_per_px = mm_per_px};
      const int margin = margin_px(view, kRMaxMm);
      view.px = 2 * margin + 12;
      double worst = 0.0;
      for (const double edge_px : {0.0, 0.49}) {
        const double edge_mm = edge_px * mm_per_px;
        const PlaneFrame frame(view, [&](double u) { return u > edge_mm ? 1.0 : 0.0; });
        const Image result =
            frame.run(find_method(filter.name), test::one_gaussian(kStdDevMm, kRMaxMm), filter.settings);
        for (int x = margin; x < view.px - margin; ++x) {
          const int y = view.px / 2;
          const double from_edge_mm = view.along(x, y) - edge_mm;
          const double truth = 0.5 * std::erfc(-from_edge_mm / (std::sqrt(2.0) * kStdDevMm));
          worst = std::max(worst, std::abs(result.rgb(x, y).x() - truth));
        }
      }
      // 6e-5: perspective, r_max^2 / D^2 with D = 600 mm.
      EXPECT_LE(worst, mm_per_px / (2.0 * kStdDevMm * std::sqrt(2.0 * kPi)) + 4e-5 + 6e-5)
          << filter.name << " " << mm_per_px;
    }
  }
}

// A sum over all pixels says where it would take too many instead of losing some: a ball of 4.5 mm is 300 px
// across at 0.03 mm a pixel, and the picture of 260 x 260 = 67600 pixels is within it.
// The variance that a normalised filter has along a slope, from its result under the light u^2 at the slope's
// middle: the kernel's mean of u^2.
double variance_along_slope_mm2(const Filter& filter, double tilt_deg, double mm_per_px) {
  PlaneView view;
  view.tilt_deg = tilt_deg;
  view.mm_per_px = mm_per_px;
  const int half = static_cast<int>(6.0 / mm_per_px);  // 6 mm are in view facing, more on the slope
  view.px = 2 * half + 1;                              // a pixel's centre lies at u = 0
  const PlaneFrame frame(view, [](double u) { return u * u; });
  const Image result =
      frame.run(find_method(filter.name), test::one_gaussian(kStdDevMm, 5.0), filter.settings);
  return result.rgb(half, half).x();
}

// What the depth term counts twice. With K the exponent is that of the distance, whatever the slope. Taps
// that are laid in proportion across d' have the surface's distance u already, and the depth's u sin(theta)
// comes on top: exp(-u^2 (1 + sin^2 theta) / 2 s^2), variance s^2 / (1 + sin^2 theta), 0.57 s^2 at 60
// degrees.
//
// Tolerance: sums over pixels of a Gaussian of at least 3 pixels' deviation are exact to 2 exp(-2 pi^2 9);
// the cut at 5 s takes 25 exp(-12.5) = 1e-4 of the variance; perspective makes a pixel's share of the slope
// change by u sin(theta) / 600 mm, whose first order is odd and whose second is (5 / 600)^2 = 7e-5 at the
// reach's end; K and d' are exact at the middle but for (r_max / 600)^2 as well. 16 digits of u^2 in single
// precision: 1e-6.
TEST(Plane, ProportionalTapsCountTheSlopeTwice) {
  const Filter proportional{"cbf", {{"spacing", std::string("proportional")}}, true};
  for (const double tilt_deg : {0.0, 60.0}) {
    const double sine = std::sin(tilt_deg * kPi / 180.0);
    EXPECT_NEAR(variance_along_slope_mm2(kCbf, tilt_deg, 0.1), 1.0, 1e-3) << tilt_deg;
    EXPECT_NEAR(variance_along_slope_mm2(proportional, tilt_deg, 0.1), 1.0 / (1.0 + sine * sine), 1e-3)
        << tilt_deg;
    EXPECT_NEAR(variance_along_slope_mm2(kDensePscbf, tilt_deg, 0.1), 1.0 / (1.0 + sine * sine), 1e-3)
        << tilt_deg;
  }
}

// 13 taps of equal probability have less variance than the Gaussian that they stand for: 0.907 of it at
// medians, 0.971 at centroids (taps_test.cpp derives both). So has the filter on a plane that faces the
// camera, but for nearest sampling: a tap at x is read up to half a pixel h beside it, at x + d, and the mean
// of x^2 errs by 2 E|x d| + d^2 <= h E|x| + h^2 / 4 = 0.041 for h = 0.05 mm and E|x| = 0.8 mm.
TEST(Plane, ThirteenTapsLoseVariance) {
  const Filter medians{"pscbf", {}, true};
  const Filter centroids{"pscbf", {{"placement", std::string("centroid")}}, true};
  EXPECT_NEAR(variance_along_slope_mm2(medians, 0.0, 0.05), 0.907, 0.041);
  EXPECT_NEAR(variance_along_slope_mm2(centroids, 0.0, 0.05), 0.971, 0.041);
}

TEST(Plane, AReachOfTooManyPixelsIsAnError) {
  for (const Filter& filter : {kScreenIntegral, kUnnormalised, kCbf}) {
    const PlaneView view{.distance_mm = 300.0, .mm_per_px = 0.03, .px = 260};
    const PlaneFrame frame(view, [](double) { return 1.0; });
    const auto error = test::error_of(
        [&] { frame.run(find_method(filter.name), test::one_gaussian(kStdDevMm, 4.5), filter.settings); });
    ASSERT_TRUE(error) << filter.name;
    EXPECT_NE(std::string(error->what()).find("'" + filter.name + "'"), std::string::npos) << error->what();
    EXPECT_NE(std::string(error->what()).find("'r_max_mm'"), std::string::npos) << error->what();
  }
}

}  // namespace
}  // namespace truescatter
