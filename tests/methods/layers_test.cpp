// Two cards, one before half of the other, 20 mm apart: around the front one's edge the back one is hidden
// within reach of pixels that are seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/plane_frame.h"
#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;

constexpr double kRMaxMm = 4.5;
constexpr double kStdDevMm = 1.5;
constexpr double kHeightMm = 32.0;
constexpr int kPx = 128;

Image exitance(const Scene& scene, double layers) {
  return scene.run(find_method("cbf-unnormalised"), test::one_gaussian(kStdDevMm, kRMaxMm),
                   {{"layers", layers}});
}

// The largest error on the back card, where the card itself goes on for r_max and more around every pixel:
// its light is 1, so the truth is its mass, 1 - exp(-r_max^2 / 2 s^2). (Light of the other card: exp(-20^2 /
// 2 s^2) = 2e-39.)
double worst_on_back(const Scene& scene, const Image& result) {
  const double mass = 1.0 - std::exp(-0.5 * kRMaxMm * kRMaxMm / (kStdDevMm * kStdDevMm));
  const int margin = static_cast<int>(std::ceil(1.1 * kRMaxMm / (kHeightMm / kPx)));
  double worst = 0.0;
  int compared = 0;
  for (int y = margin; y < kPx - margin; ++y) {
    for (int x = margin; x < kPx - margin; ++x) {
      if (scene.images().position.at(x, y, 2) > -300.0F) continue;
      ++compared;
      worst = std::max(worst, std::abs(result.rgb(x, y).x() - mass));
    }
  }
  EXPECT_GT(compared, 1000);
  return worst;
}

TEST(Layers, ASecondRecoversWhatTheFirstMisses) {
  const Scene scene(test::shade(make_builtin("cards", {{"gap_mm", 20.0}}), test::lamp(Vec3d::UnitZ())),
                    test::camera_at(300.0, kHeightMm, kPx));
  const Image one = exitance(scene, 1.0);
  const Image two = exitance(scene, 2.0);
  // At the front card's edge half of the back one is hidden, up to a pixel: 0.5 less h / (s sqrt(2 pi)) =
  // 0.07.
  EXPECT_GT(worst_on_back(scene, one), 0.5 - 0.07 - std::exp(-0.5 * 9.0));
  // The manual's limits: the rim, 3 G(r_max) r_max h, and perspective, 1.25 (r_max / D)^2.
  const double h = kHeightMm / kPx * 310.0 / 300.0;
  const double at_rim = std::exp(-0.5 * 9.0) / (2.0 * kPi * kStdDevMm * kStdDevMm);
  EXPECT_LE(worst_on_back(scene, two),
            3.0 * at_rim * kRMaxMm * h + 1.25 * std::pow(kRMaxMm / 310.0, 2) + 1e-5);
  // There is no third surface.
  const Image three = exitance(scene, 3.0);
  EXPECT_TRUE(std::ranges::equal(three.data(), two.data()));
}

}  // namespace
}  // namespace truescatter
