#include "irradiance/light_fields.h"

#include <gtest/gtest.h>

#include "scene/builtin.h"

namespace truescatter {
namespace {

Light directional(const Vec3d& direction, bool shadows = true) {
  Light light;
  light.direction = direction.normalized();
  light.shadows = shadows;
  return light;
}

struct Lit {
  Mesh mesh = make_builtin("cards", {});
  std::vector<Light> lights;
  ShadingMesh shading;

  explicit Lit(std::vector<Light> from)
      : lights(std::move(from)),
        shading(make_shading_mesh(mesh, Lighting(mesh, lights), SkinMask(), {0.05, 1.0})) {}
  std::vector<LightField> fields() const { return light_fields(shading, mesh, lights); }
};

// Inside the mesh's triangles, away from their shared edges, there is nothing to choose: a corner's light is
// what Lighting says of that one light there.
double largest_difference(const Lit& lit, const CornerIrradiance& field, const Light& light) {
  const Lighting alone(lit.mesh, {light});
  double largest = 0.0;
  for (std::size_t t = 0; t < field.size(); ++t) {
    const ShadingTriangle& triangle = lit.shading.triangles[t];
    for (std::size_t c = 0; c < 3; ++c) {
      if (triangle.base_barycentric[c].minCoeff() < 1e-9) continue;
      const Vec3d expected = alone.irradiance({triangle.base, triangle.base_barycentric[c]});
      largest = std::max(largest, (field[t][c] - expected).cwiseAbs().maxCoeff());
    }
  }
  return largest;
}

TEST(LightFields, OneLightHasAllThatThereIs) {
  const Lit lit({directional({0.4, 0.2, 1.0})});
  const std::vector<LightField> fields = lit.fields();
  ASSERT_EQ(fields.size(), 1U);
  EXPECT_TRUE(fields.front().irradiance.empty());
  for (const auto& corners : rest_of_irradiance(lit.shading, fields)) {
    for (const Vec3d& value : corners) ASSERT_EQ(value, Vec3d::Zero());
  }
}

TEST(LightFields, EachIsItsLightsOwnAndTheySumToAll) {
  Light near;
  near.kind = LightKind::point;
  near.position_mm = Vec3d(-60.0, 10.0, 80.0);
  near.reference_mm = 100.0;
  const Lit lit({directional({0.6, 0.2, 1.0}), near});
  const std::vector<LightField> fields = lit.fields();
  ASSERT_EQ(fields.size(), 2U);
  EXPECT_EQ(fields[1].light.kind, LightKind::point);
  EXPECT_LT(largest_difference(lit, fields[0].irradiance, lit.lights[0]), 1e-12);
  EXPECT_LT(largest_difference(lit, fields[1].irradiance, lit.lights[1]), 1e-12);
  for (const auto& corners : rest_of_irradiance(lit.shading, fields)) {
    for (const Vec3d& value : corners) ASSERT_LT(value.cwiseAbs().maxCoeff(), 1e-12);
  }
}

// A light without shadows has no field, and is what the others leave.
TEST(LightFields, LightsWithoutShadowsAreTheRest) {
  const Lit lit({directional({0.6, 0.2, 1.0}), directional({0.0, 0.0, 1.0}, false)});
  const std::vector<LightField> fields = lit.fields();
  ASSERT_EQ(fields.size(), 1U);
  EXPECT_LT(largest_difference(lit, fields[0].irradiance, lit.lights[0]), 1e-12);
  EXPECT_LT(largest_difference(lit, rest_of_irradiance(lit.shading, fields), lit.lights[1]), 1e-12);
}

}  // namespace
}  // namespace truescatter
