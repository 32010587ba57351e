#include "experiment/uv_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/render.h"

namespace truescatter {
namespace {

// Two rectangles of 20 x 40 mm that share the edge x = 0, facing the viewer. On the left UV is twice as dense
// along x as along y, on the right alike; the two charts lie apart. Each has a diagonal, on which UVs go on.
// Where `hidden`, a third one, 5 mm in front, hides the lower half of the edge.
Mesh two_charts(bool hidden) {
  Mesh mesh;
  std::vector<std::array<Vec2d, 3>> uvs;
  mesh.positions_mm = {{-20, -20, 0}, {0, -20, 0}, {0, 20, 0}, {-20, 20, 0}, {20, -20, 0}, {20, 20, 0}};
  const auto add = [&](const std::array<int, 4>& corners, const std::array<Vec2d, 4>& uv) {
    for (const std::array<std::size_t, 3>& t : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
      mesh.triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
      uvs.push_back({uv[t[0]], uv[t[1]], uv[t[2]]});
    }
  };
  add({0, 1, 2, 3}, {Vec2d(0.0, 0.0), {0.4, 0.0}, {0.4, 0.4}, {0.0, 0.4}});
  add({1, 4, 5, 2}, {Vec2d(0.5, 0.0), {0.7, 0.0}, {0.7, 0.4}, {0.5, 0.4}});
  if (hidden) {
    for (const Vec3d& p : {Vec3d(-10, -20, 5), Vec3d(10, -20, 5), Vec3d(10, 0, 5), Vec3d(-10, 0, 5)})
      mesh.positions_mm.push_back(p);
    add({6, 7, 8, 9}, {Vec2d(0.8, 0.0), {0.9, 0.0}, {0.9, 0.1}, {0.8, 0.1}});
  }
  mesh.corner_normals.assign(mesh.triangles.size(), {Vec3d::UnitZ(), Vec3d::UnitZ(), Vec3d::UnitZ()});
  mesh.corner_uvs = uvs;
  return mesh;
}

TEST(UvSeams, AreTheEdgesWhereUvsDiffer) {
  const std::vector<SeamEdge> seams = uv_seams(two_charts(true));
  ASSERT_EQ(seams.size(), 1U);
  EXPECT_EQ(seams[0][0].x(), 0.0);
  EXPECT_EQ(seams[0][1].x(), 0.0);
  EXPECT_EQ(std::abs(seams[0][0].y() - seams[0][1].y()), 40.0);
}

TEST(UvSeams, OfOneChartAreNone) { EXPECT_TRUE(uv_seams(make_builtin("plane")).empty()); }

// 64 pixels show 64 mm from 1000 mm away: the seam at x = 0 runs along the border between columns 31 and 32
// and counts to the latter, in the rows of -20 to 20 mm, which are 12 to 51.
TEST(SeamPixels, AreThoseThatTheSeamPassesThrough) {
  const Mesh mesh = two_charts(false);
  const test::Scene scene(test::shade(mesh, test::lamp(Vec3d::UnitZ())), test::camera_at(1000.0, 64.0, 64));
  const Image pixels = seam_pixels(uv_seams(mesh), scene.frame().camera, scene.images());
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x)
      EXPECT_EQ(pixels.at(x, y, 0), x == 32 && y >= 12 && y < 52 ? 1.0F : 0.0F) << x << " " << y;
  }
}

// What lies in front of the lower half hides it: rows from the middle, 32, on.
TEST(SeamPixels, AHiddenSeamHasNone) {
  const Mesh mesh = two_charts(true);
  const test::Scene scene(test::shade(mesh, test::lamp(Vec3d::UnitZ())), test::camera_at(1000.0, 64.0, 64));
  const Image pixels = seam_pixels(uv_seams(mesh), scene.frame().camera, scene.images());
  for (int y = 0; y < 64; ++y) EXPECT_EQ(pixels.at(32, y, 0), y >= 12 && y < 32 ? 1.0F : 0.0F) << y;
}

// A seam that leaves the picture and passes behind the camera.
TEST(SeamPixels, ASeamMayLeaveThePicture) {
  const Mesh mesh = two_charts(false);
  Camera camera = test::camera_at(10.0, 8.0, 32);
  camera.eye_mm = Vec3d(0.0, -15.0, 2.0);
  camera.target_mm = Vec3d(0.0, 20.0, 0.0);
  camera.up = Vec3d::UnitZ();
  const test::Scene scene(test::shade(mesh, test::lamp(Vec3d::UnitZ())), camera);
  const Image pixels = seam_pixels(uv_seams(mesh), camera, scene.images());
  // Along the picture's middle column from its lower border, as far as skin is seen.
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      const bool skin = scene.images().mask.at(x, y, 0) != 0.0F;
      EXPECT_EQ(pixels.at(x, y, 0), x == 16 && skin ? 1.0F : 0.0F) << x << " " << y;
    }
  }
}

// Left: 0.02 per mm along x and 0.01 along y, 2; right 0.01 and 0.01. Distances: a pixel is a millimetre but
// for the focal length, 64 / (2 * 0.032) = 1000 pixels at 1000 mm.
TEST(UvView, HasStretchAndDistances) {
  const Mesh mesh = two_charts(false);
  const test::Scene scene(test::shade(mesh, test::lamp(Vec3d::UnitZ())), test::camera_at(1000.0, 64.0, 64));
  const UvView view = uv_view(mesh, scene.shading(), scene.frame().camera, scene.images());
  EXPECT_NEAR(view.anisotropy.at(20, 30, 0), 2.0, 1e-6);
  EXPECT_NEAR(view.anisotropy.at(40, 30, 0), 1.0, 1e-6);
  EXPECT_NEAR(view.seam_delta_mm[30 * 64 + 37], 5.0, 5e-6);  // positions are of single precision
  EXPECT_TRUE(std::isinf(view.seam_delta_mm[0]));
}

}  // namespace
}  // namespace truescatter
