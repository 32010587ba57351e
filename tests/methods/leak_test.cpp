// Light that crosses from one surface to another that lies behind it: one card in front of the other, 20 mm
// apart, one of them dark. The truth is 0 on the dark one.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;

constexpr double kSizeMm = 60.0;
constexpr double kDistanceMm = 2000.0;  // far away, so that both cards have nearly one scale

// The red light on the dark card's pixels, in mm^2 of full irradiance.
double leak_mm2(std::string_view method) {
  ShadingMesh shading = test::shade(make_builtin("cards"), test::lamp(Vec3d::UnitZ()));
  for (ShadingTriangle& t : shading.triangles) {
    const bool back = shading.corner(t, 0).z() < 0.0;
    for (Vec3d& value : t.irradiance) value = back ? Vec3d::Zero() : Vec3d::Ones();
  }
  const Scene scene(std::move(shading), test::camera_at(kDistanceMm, 80.0, 256));
  const Image result = scene.run(find_method(method), builtin_profiles().front());
  const double px_mm = kDistanceMm / scene.frame().camera.focal_px();
  double sum = 0.0;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const bool back =
          scene.images().mask.at(x, y, 0) != 0.0F && scene.images().position.at(x, y, 2) < -kDistanceMm;
      if (back) sum += static_cast<double>(result.at(x, y, 0)) * px_mm * px_mm;
    }
  }
  return sum;
}

TEST(Leak, Blur2dCarriesLightAcrossTheGap) {
  // A step of height 1 blurred by s puts s / sqrt(2 pi) mm^2 per mm of edge beyond it; red: weight 0.85,
  // s = sqrt(2.3) mm, over an edge of 60 mm: 30.9 mm^2. (At the edge's two ends a corner is missing: the
  // background takes what would lie beyond, below s^2 / 2 each.) The scale differs between the cards by
  // 20 mm / 2000 mm, pixels of 0.31 mm resolve s by five: 5 % in all.
  const double expected = 0.85 * std::sqrt(2.3 / (2.0 * kPi)) * kSizeMm;
  EXPECT_NEAR(leak_mm2("blur2d"), expected, 0.05 * expected);
}

TEST(Leak, PscbfStopsAtTheDepthStep) {
  // The depth term: exp(-20^2 / (2 * 2.3)) = 2e-38 for red, below what a float sum of weights can hold (1e-7
  // of 30 mm^2 would be 3e-6).
  EXPECT_LE(leak_mm2("pscbf"), 3e-6);
}

}  // namespace
}  // namespace truescatter
