// What pscbf-transmit adds to pscbf, against the light that truly passes through the body.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "methods/pscbf/taps.h"
#include "support/plane_frame.h"
#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;

constexpr double kStdDevMm = 1.5;
constexpr double kRMaxMm = 4.5;

// A slab whose near side gets `front` and whose far side gets 1, seen from `distance_mm` and turned about the
// y axis.
Scene lit_slab(double thickness_mm, double front, double tilt_deg, double distance_mm, double height_mm,
               int px) {
  Mesh slab = make_builtin("slab", {{"size_mm", 60.0}, {"thickness_mm", thickness_mm}});
  const Eigen::AngleAxisd turn(tilt_deg * kPi / 180.0, Vec3d::UnitY());
  for (Vec3d& p : slab.positions_mm) p = turn * p;
  for (auto& corners : slab.corner_normals) {
    for (Vec3d& n : corners) n = turn * n;
  }
  ShadingMesh shading = test::shade(slab, test::lamp(turn * Vec3d::UnitZ()));
  for (ShadingTriangle& triangle : shading.triangles) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < 3; ++c)
      nearest = std::min(nearest, (turn * Vec3d::UnitZ()).dot(shading.corner(triangle, c)));
    const bool near_side = nearest > 0.0;
    for (Vec3d& value : triangle.irradiance) value = Vec3d::Constant(near_side ? front : 1.0);
  }
  return {std::move(shading), test::camera_at(distance_mm, height_mm, px)};
}

double at_middle(const Scene& scene, const std::string& method,
                 const std::map<std::string, SettingValue>& settings) {
  const int middle = scene.frame().camera.width_px / 2;
  return scene.run(find_method(method), test::one_gaussian(kStdDevMm, kRMaxMm), settings)
      .at(middle, middle, 0);
}

double added(const Scene& scene, const std::map<std::string, SettingValue>& settings = {}) {
  return at_middle(scene, "pscbf-transmit", settings) - at_middle(scene, "pscbf", settings);
}

// Facing the camera every tap meets the far side at the depth t, so it adds the truth's transmittance,
// int G(sqrt(t^2 + rho^2)) dA = exp(-t^2 / 2 s^2) (light_paths_test.cpp), whatever the taps are. Single
// precision depths at 300 mm are good to 2 * 1.5e-5 mm, times the largest slope of the fade, 0.61 /
// s: 1.2e-5; and 1e-6 of sums.
TEST(PscbfTransmit, AddsWhatPassesThroughASlab) {
  for (const double thickness_mm : {0.5, 1.0, 2.0, 4.0}) {
    const Scene scene = lit_slab(thickness_mm, 0.0, 0.0, 300.0, 24.0, 96);
    const double truth = std::exp(-0.5 * thickness_mm * thickness_mm / (kStdDevMm * kStdDevMm));
    EXPECT_NEAR(added(scene), truth, 1.3e-5) << thickness_mm;
    EXPECT_NEAR(added(scene, {{"placement", std::string("centroid")}}), truth, 1.3e-5) << thickness_mm;
  }
}

// The Euclidean, normalised truth of an evenly lit slab is 1, for every point has the mass 1 + exp(-t^2 / 2
// s^2) and divides by it; the method adds to what is normalised already and gives that mass. So it is off by
// exp(-t^2 / 2 s^2): that is the method as its source has it, to the rounding above and pscbf's.
TEST(PscbfTransmit, AddsToWhatIsNormalisedAlready) {
  const Scene scene = lit_slab(2.0, 1.0, 0.0, 300.0, 24.0, 96);
  EXPECT_NEAR(at_middle(scene, "pscbf-transmit", {}) - 1.0, std::exp(-0.5 * 4.0 / 2.25), 2.5e-5);
}

// Only transmitters are drawn: with the mask on the right half alone, points there are lit from behind as
// before, points on the left, whose taps reach 1.15 s = 1.7 mm, not at all.
TEST(PscbfTransmit, KeepsToItsTransmitters) {
  const Scene lit = lit_slab(2.0, 0.0, 0.0, 300.0, 24.0, 96);
  ShadingMesh masked = lit.shading();
  for (ShadingTriangle& triangle : masked.triangles) {
    double middle = 0.0;
    for (std::size_t c = 0; c < 3; ++c) middle += masked.corner(triangle, c).x();
    triangle.transmits = middle > 0.0;
  }
  const Profile profile = test::one_gaussian(kStdDevMm, kRMaxMm);
  const Image all = lit.run(find_method("pscbf-transmit"), profile);
  const Image half = Scene(std::move(masked), lit.frame().camera).run(find_method("pscbf-transmit"), profile);
  EXPECT_GT(all.at(24, 48, 0), 0.4F);
  EXPECT_EQ(half.at(24, 48, 0), 0.0F);
  EXPECT_EQ(half.at(72, 48, 0), all.at(72, 48, 0));
}

// Seen at an angle the far side lies t / cos(theta) behind, and a tap q s off (in the surface) is deeper by
// another q s sin(theta): sum_q exp(-(t / (s cos(theta)) + q sin(theta))^2 / 2) / 4 over the four medians q,
// which is the manual's formula but for the taps, and far below the truth exp(-t^2 / 2 s^2). From 2000 mm the
// picture is parallel but for a tap's distance, 2 mm, over that of the eye: 1e-3 of a depth. Taps are rounded
// to pixels of 0.05 mm, so depths to 0.025 tan(theta): 0.6 / s times both, 0.6 / 1.5 (0.025 tan(theta) +
// 0.004) at most, of the fade.
TEST(PscbfTransmit, TakesThicknessAlongTheView) {
  constexpr double kThicknessMm = 1.0;
  for (const double tilt_deg : {30.0, 45.0, 60.0}) {
    const double tilt = tilt_deg * kPi / 180.0;
    const Scene scene = lit_slab(kThicknessMm, 0.0, tilt_deg, 2000.0, 12.8, 256);
    double expected = 0.0;
    for (const GaussianTap& tap : equal_probability_taps(4, Vec3d::Ones(), TapPlacement::median)) {
      const double depth = kThicknessMm / (kStdDevMm * std::cos(tilt)) + tap.offset_mm * std::sin(tilt);
      expected += 0.25 * std::exp(-0.5 * depth * depth);
    }
    const double truth = std::exp(-0.5 * kThicknessMm * kThicknessMm / (kStdDevMm * kStdDevMm));
    const double value = added(scene);
    EXPECT_NEAR(value, expected, 0.4 * (0.025 * std::tan(tilt) + 0.004)) << tilt_deg;
    EXPECT_LT(value, truth) << tilt_deg;
  }
}

// A sphere of radius R: planes oppose only where the sphere is at least sqrt(2) R thick along the view, so
// the light that comes through is below exp(-R^2 / s^2) there; at R = 10 s that is exp(-100), less than
// single precision adds to pscbf's result: nothing. Taps reach 1.15 s from the centre, where the sphere is as
// thick but for that: exp(-80).
TEST(PscbfTransmit, AddsNothingToAThickBody) {
  const Scene scene(
      test::shade(make_builtin("sphere", {{"radius_mm", 15.0}}), test::lamp(Vec3d(0.3, 0.2, -1.0))),
      test::camera_at(400.0, 34.0, 128));
  const Profile profile = test::one_gaussian(kStdDevMm, kRMaxMm);
  const Image with = scene.run(find_method("pscbf-transmit"), profile);
  const Image without = scene.run(find_method("pscbf"), profile);
  for (std::size_t i = 0; i < with.data().size(); ++i) ASSERT_EQ(with.data()[i], without.data()[i]);
}

}  // namespace
}  // namespace truescatter
