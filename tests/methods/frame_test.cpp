#include "methods/frame.h"

#include <gtest/gtest.h>

#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;

TEST(Frame, KnowsEachPixelsSurfacePoint) {
  const Camera camera = test::camera_at(300.0, 60.0, 128);
  const Scene scene(test::shade(make_builtin("sphere"), test::lamp(Vec3d(1.0, 0.5, 1.0))), camera);
  const Mat4d view = camera.view_matrix();
  int seen = 0;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      const PixelSurface& surface = scene.images().surface_at(x, y);
      if (surface.triangle < 0) {
        EXPECT_EQ(scene.images().position.rgb(x, y), Vec3d::Zero());
        continue;
      }
      ++seen;
      const ShadingTriangle& t = scene.shading().triangles[static_cast<std::size_t>(surface.triangle)];
      Vec3d position = Vec3d::Zero();
      Vec3d irradiance = Vec3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        position += surface.barycentric[static_cast<Eigen::Index>(c)] * scene.shading().corner(t, c);
        irradiance += surface.barycentric[static_cast<Eigen::Index>(c)] * t.irradiance[c];
      }
      // Interpolation in single precision, perspective-corrected: 2^-23 per operation; at grazing angles the
      // correction divides nearly equal depths, which costs two digits: 1e-4 of an edge of 2 mm, 1e-4 of I.
      const Vec3d in_view = view.topLeftCorner<3, 3>() * position + view.topRightCorner<3, 1>();
      EXPECT_LT((in_view - scene.images().position.rgb(x, y)).norm(), 2e-3);
      EXPECT_LT((irradiance - scene.images().irradiance.rgb(x, y)).norm(), 1e-3);
      // The point lies on the ray through the pixel's centre: the sample is there and nowhere else.
      const Vec3d p = scene.images().position.rgb(x, y);
      EXPECT_NEAR(p.x() / -p.z() * camera.focal_px() + 64.0, x + 0.5, 2e-2);
      EXPECT_NEAR(64.0 - p.y() / -p.z() * camera.focal_px(), y + 0.5, 2e-2);
      EXPECT_NEAR(scene.images().face_normal.rgb(x, y).norm(), 1.0, 1e-5);
      EXPECT_NEAR(scene.images().normal.rgb(x, y).norm(), 1.0, 1e-5);
      EXPECT_GT(scene.images().face_normal.rgb(x, y).dot(-p.normalized()), 0.0);
    }
  }
  // A disc of angular radius asin(25/300) at a focal length of 640 px: radius 53.5 px, 8990 pixels.
  EXPECT_NEAR(seen, 8990, 200);
}

TEST(Frame, UpIsUp) {
  // Lit from above: the picture's upper half is the bright one.
  const Scene scene(test::shade(make_builtin("sphere"), test::lamp(Vec3d(0.0, 1.0, 0.2))),
                    test::camera_at(300.0, 60.0, 64));
  EXPECT_GT(scene.images().irradiance.at(32, 12, 0), scene.images().irradiance.at(32, 52, 0));
}

TEST(Program, ACompilerErrorNamesFileAndLine) {
  const gpu::ShaderText broken{"my.frag", "out vec4 c;\nvoid main() {\n  c = vec4(nonsense);\n}\n"};
  try {
    const gpu::Program program(Scene::context(), {gpu::FullScreen::vertex_shader()}, {broken});
    FAIL() << "a broken shader compiled";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), 2);
    EXPECT_EQ(error.where().file, "my.frag");
    EXPECT_EQ(error.where().line, 3);
    EXPECT_NE(std::string(error.what()).find("nonsense"), std::string::npos);
  }
}

}  // namespace
}  // namespace truescatter
