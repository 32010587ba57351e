#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "methods/screen_octree/sample_octree.h"
#include "support/plane_frame.h"
#include "support/render.h"
#include "support/sampling.h"

namespace truescatter {
namespace {

using test::Scene;

std::vector<SurfaceSample> random_samples(std::size_t count) {
  std::mt19937_64 generator(7);
  std::vector<SurfaceSample> samples(count);
  for (SurfaceSample& sample : samples) {
    sample.position_mm = test::random_vec(generator, 10.0);
    sample.irradiance = test::random_vec(generator, 1.0).cwiseAbs();
    sample.area_mm2 = test::uniform(generator, 0.01, 0.02);
  }
  return samples;
}

struct Gathered {
  int visited = 0;
  double area_mm2 = 0.0;
  Vec3d light = Vec3d::Zero();  // times exp(-r^2 / 2 (4 mm)^2)
};

Gathered gather(const SampleOctree& tree, const Vec3d& from, double reach_mm, double solid_angle) {
  Gathered sum;
  tree.gather(from, reach_mm, solid_angle, [&](const SurfaceSample& sample) {
    ++sum.visited;
    sum.area_mm2 += sample.area_mm2;
    sum.light +=
        sample.area_mm2 * std::exp(-(sample.position_mm - from).squaredNorm() / 32.0) * sample.irradiance;
  });
  return sum;
}

// Without a bound every sample counts by itself; with one their area is kept, by far fewer visits, and the
// sum comes nearer as the bound falls. 5000 additions in double precision: 5000 * 1.1e-16 of the sum, at
// most 75.
TEST(SampleOctree, GathersWhatIsThere) {
  const std::vector<SurfaceSample> samples = random_samples(5000);
  const SampleOctree tree(samples);
  const Vec3d from(3.0, -2.0, 1.0);
  Gathered all;
  for (const SurfaceSample& sample : samples) {
    all.area_mm2 += sample.area_mm2;
    all.light +=
        sample.area_mm2 * std::exp(-(sample.position_mm - from).squaredNorm() / 32.0) * sample.irradiance;
  }
  const Gathered each = gather(tree, from, 1e9, 0.0);
  EXPECT_EQ(each.visited, 5000);
  EXPECT_LT((each.light - all.light).norm(), 1e-10);
  double last = std::numeric_limits<double>::infinity();
  for (const double solid_angle : {0.5, 0.05, 0.005}) {
    const Gathered some = gather(tree, from, 1e9, solid_angle);
    EXPECT_LT(some.visited, 5000) << solid_angle;
    EXPECT_NEAR(some.area_mm2, all.area_mm2, 1e-10);
    const double error = (some.light - all.light).norm();
    EXPECT_LT(error, last) << solid_angle;
    last = error;
  }
  EXPECT_LT(gather(tree, from, 1e9, 0.5).visited, 1000);
}

// What is passed over lies beyond the reach.
TEST(SampleOctree, FindsAllWithinReach) {
  const std::vector<SurfaceSample> samples = random_samples(5000);
  const Vec3d from(9.0, 9.0, -9.0);
  constexpr double kReachMm = 3.0;
  double within_mm2 = 0.0;
  for (const SurfaceSample& sample : samples)
    within_mm2 += (sample.position_mm - from).norm() <= kReachMm ? sample.area_mm2 : 0.0;
  double found_mm2 = 0.0;
  SampleOctree(samples).gather(from, kReachMm, 0.0, [&](const SurfaceSample& sample) {
    if ((sample.position_mm - from).norm() <= kReachMm) found_mm2 += sample.area_mm2;
  });
  EXPECT_GT(within_mm2, 0.1);
  EXPECT_NEAR(found_mm2, within_mm2, 1e-12);
}

TEST(SampleOctree, HoldsEqualPointsAndNone) {
  std::vector<SurfaceSample> same(100, SurfaceSample{Vec3d::Ones(), Vec3d::Ones(), 1.0});
  EXPECT_EQ(gather(SampleOctree(same), Vec3d::Ones(), 1.0, 0.05).visited, 100);
  EXPECT_EQ(gather(SampleOctree({}), Vec3d::Ones(), 1.0, 0.05).visited, 0);
}

// A slab 2 mm thick, its front lit and its back dark: away from its rim a point of the front gets 1 from the
// front and 0 from the back, whose weight is exp(-t^2 / 2 s^2) of the front's, s = 1.5 mm: 1 / (1 + exp(-t^2
// / 2 s^2)) = 0.7086. Pixels of 0.25 mm: the sum over pixels is the integral to rounding; beyond 5.5 s lies
// 3e-7; perspective samples the back more coarsely by t / D, which changes nothing. Single precision
// positions at 300 mm: 2e-5 mm of s: 2e-5.
TEST(ScreenOctree, SeesTheBackOfASlab) {
  constexpr double kThicknessMm = 2.0;
  constexpr double kStdDevMm = 1.5;
  ShadingMesh shading = test::shade(make_builtin("slab", {{"size_mm", 60.0}, {"thickness_mm", kThicknessMm}}),
                                    test::lamp(Vec3d::UnitZ()));
  for (ShadingTriangle& triangle : shading.triangles) {
    bool front = true;
    for (std::size_t c = 0; c < 3; ++c)
      front = front && shading.corner(triangle, c).z() > 0.999 * kThicknessMm / 2.0;
    for (Vec3d& value : triangle.irradiance) value = front ? Vec3d::Ones() : Vec3d::Zero();
  }
  const Scene scene(std::move(shading), test::camera_at(300.0, 24.0, 96));
  const Image result =
      scene.run(find_method("screen-octree"), test::one_gaussian(kStdDevMm, 9.0), {{"solid_angle", 0.0}});
  const double truth = 1.0 / (1.0 + std::exp(-kThicknessMm * kThicknessMm / (2.0 * kStdDevMm * kStdDevMm)));
  for (int y = 44; y < 52; ++y) {
    for (int x = 44; x < 52; ++x) EXPECT_NEAR(result.at(x, y, 0), truth, 3e-5) << x << " " << y;
  }
}

}  // namespace
}  // namespace truescatter
