#include "experiment/visible_surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "experiment/points_fixture.h"
#include "scene/builtin.h"
#include "truth/exact.h"

namespace truescatter::test {
namespace {

// A built-in scene of 24 mm, lit so that irradiance is `value` of the position, linear.
template <typename Value>
PreparedScene lit_scene(const std::string& name, BuiltinParameters parameters, const Value& value) {
  PreparedScene scene;
  parameters["size_mm"] = 24.0;
  parameters["edge_mm"] = 6.0;
  scene.mesh = make_builtin(name, parameters);
  scene.shading = make_shading_mesh(scene.mesh, Lighting(scene.mesh, {Light{}}), SkinMask(), {1.0, 6.0});
  for (ShadingTriangle& triangle : scene.shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) triangle.irradiance[c] = value(scene.shading.corner(triangle, c));
  }
  scene.largest_irradiance = largest_irradiance(scene.shading);
  return scene;
}

Vec3d slanted(const Vec3d& p) { return {1.0 + p.x() / 13.0, 1.0 + p.y() / 14.0, 0.5}; }
Vec3d even(const Vec3d&) { return Vec3d::Ones(); }

// Looks along -z from 100 mm before the origin.
Camera camera_at(double x_mm, double fov_deg, int px = 96) {
  Camera camera;
  camera.eye_mm = Vec3d(x_mm, 0.0, 100.0);
  camera.target_mm = Vec3d(x_mm, 0.0, 0.0);
  camera.fov_y_deg = fov_deg;
  camera.width_px = camera.height_px = px;
  return camera;
}

double area_mm2(const Surface& surface, int component) {
  double area = 0.0;
  for (const SurfaceTriangle& triangle : surface.triangles) {
    if (triangle.component == component) area += triangle.area_mm2();
  }
  return area;
}

// The place on the scene's mesh at (x, y) that is nearest to the viewer.
MeshPoint place_at(const Mesh& mesh, double x, double y, double z) {
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    Mat3d corners;
    for (int c = 0; c < 3; ++c) corners.col(c) = Vec3d(mesh.corner(t, c).x(), mesh.corner(t, c).y(), 1.0);
    if (std::abs(mesh.corner(t, 0).z() - z) + std::abs(mesh.corner(t, 1).z() - z) +
            std::abs(mesh.corner(t, 2).z() - z) >
        1e-9)
      continue;
    const Vec3d barycentric = corners.inverse() * Vec3d(x, y, 1.0);
    if (barycentric.minCoeff() >= 0.0) return {t, barycentric};
  }
  throw std::runtime_error("no such place");
}

// A plane seen whole: the pieces become the shading triangles again, nothing is in doubt, and the truth is
// that of the whole surface, to the last bit.
TEST(VisibleSurface, OfAPlaneSeenWholeIsThePlane) {
  const PreparedScene scene = lit_scene("plane", {}, slanted);
  const VisibleSurface visible = visible_surface(scene, camera_at(3.0, 20.0));
  EXPECT_TRUE(visible.unsure.triangles.empty());
  const Surface skin = scattering_surface(scene.shading);
  ASSERT_EQ(visible.seen.triangles.size(), skin.triangles.size());
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    EXPECT_EQ(visible.seen.triangles[t].corners_mm, skin.triangles[t].corners_mm);
    EXPECT_EQ(visible.seen.triangles[t].irradiance, skin.triangles[t].irradiance);
  }
  const std::vector<MeshPoint> places = random_places(scene.mesh, 40);
  const TruthImage all = truth_of(scene, places, {});
  const TruthImage seen = truth_of(scene, places, {false, true, std::nullopt, true}, &visible);
  EXPECT_EQ(largest_difference(seen.rgb, all.rgb), 0.0);
  EXPECT_EQ(seen.visibility_bound.at(0, 0, 0), 0.0F);
  EXPECT_TRUE(all.visibility_bound.empty());
}

// Only what the picture shows: at 100 mm, with a field of 10 degrees, a square of 2 * 100 tan 5 deg. What is
// unsure lies within a piece's length of its border: an eighth of a pixel on either side.
TEST(VisibleSurface, EndsWithThePicture) {
  const PreparedScene scene = lit_scene("plane", {}, even);
  const VisibleSurface visible = visible_surface(scene, camera_at(0.0, 10.0));
  const double side_mm = 200.0 * std::tan(5.0 * kPi / 180.0);
  const double unsure = area_mm2(visible.unsure, 0);
  EXPECT_NEAR(area_mm2(visible.seen, 0), side_mm * side_mm, unsure);
  EXPECT_GT(unsure, 0.0);
  EXPECT_LT(unsure, 0.25 * 4.0 * side_mm * side_mm / 96.0);
}

// From x = 10 mm the front card's edge at x = 0, z = 3 stands before x = 10 - 10 * 103 / 97 of the back card
// at z = -3; beyond that the front card hides it to its end. An edge crosses pieces within an eighth of
// a pixel on either side: a strip a quarter of a pixel wide.
class Cards : public testing::Test {
 protected:
  static constexpr double kEdge = 10.0 - 10.0 * 103.0 / 97.0;

  const PreparedScene scene_ = lit_scene("cards", {{"gap_mm", 6.0}}, slanted);
  const Camera camera_ = camera_at(10.0, 30.0, 384);
  const VisibleSurface visible_ = visible_surface(scene_, camera_);
};

TEST_F(Cards, TheFrontOneHidesTheBackOne) {
  EXPECT_NEAR(area_mm2(visible_.seen, 1), 24.0 * 12.0, 1e-9);
  EXPECT_EQ(area_mm2(visible_.unsure, 1), 0.0);
  const double unsure = area_mm2(visible_.unsure, 0);
  EXPECT_NEAR(area_mm2(visible_.seen, 0), 24.0 * (12.0 - kEdge), unsure);
  EXPECT_GT(unsure, 0.0);
  EXPECT_LT(unsure, 0.25 * 24.0 * 103.0 / camera_.focal_px());
}

// The truth on the back card is the exact convolution over what is left of it, a rectangle, to within the
// bound and the uncertainty; and far from that over all of it.
TEST_F(Cards, WhatIsHiddenGivesNoLight) {
  Surface rectangle;
  const auto corner = [](double x, double y) { return Vec3d(x, y, -3.0); };
  for (const std::array<Vec3d, 3>& corners :
       {std::array<Vec3d, 3>{corner(kEdge, -12.0), corner(12.0, -12.0), corner(12.0, 12.0)},
        std::array<Vec3d, 3>{corner(kEdge, -12.0), corner(12.0, 12.0), corner(kEdge, 12.0)}}) {
    rectangle.triangles.push_back(
        {corners, {slanted(corners[0]), slanted(corners[1]), slanted(corners[2])}, 0});
  }
  const ExactEngine exact(rectangle);
  std::vector<MeshPoint> places;
  std::vector<Vec3d> at;
  for (const double x : {-0.3, 0.0, 0.7, 2.0, 5.0}) {
    at.emplace_back(x, 1.3, -3.0);
    places.push_back(place_at(scene_.mesh, x, 1.3, -3.0));
  }
  const Profile profile = two_gaussians();
  for (const bool normalised : {false, true}) {
    const TruthImage seen = truth_of(scene_, places, {false, normalised, std::nullopt, true}, &visible_);
    const TruthImage all = truth_of(scene_, places, {false, normalised, std::nullopt});
    for (std::size_t i = 0; i < at.size(); ++i) {
      Vec3d expected = profile.delta_weight.cwiseProduct(slanted(at[i]));
      for (const GaussianLevel& level : gaussian_levels(profile)) {
        const Vec4d value = exact.convolve({at[i], 0}, {level.std_dev_mm()});
        expected += level.weight.cwiseProduct(value.head<3>()) / (normalised ? value[3] : 1.0);
      }
      const int x = static_cast<int>(i);
      const double bound =
          scene_.largest_irradiance * (seen.certificate.uncertainty() + seen.visibility_bound.at(x, 0, 0)) +
          2.0 * 0x1p-23;  // the pictures' rounding
      EXPECT_LE((seen.rgb.rgb(x, 0) - expected).cwiseAbs().maxCoeff(), bound) << i;
      if (i == 0 && !normalised) {  // beside the edge, half of the light is hidden
        EXPECT_GT((all.rgb.rgb(x, 0) - expected).cwiseAbs().maxCoeff(), 3.0 * bound);
      }
    }
    // Beside the edge the doubt is that of the strip; 5 mm from it, 2.8 s, there is little.
    EXPECT_LT(seen.visibility_bound.at(4, 0, 0), 0.02F);
    EXPECT_GT(seen.visibility_bound.at(0, 0, 0), seen.visibility_bound.at(4, 0, 0));
  }
}

// The middle of a slab, 1 mm thick: its back adds exp(-1 / 2v) of a plane's mass to every Gaussian of
// variance v, unless what is not visible is left out. The slab ends 12 mm, 6 standard deviations of the wide
// one, away.
TEST(VisibleSurfaceOfASlab, HasNoBack) {
  const PreparedScene scene = lit_scene("slab", {{"thickness_mm", 1.0}}, even);
  const VisibleSurface visible = visible_surface(scene, camera_at(0.0, 20.0));
  EXPECT_NEAR(area_mm2(visible.seen, 0), 24.0 * 24.0, area_mm2(visible.unsure, 0) + 1e-9);
  const std::vector<MeshPoint> places = {place_at(scene.mesh, 0.3, -0.2, 0.5)};
  const TruthImage seen = truth_of(scene, places, {false, false, std::nullopt, true}, &visible);
  const TruthImage all = truth_of(scene, places, {false, false, std::nullopt});
  const Profile profile = two_gaussians();
  Vec3d back = Vec3d::Zero();
  for (const GaussianLevel& level : gaussian_levels(profile))
    back += level.weight * std::exp(-0.5 / level.variance_mm2);
  const double bound = seen.certificate.uncertainty() + all.certificate.uncertainty() +
                       seen.visibility_bound.at(0, 0, 0) + 4.0 * std::exp(-0.5 * 36.0) + 2.0 * 0x1p-23;
  EXPECT_LE((seen.rgb.rgb(0, 0) - profile.total_weight()).cwiseAbs().maxCoeff(), bound);
  EXPECT_LE((all.rgb.rgb(0, 0) - profile.total_weight() - back).cwiseAbs().maxCoeff(), bound);
  EXPECT_GT(back.minCoeff(), 100.0 * bound);
}

}  // namespace
}  // namespace truescatter::test
