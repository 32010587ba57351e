#include "experiment/view_truth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "experiment/points_fixture.h"
#include "scene/builtin.h"
#include "scene/mesh.h"

namespace truescatter::test {
namespace {

// A sheet of 24 mm along u and 12 mm along v, folded about u = 0 by `fold_deg`: (u, v) keeps its place in the
// sheet, and folding stretches nothing.
Mesh folded_sheet(double fold_deg) {
  constexpr int kColumns = 8;
  constexpr int kRows = 4;
  std::mt19937_64 generator(3);
  const double fold = fold_deg * kPi / 180.0;
  Mesh mesh;
  for (int j = 0; j <= kRows; ++j) {
    for (int i = 0; i <= kColumns; ++i) {
      const bool on_a_line = i == 0 || i == kColumns || 2 * i == kColumns || j == 0 || j == kRows;
      const Vec2d shift = on_a_line ? Vec2d(0.0, 0.0) : Vec2d(uniform(generator), uniform(generator));
      const Vec2d uv = 3.0 * Vec2d(i - kColumns / 2, j - kRows / 2) + shift;
      const double along = std::max(uv.x(), 0.0);
      mesh.positions_mm.emplace_back(std::min(uv.x(), 0.0) + along * std::cos(fold), uv.y(),
                                     along * std::sin(fold));
    }
  }
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const int a = j * (kColumns + 1) + i;
      const int d = a + kColumns + 1;
      mesh.triangles.push_back({a, a + 1, d + 1});
      mesh.triangles.push_back({a, d + 1, d});
    }
  }
  set_angle_weighted_normals(mesh, 1.0);
  return mesh;
}

// Lit by something that grows along v and across the fold, the same at the same place of the sheet: linear
// between the mesh's vertices, so that refinement changes nothing.
PreparedScene lit_sheet(double fold_deg) {
  PreparedScene scene;
  scene.mesh = folded_sheet(fold_deg);
  // Splits every edge that is longer than 1 mm.
  Camera camera;
  camera.eye_mm = Vec3d(-30.0, 0.0, 60.0);
  const Lighting lighting(scene.mesh, {Light{}});
  scene.shading = make_shading_mesh(scene.mesh, lighting, SkinMask(), {0.02, 0.5, {camera}, 1.0});
  const Mesh flat = folded_sheet(0.0);
  const auto value = [](const Vec3d& sheet) {
    return Vec3d(1.0 + sheet.x() / 13.0, 1.0 + sheet.y() / 7.0, 0.5 - sheet.x() / 30.0);
  };
  for (ShadingTriangle& triangle : scene.shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c)
      triangle.irradiance[c] = value(position_mm(flat, {triangle.base, triangle.base_barycentric[c]}));
  }
  scene.largest_irradiance = largest_irradiance(scene.shading);
  return scene;
}

// Folding a sheet changes no distance along it: its geodesic truth is the flat sheet's Euclidean one. Both
// are audited at every point, so they differ by their uncertainties and by the pictures' rounding (2^-24 of
// values below 2) at most. Distances through the air do change.
TEST(GeodesicViewTruth, IsTheEuclideanTruthOfTheUnfoldedSheet) {
  const PreparedScene flat = lit_sheet(0.0);
  const PreparedScene folded = lit_sheet(100.0);
  ASSERT_GT(folded.shading.triangles.size(), 10 * folded.mesh.triangle_count());
  const std::vector<MeshPoint> places = random_places(flat.mesh, 120);
  for (const bool normalised : {true, false}) {
    for (const std::optional<double> r_max_mm : {std::optional<double>(), std::optional<double>(2.5)}) {
      const TruthImage euclidean = truth_of(flat, places, {false, normalised, r_max_mm});
      const TruthImage geodesic = truth_of(folded, places, {true, normalised, r_max_mm});
      const double bound = euclidean.certificate.uncertainty() * flat.largest_irradiance +
                           geodesic.certificate.uncertainty() * folded.largest_irradiance + 2.0 * 0x1p-23;
      EXPECT_LE(largest_difference(geodesic.rgb, euclidean.rgb), bound);
      EXPECT_LE(largest_difference(geodesic.smallest_mass, euclidean.smallest_mass), bound);
      const TruthImage through_air = truth_of(folded, places, {false, normalised, r_max_mm});
      EXPECT_GT(largest_difference(through_air.rgb, geodesic.rgb), 10.0 * bound);
    }
  }
}

// Of a cut Gaussian the mass is told as a share of what a plane has: whole in the middle of the sheet, where
// the cut at 2.5 mm leaves 1 - exp(-2.5^2 / 8) = 54 % of the wide one.
TEST(GeodesicViewTruth, TellsMassAsAShareOfAPlanes) {
  const PreparedScene scene = lit_sheet(0.0);
  std::size_t middle = 0;
  for (std::size_t t = 0; t < scene.mesh.triangle_count(); ++t) {
    const Vec3d center = position_mm(scene.mesh, {t, Vec3d::Constant(1.0 / 3.0)});
    const Vec3d best = position_mm(scene.mesh, {middle, Vec3d::Constant(1.0 / 3.0)});
    if (center.norm() < best.norm()) middle = t;
  }
  const TruthImage truth = truth_of(scene, {{middle, Vec3d::Constant(1.0 / 3.0)}}, {true, true, 2.5});
  EXPECT_NEAR(truth.smallest_mass.at(0, 0, 0), 1.0, 2.0 * 1e-4);  // the tolerance over 0.54
}

// An edge of three triangles: the reason names it, and the Euclidean truth is there all the same.
TEST(GeodesicViewTruth, HasAReasonWhereTheMeshCarriesNone) {
  PreparedScene scene = lit_sheet(0.0);
  scene.mesh.positions_mm.emplace_back(0.0, 0.0, 5.0);
  const auto [a, b, c] = scene.mesh.triangles[0];
  scene.mesh.triangles.push_back({a, b, static_cast<int>(scene.mesh.positions_mm.size()) - 1});
  const SceneTruths truths(scene, TruthSpec{}, true);
  EXPECT_EQ(truths.geodesic(), nullptr);
  EXPECT_EQ(truths.obstacle(OwnTarget{}), "");
  EXPECT_TRUE(truths.obstacle({true, true, std::nullopt})
                  .starts_with("the mesh carries no geodesics: triangles 0 and 64 run along one edge"))
      << truths.obstacle({true, true, std::nullopt});
}

// Nobody asked: nothing is built, whatever the mesh.
TEST(GeodesicViewTruth, IsNotBuiltUnlessAskedFor) {
  const PreparedScene scene = lit_sheet(0.0);
  EXPECT_EQ(SceneTruths(scene, TruthSpec{}, false).geodesic(), nullptr);
  EXPECT_NE(SceneTruths(scene, TruthSpec{}, true).geodesic(), nullptr);
}

// A plane whose skin begins at x = 0, with irradiance 0.25 there and 1 on what is not skin.
PreparedScene half_skin() {
  PreparedScene scene;
  scene.mesh = make_builtin("plane");  // 60 mm wide
  scene.shading = make_shading_mesh(scene.mesh, Lighting(scene.mesh, {Light{}}), SkinMask(), {0.02, 0.5});
  for (ShadingTriangle& t : scene.shading.triangles) {
    const ShadingMesh& in = scene.shading;
    t.skin = in.corner(t, 0).x() + in.corner(t, 1).x() + in.corner(t, 2).x() > 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_TRUE(t.skin ? in.corner(t, c).x() >= 0.0 : in.corner(t, c).x() <= 0.0);
    t.scatters = t.skin;
    t.component = t.skin ? 0 : -1;
    t.irradiance.fill(Vec3d::Constant(t.skin ? 0.25 : 1.0));
  }
  scene.shading.component_count = 1;
  scene.largest_irradiance = largest_irradiance(scene.shading);
  return scene;
}

// Points of the skin, at least 20 mm from where the plane ends: ten standard deviations of the widest
// Gaussian.
std::vector<MeshPoint> places_beside_the_border(const Mesh& mesh) {
  std::vector<MeshPoint> places;
  for (const MeshPoint& place : random_places(mesh, 4000)) {
    const Vec3d p = position_mm(mesh, place);
    if (p.x() > 0.0 && p.x() < 8.0 && std::abs(p.y()) < 10.0) places.push_back(place);
  }
  return places;
}

// With I = i on the skin and i + d off it, a Gaussian of standard deviation s sees, at a distance x from the
// border, the share Q = erfc(x / (s sqrt 2)) / 2 of the other half: raw i (1 - Q) and mass 1 - Q if the skin
// alone scatters, i + d Q and mass 1 if everything does.
TEST(MaskTruth, IsTheHalfPlanesClosedForm) {
  PreparedScene scene = half_skin();
  const std::vector<MeshPoint> places = places_beside_the_border(scene.mesh);
  ASSERT_GT(places.size(), 100U);
  const Profile profile = two_gaussians();
  for (const bool all : {false, true}) {
    if (all) scatter_everywhere(scene.shading);
    scene.largest_irradiance = largest_irradiance(scene.shading);
    EXPECT_EQ(scene.largest_irradiance, all ? 1.0 : 0.25);
    for (const bool geodesic : {false, true}) {
      for (const bool normalised : {false, true}) {
        const TruthImage truth = truth_of(scene, places, {geodesic, normalised, std::nullopt});
        const double bound = truth.certificate.uncertainty() * scene.largest_irradiance + 0x1p-23;
        for (std::size_t i = 0; i < places.size(); ++i) {
          const double x_mm = position_mm(scene.mesh, places[i]).x();
          Vec3d expected = 0.25 * profile.delta_weight;
          for (const GaussianTerm& term : profile.terms) {
            const double other = 0.5 * std::erfc(x_mm / std::sqrt(2.0 * term.variance_mm2.x()));
            const double raw = all ? 0.25 + 0.75 * other : 0.25 * (1.0 - other);
            expected += term.weight * (all || !normalised ? raw : 0.25);
          }
          for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(truth.rgb.at(static_cast<int>(i), 0, c), expected[c], bound) << x_mm << " mm";
        }
      }
    }
  }
}

}  // namespace
}  // namespace truescatter::test
