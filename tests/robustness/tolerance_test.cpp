// The tolerance that runs state, held by both fast engines on every built-in scene and on the scanned head,
// under a lamp from the side whose shadows the shading mesh resolves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>

#include "scene/builtin.h"
#include "scene/load_mesh.h"
#include "support/lit_scene.h"
#include "support/sampling.h"
#include "truth/exact.h"
#include "truth/fast.h"
#include "truth/geodesic_exact.h"
#include "truth/geodesic_fast.h"

namespace truescatter {
namespace {

using test::LitScene;
using test::random_barycentric;

const std::vector<TruthLayer> kLayers = {{0.22}, {0.75}, {1.41}, {2.72}, {1.5166, 4.5}};

// From the side and a little from above and before, so that it grazes and throws shadows.
Light side_lamp() {
  Light light;
  light.direction = Vec3d(1.0, 0.3, 0.25).normalized();
  return light;
}

// `count` points of each kind: anywhere, at vertices, on edges, and where the irradiance changes most over a
// triangle, which is at the edges of shadows.
std::vector<MeshPoint> hard_points(const LitScene& scene, std::size_t count) {
  std::mt19937_64 generator(11);
  const auto& triangles = scene.surface.triangles;
  std::vector<std::size_t> by_step(triangles.size());
  std::iota(by_step.begin(), by_step.end(), std::size_t{0});
  const auto step = [&](std::size_t t) {
    const auto& e = triangles[t].irradiance;
    return std::max({(e[0] - e[1]).norm(), (e[1] - e[2]).norm(), (e[2] - e[0]).norm()});
  };
  const std::size_t edges = std::min(triangles.size(), 20 * count);
  std::partial_sort(by_step.begin(), by_step.begin() + static_cast<std::ptrdiff_t>(edges), by_step.end(),
                    [&](std::size_t a, std::size_t b) { return step(a) > step(b); });
  std::vector<MeshPoint> points;
  for (std::size_t i = 0; i < 4 * count; ++i) {
    MeshPoint point{generator() % triangles.size(), random_barycentric(generator)};
    const auto corner = static_cast<Eigen::Index>(generator() % 3);
    if (i % 4 == 1) point.barycentric = Vec3d::Unit(corner);
    if (i % 4 == 2) point.barycentric[corner] = 0.0;
    if (i % 4 == 3) point.triangle = by_step[generator() % edges];
    point.barycentric /= point.barycentric.sum();
    points.push_back(point);
  }
  return points;
}

// The largest |fast - exact| in units of the largest irradiance; of the mass, of 1.
double largest_error(const TruthValues& fast, const TruthValues& exact, double light) {
  double worst = 0.0;
  for (std::size_t l = 0; l < exact.size(); ++l) {
    for (std::size_t i = 0; i < exact[l].size(); ++i) {
      const Vec4d error = (fast[l][i] - exact[l][i]).cwiseAbs();
      worst = std::max({worst, error.head<3>().maxCoeff() / light, error[3]});
    }
  }
  return worst;
}

void expect_tolerances_hold(const char* name, const LitScene& scene, std::size_t count) {
  const std::vector<MeshPoint> points = hard_points(scene, count);
  const double light = scene.surface.largest_irradiance();
  std::vector<SurfacePoint> euclidean;
  std::vector<GeodesicTarget> geodesic;
  for (const MeshPoint& point : points) {
    euclidean.push_back(scene.euclidean(point));
    geodesic.push_back(scene.geodesic(point));
  }
  const GeodesicSurface along = scene.geodesic_surface();
  const TruthValues exact = ExactEngine(scene.surface).convolve(euclidean, kLayers);
  const TruthValues exact_along = GeodesicExactEngine(along).convolve(geodesic, kLayers);
  for (const double tolerance : {1e-4, 1e-6}) {
    const double error =
        largest_error(FastEngine(scene.surface, tolerance).convolve(euclidean, kLayers), exact, light);
    const double error_along =
        largest_error(GeodesicFastEngine(along, tolerance).convolve(geodesic, kLayers), exact_along, light);
    std::printf("%s, %zu triangles, tolerance %.0e: Euclidean %.1e, geodesic %.1e\n", name,
                scene.surface.triangles.size(), tolerance, error, error_along);
    EXPECT_LE(error, tolerance) << name;
    EXPECT_LE(error_along, tolerance) << name;
  }
}

class Tolerance : public testing::TestWithParam<std::pair<const char*, BuiltinParameters>> {};

TEST_P(Tolerance, HoldsUnderALampFromTheSide) {
  const auto& [name, parameters] = GetParam();
  const LitScene scene(make_builtin(name, parameters), side_lamp(), {0.05, 1.0});
  expect_tolerances_hold(name, scene, scene.surface.triangles.size() < 5000 ? 32 : 8);
}

INSTANTIATE_TEST_SUITE_P(
    OnBuiltinScenes, Tolerance,
    testing::Values(
        std::pair("head", BuiltinParameters{{"edge_mm", 6.0}}),
        std::pair("sphere", BuiltinParameters{{"radius_mm", 12.0}, {"edge_mm", 2.5}}),
        std::pair("plane", BuiltinParameters{{"size_mm", 30.0}, {"edge_mm", 2.5}}),
        std::pair("wedge", BuiltinParameters{{"dihedral_deg", 250.0}, {"size_mm", 30.0}, {"edge_mm", 2.5}}),
        std::pair("slab", BuiltinParameters{{"size_mm", 30.0}, {"thickness_mm", 1.5}, {"edge_mm", 2.5}}),
        std::pair("tube", BuiltinParameters{{"radius_mm", 3.0}, {"length_mm", 30.0}, {"edge_mm", 1.5}}),
        std::pair("cards", BuiltinParameters{{"gap_mm", 2.0}, {"size_mm", 30.0}, {"edge_mm", 2.5}})),
    [](const auto& scene) { return std::string(scene.param.first); });

// No built-in scene is left out.
TEST(ToleranceScenes, AreAllThatThereAre) { EXPECT_EQ(builtin_scenes().size(), 7U); }

TEST(ToleranceScenes, OnTheScannedHead) {
  const char* const data = std::getenv("TRUESCATTER_DATA");
  const std::filesystem::path folder = data != nullptr
                                           ? std::filesystem::path(data)
                                           : std::filesystem::path(TRUESCATTER_SOURCE_DIR) / "../shared/data";
  const std::filesystem::path file = folder / "lps" / "lps_head.obj";
  if (!std::filesystem::exists(file))
    GTEST_SKIP() << "no lps/lps_head.obj under TRUESCATTER_DATA or beside the checkout";
  LoadOptions options;
  options.unit_mm = 1000.0;
  const LitScene scene(load_mesh(file, options), side_lamp(), {0.05, 1.0});
  expect_tolerances_hold("scanned head", scene, 8);
}

}  // namespace
}  // namespace truescatter
