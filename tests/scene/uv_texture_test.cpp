#include "scene/uv_texture.h"

#include <gtest/gtest.h>

namespace truescatter {
namespace {

// Red 1 in the top left texel, green 1 in the bottom right one.
UvTexture corners() {
  Image image(2, 2, 3);
  image.at(0, 0, 0) = 1.0F;
  image.at(1, 1, 1) = 1.0F;
  return UvTexture(image);
}

TEST(UvTexture, VIsUpAndValuesStandAtTexelCentres) {
  const UvTexture texture = corners();
  EXPECT_NEAR((texture.rgb(Vec2d(0.25, 0.75)) - Vec3d(1.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((texture.rgb(Vec2d(0.75, 0.25)) - Vec3d(0.0, 1.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(texture.rgb(Vec2d(0.25, 0.25)), Vec3d::Zero());
}

TEST(UvTexture, IsBilinearInBetween) {
  const UvTexture texture = corners();
  EXPECT_NEAR(texture.value(Vec2d(0.5, 0.75), 0), 0.5, 1e-12);
  // A fifth of the way to the right, a tenth down: 0.8 * 0.9 of the top left, 0.2 * 0.1 of the bottom right.
  EXPECT_NEAR(texture.value(Vec2d(0.35, 0.7), 0), 0.72, 1e-12);
  EXPECT_NEAR(texture.value(Vec2d(0.35, 0.7), 1), 0.02, 1e-12);
}

TEST(UvTexture, RepeatsBeyondTheUnitSquare) {
  const UvTexture texture = corners();
  for (const Vec2d& shift : {Vec2d(1.0, 0.0), Vec2d(-2.0, 3.0), Vec2d(0.0, -1.0)}) {
    EXPECT_NEAR(texture.value(Vec2d(0.35, 0.7) + shift, 0), 0.72, 1e-12);
  }
  // At u = 0 the left column and the right one, which comes before it, meet half and half.
  EXPECT_NEAR(texture.value(Vec2d(0.0, 0.75), 0), 0.5, 1e-12);
}

}  // namespace
}  // namespace truescatter
