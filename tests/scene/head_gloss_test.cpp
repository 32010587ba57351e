#include "scene/head_gloss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "scene/head_shape.h"

namespace truescatter {
namespace {

SkinGloss gloss_of(std::string_view region) {
  for (const GlossRegion& known : head_gloss_regions()) {
    if (known.name == region) return known.gloss;
  }
  ADD_FAILURE() << "no such region: " << region;
  return {};
}

// The foremost point of the skin over (x, y), by bisection.
Vec3d on_face(double x_mm, double y_mm) {
  double outside = 150.0;
  double inside = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (outside + inside);
    (head_distance_mm(Vec3d(x_mm, y_mm, middle)) > 0.0 ? outside : inside) = middle;
  }
  return {x_mm, y_mm, outside};
}

TEST(HeadGloss, TenRegionsLieWithinTheWalkthroughsRanges) {
  ASSERT_EQ(head_gloss_regions().size(), 10U);
  for (const GlossRegion& region : head_gloss_regions()) {
    EXPECT_GE(region.gloss.intensity, 0.18) << region.name;
    EXPECT_LE(region.gloss.intensity, 0.34) << region.name;
    EXPECT_GE(region.gloss.roughness, 0.23) << region.name;
    EXPECT_LE(region.gloss.roughness, 0.32) << region.name;
  }
}

// Both sides of the face alike.
TEST(HeadGloss, OfAPointWithinARegionIsTheRegions) {
  const std::map<std::string, Vec3d> points = {
      {"nose", on_face(0.0, -12.0)},    {"forehead", on_face(0.0, 40.0)},
      {"lips", on_face(5.0, -38.5)},    {"chin", on_face(0.0, -59.0)},
      {"eyelids", on_face(22.0, 7.0)},  {"cheeks", on_face(36.0, -22.0)},
      {"temples", on_face(50.0, 20.0)}, {"neck and scalp", Vec3d(0.0, 40.0, -90.0)}};
  for (const auto& [region, p] : points) {
    for (const double side : {1.0, -1.0}) {
      const SkinGloss gloss = head_gloss(Vec3d(side * p.x(), p.y(), p.z()));
      EXPECT_NEAR(gloss.intensity, gloss_of(region).intensity, 1e-9) << region;
      EXPECT_NEAR(gloss.roughness, gloss_of(region).roughness, 1e-9) << region;
    }
  }
}

// Ears apart, which are parts of the mesh. The largest step between regions, 0.34 to 0.24, is passed over 6
// mm by a smoothstep, 1.5 / 6 of it per mm at most; where several borders meet, their sum.
TEST(HeadGloss, PassesFromRegionToRegion) {
  constexpr double kStep_mm = 0.25;
  for (double y = -60.0; y < 60.0; y += 3.0) {
    SkinGloss before = head_gloss(on_face(-40.0, y));
    for (double x = -40.0 + kStep_mm; x < 40.0; x += kStep_mm) {
      const Vec3d p = on_face(x, y);
      if (std::abs(p.z() - on_face(x - kStep_mm, y).z()) > kStep_mm) {
        before = head_gloss(p);
        continue;
      }
      const SkinGloss gloss = head_gloss(p);
      EXPECT_LE(std::abs(gloss.intensity - before.intensity), 3.0 * 0.16 * 1.5 / 6.0 * kStep_mm)
          << x << " " << y;
      before = gloss;
    }
  }
}

}  // namespace
}  // namespace truescatter
