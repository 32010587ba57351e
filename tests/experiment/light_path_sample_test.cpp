// The truth of methods that let light through the body, where it has a closed form.
#include "experiment/light_path_sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "experiment/points_fixture.h"
#include "scene/builtin.h"
#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

// A built-in body whose irradiance depends on the position alone.
PreparedScene lit(const Mesh& mesh, const std::function<double(const Vec3d&)>& light) {
  PreparedScene scene;
  scene.mesh = mesh;
  scene.shading = make_shading_mesh(scene.mesh, Lighting(scene.mesh, {Light{}}), SkinMask(), {0.02, 10.0});
  for (ShadingTriangle& triangle : scene.shading.triangles) {
    Vec3d middle = Vec3d::Zero();
    for (std::size_t c = 0; c < 3; ++c) middle += scene.shading.corner(triangle, c) / 3.0;
    for (Vec3d& value : triangle.irradiance) value = Vec3d::Constant(light(middle));
  }
  scene.largest_irradiance = largest_irradiance(scene.shading);
  return scene;
}

struct Sampled {
  TruthImage image;
  std::size_t points;
};

// The truth at `count` of these places; the Euclidean one is computed at all of them.
Sampled sampled_truth(const PreparedScene& scene, const std::vector<MeshPoint>& places,
                      const OwnTarget& target, const Profile& profile, std::size_t count,
                      const KeptValues& shared = {}) {
  TruthSpec spec;
  spec.audit_points = 16;
  const SceneTruths truths(scene, spec, true, nullptr, {}, shared);
  EXPECT_EQ(truths.obstacle(target), "");
  const FrameImages images = images_of(scene, places);
  ViewTruth view(scene, images);
  view.compute(
      {{&profile, OwnTarget{}}}, spec,
      [&](LayerKind kind, const ViewPoints& points) { return truths.source(kind, points); },
      truths.geodesic());
  const LightPathSample sample(
      {scene, truths, view, profile, target.r_max_mm.value_or(profile.r_max_mm), count, 5});
  return {sample.truth(target), sample.size()};
}

// Points within 3 mm of the middle of a slab's near side.
std::vector<MeshPoint> near_the_middle(const Mesh& mesh) {
  std::vector<MeshPoint> places;
  for (const MeshPoint& place : random_places(mesh, 200000)) {
    const Vec3d x = position_mm(mesh, place);
    if (triangle_normal(mesh, place.triangle).z() > 0.9 && x.head<2>().norm() < 3.0) places.push_back(place);
    if (places.size() == 24) break;
  }
  return places;
}

// A slab of thickness t with the light a on its near side and b behind; both are planes as far as any
// Gaussian reaches. The local part, normalised, is a whatever its cut-off; from behind comes b exp(-t^2 / 2
// v) of each Gaussian, for G(sqrt(t^2 + rho^2)) is that times the plane's. Raw and cut off, of the local part
// 1 - exp(-r_max^2 / 2 v) are left. What may differ: the quadrature, 2e-5 + 1e-5 (light_paths_test.cpp), the
// fast engine, 1e-4, both of the brightest irradiance, 2; single precision.
TEST(LightPathSample, GivesASlabsTruthWithWhatComesThrough) {
  constexpr double kThicknessMm = 2.0;
  constexpr double kNear = 0.5;
  constexpr double kFar = 2.0;
  const PreparedScene scene = lit(make_builtin("slab", {{"size_mm", 60.0}, {"thickness_mm", kThicknessMm}}),
                                  [](const Vec3d& x) { return x.z() > 0.0 ? kNear : kFar; });
  const std::vector<MeshPoint> places = near_the_middle(scene.mesh);
  ASSERT_EQ(places.size(), 24U);
  const Profile profile = two_gaussians();
  constexpr double kAllowed = kFar * 1.4e-4;
  for (const bool geodesic : {false, true}) {
    for (const bool normalised : {false, true}) {
      for (const std::optional<double> r_max_mm : {std::optional<double>(), std::optional<double>(4.0)}) {
        Vec3d expected = profile.delta_weight * kNear;
        for (const GaussianTerm& term : profile.terms) {
          const double v = term.variance_mm2.x();
          const double local = r_max_mm && !normalised ? -std::expm1(-0.5 * *r_max_mm * *r_max_mm / v) : 1.0;
          expected += term.weight * (kNear * local + kFar * std::exp(-0.5 * kThicknessMm * kThicknessMm / v));
        }
        const OwnTarget target{geodesic, normalised, r_max_mm, false, true};
        const Sampled truth = sampled_truth(scene, places, target, profile, 10);
        EXPECT_EQ(truth.points, 10U);
        std::size_t known = 0;
        for (int x = 0; x < truth.image.rgb.width(); ++x) {
          if (truth.image.smallest_mass.at(x, 0, 0) == 0.0F) continue;
          ++known;
          EXPECT_NEAR(truth.image.smallest_mass.at(x, 0, 0), 1.0, 1e-3);
          EXPECT_LT((truth.image.rgb.rgb(x, 0) - expected).cwiseAbs().maxCoeff(), kAllowed)
              << geodesic << normalised << r_max_mm.has_value();
        }
        EXPECT_EQ(known, 10U);
        EXPECT_LE(truth.image.certificate.max_error, truth.image.certificate.tolerance);
      }
    }
  }
}

// In a convex body every way is inside: nothing is air, so raw and not cut off the parts are the Euclidean
// truth, whatever the local part measures distance by. Differences: as above, and the Euclidean engine's
// 1e-4.
TEST(LightPathSample, IsTheEuclideanTruthOfAConvexBody) {
  const PreparedScene scene = lit(make_builtin("sphere", {{"radius_mm", 6.0}, {"edge_mm", 1.0}}),
                                  [](const Vec3d& x) { return 1.0 + x.x() / 6.0; });
  const std::vector<MeshPoint> places = random_places(scene.mesh, 16);
  const Profile profile = two_gaussians();
  const TruthImage euclidean = truth_of(scene, places, {.normalised = false});
  // The kinks of the sum where two geodesics are equally long lie opposite, where nothing is left of these
  // Gaussians.
  Profile near = profile;
  near.r_max_mm = 3.0;
  const Sampled whole = sampled_truth(scene, places, {true, false, std::nullopt, false, true}, near, 16);
  const Sampled straight = sampled_truth(scene, places, {false, false, std::nullopt, false, true}, near, 16);
  const double allowed = 2.5e-4 * scene.largest_irradiance;
  // Curvature, within r_max, is the Euclidean target's alone.
  EXPECT_LE(largest_difference(straight.image.rgb, euclidean.rgb), allowed);
  EXPECT_GT(largest_difference(whole.image.rgb, euclidean.rgb), allowed);
}

// Cut off along the surface, what lies nearer and what comes through from farther are the Euclidean truth of
// a convex body again. At 1 mm the Gaussians, s = 0.7 and 2 mm, are large where the parts jump, so that
// quadrature is of first order: it is halved until that changes no point by more than a third of 1e-3 of the
// light, and an error of first order is not larger than its change. With the engines: as above.
TEST(LightPathSample, HalvesItsPartsWhereTheCutOffJumps) {
  const PreparedScene scene = lit(make_builtin("sphere", {{"radius_mm", 6.0}, {"edge_mm", 1.0}}),
                                  [](const Vec3d& x) { return 1.0 + x.x() / 6.0; });
  const std::vector<MeshPoint> places = random_places(scene.mesh, 16);
  const TruthImage euclidean = truth_of(scene, places, {.normalised = false});
  const Sampled cut = sampled_truth(scene, places, {false, false, 1.0, false, true}, two_gaussians(), 16);
  EXPECT_TRUE(cut.image.certificate.passed());
  EXPECT_EQ(cut.image.certificate.audited, 16U);
  EXPECT_LE(largest_difference(cut.image.rgb, euclidean.rgb),
            (1e-3 / 3.0 + 2.5e-4) * scene.largest_irradiance);
}

// Parts of an experiment find what one of them has computed: splits, light along the surface, and the exact
// values that it is audited with. For other light, another body and another cut-off they compute their own.
TEST(LightPathSample, IsComputedOnceByParts) {
  const TempDir folder;
  const Mesh sphere = make_builtin("sphere", {{"radius_mm", 6.0}, {"edge_mm", 1.0}});
  const Mesh smaller = make_builtin("sphere", {{"radius_mm", 5.5}, {"edge_mm", 1.0}});
  const auto from_the_right = [](const Vec3d& x) { return 1.0 + x.x() / 6.0; };
  const auto from_above = [](const Vec3d& x) { return 1.0 + x.y() / 6.0; };
  const std::vector<MeshPoint> places = random_places(sphere, 4);
  // Its picture, and how many files it added to the cache.
  const auto truth = [&](const PreparedScene& scene, double r_max_mm) {
    TruthCache cache(folder.path(), 1 << 20);
    const OwnTarget target{false, true, r_max_mm, false, true};
    const Sampled sampled = sampled_truth(scene, places, target, two_gaussians(), 4, {&cache, "program"});
    return std::pair(sampled.image, cache.stored_count());
  };
  const PreparedScene scene = lit(sphere, from_the_right);
  const auto [first, computed] = truth(scene, 3.0);
  EXPECT_EQ(computed, 3U);
  const auto [second, computed_again] = truth(scene, 3.0);
  EXPECT_EQ(computed_again, 0U);
  EXPECT_EQ(largest_difference(first.rgb, second.rgb), 0.0);
  EXPECT_EQ(first.certificate.max_error, second.certificate.max_error);
  const OwnTarget target{false, true, 3.0, false, true};
  const Sampled alone = sampled_truth(scene, places, target, two_gaussians(), 4);
  EXPECT_EQ(largest_difference(first.rgb, alone.image.rgb), 0.0);
  EXPECT_EQ(first.certificate.max_error, alone.image.certificate.max_error);
  EXPECT_EQ(truth(scene, 3.5).second, 3U);
  EXPECT_EQ(truth(lit(sphere, from_above), 3.0).second, 3U);
  EXPECT_EQ(truth(lit(smaller, from_the_right), 3.0).second, 3U);
}

}  // namespace
}  // namespace truescatter::test
