#include "irradiance/surface_albedo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "irradiance/shading_mesh.h"
#include "scene/builtin.h"

namespace truescatter {
namespace {

// 0.2 at u = 0 to 0.8 at u = 1 in red, twice that in green, 0.5 in blue; linear where UvTexture does not
// wrap: half a texel, 1/128, away from the borders.
UvTexture ramp() {
  Image image(64, 4, 3);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 64; ++x) {
      const double red = 0.2 + 0.6 * (x + 0.5) / 64;
      image.set_rgb(x, y, {red, 2.0 * red, 0.5});
    }
  }
  return UvTexture(image);
}

Light lamp() {
  Light light;
  light.direction = Vec3d(0.0, 0.6, 0.8);
  return light;
}

TEST(SurfaceAlbedo, MultipliesTheIrradianceByItsPower) {
  const Mesh plane = make_builtin("plane", {{"size_mm", 60.0}, {"edge_mm", 5.0}});
  for (const double exponent : {0.0, 0.25, 0.5, 1.0}) {
    const Lighting lighting(plane, {lamp()}, {}, {ramp(), exponent});
    EXPECT_EQ(lighting.has_maps(), exponent > 0.0);
    const ShadingMesh shading = make_shading_mesh(plane, lighting, {}, {0.02, 0.4});
    // Smooth lighting asks for no splits, and the albedo for none.
    EXPECT_EQ(shading.triangles.size(), plane.triangle_count());
    for (const ShadingTriangle& t : shading.triangles) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double u = t.uvs[c].x();
        if (u < 1.0 / 128 || u > 127.0 / 128) continue;
        const double red = 0.2 + 0.6 * u;
        // E = 0.8; texels are floats.
        EXPECT_NEAR(t.irradiance[c].x(), 0.8 * std::pow(red, exponent), 1e-6);
        EXPECT_NEAR(t.irradiance[c].y(), 0.8 * std::pow(2.0 * red, exponent), 1e-6);
        EXPECT_NEAR(t.irradiance[c].z(), 0.8 * std::pow(0.5, exponent), 1e-6);
      }
    }
  }
}

TEST(SurfaceAlbedo, IsReadAtVerticesAndWhatIsLeftOutIsInTheResidual) {
  // Red is a square wave of four periods along u, 15 mm each: edges of 5 mm miss much of it. At half of the
  // edge length the residual falls: of a step between two vertices h apart the linear value is off by
  // up to 1/2 over h. With 8 steps in 60 mm its mean is at most (8 h / 60) / 4 times the step.
  Image image(512, 4, 3, 1.0F);
  for (int x = 0; x < 512; ++x) {
    for (int y = 0; y < 4; ++y) image.at(x, y, 0) = x / 64 % 2 == 0 ? 1.0F : 0.25F;
  }
  const Mesh plane = make_builtin("plane", {{"size_mm", 60.0}, {"edge_mm", 5.0}});
  const Lighting lighting(plane, {lamp()}, {}, {UvTexture(image), 0.5});
  Camera camera;
  camera.eye_mm = Vec3d(0.0, 0.0, 500.0);
  camera.fov_y_deg = 20.0;
  camera.width_px = 64;
  camera.height_px = 64;
  double last = 1.0;
  for (const double edge_mm : {4.0, 2.0, 1.0, 0.5}) {
    const ShadingMesh shading = make_shading_mesh(plane, lighting, {}, {0.02, 0.4, {camera}, edge_mm});
    const ShadingResidual residual = measure_residual(shading, lighting, 20000, 1);
    // A triangle reaches along u by its longest edge at most. The step: from 1 to 0.25^0.5, of the largest.
    EXPECT_LE(residual.mean, 8.0 * edge_mm / 60.0 * 0.5);
    EXPECT_GT(residual.mean, 0.0);
    EXPECT_LT(residual.mean, 0.8 * last);
    last = residual.mean;
  }
}

TEST(SurfaceAlbedo, OneIrradianceAtASeam) {
  // Where the tube's chart closes, u = 0 side meets u = 1 side, and the ramp differs. Each vertex has one
  // value for each of its normals, so that light is one function on the surface.
  const Mesh tube = make_builtin("tube");
  Light even = lamp();
  even.kind = LightKind::environment;
  even.environment[0].setConstant(1.0);
  const ShadingMesh shading =
      make_shading_mesh(tube, Lighting(tube, {even}, {}, {ramp(), 1.0}), {}, {0.02, 0.4});
  std::map<int, std::vector<std::pair<Vec3d, double>>> seen;
  int compared = 0;
  for (const ShadingTriangle& t : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (const auto& [normal, value] : seen[t.vertices[c]]) {
        if (!same_normal(normal, t.normals[c])) continue;
        EXPECT_EQ(value, t.irradiance[c].x());
        ++compared;
      }
      seen[t.vertices[c]].emplace_back(t.normals[c], t.irradiance[c].x());
    }
  }
  EXPECT_GT(compared, 1000);
}

}  // namespace
}  // namespace truescatter
