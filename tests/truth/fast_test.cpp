#include "truth/fast.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/parallel.h"
#include "scene/builtin.h"
#include "truth/audit.h"
#include "truth/exact.h"
#include "truth/triangle_rules.h"

namespace truescatter {
namespace {

double uniform(std::mt19937_64& generator) { return static_cast<double>(generator() >> 11U) * 0x1.0p-53; }

// A scene as a soup with rough irradiance: large random values at its vertices, so that every triangle has a
// steep gradient.
Surface rough_surface(const Mesh& mesh, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<Vec3d> value(mesh.positions_mm.size());
  for (Vec3d& v : value) v = Vec3d(uniform(generator), uniform(generator), uniform(generator));
  Surface surface;
  for (const auto& t : mesh.triangles) {
    SurfaceTriangle triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      triangle.corners_mm[c] = mesh.positions_mm[static_cast<std::size_t>(t[c])];
      triangle.irradiance[c] = value[static_cast<std::size_t>(t[c])];
    }
    surface.triangles.push_back(triangle);
  }
  return surface;
}

std::vector<SurfacePoint> random_points(const Surface& surface, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const SurfaceTriangle& t = surface.triangles[generator() % surface.triangles.size()];
    Vec3d b(uniform(generator), uniform(generator), uniform(generator));
    if (i % 5 == 0) b[static_cast<Eigen::Index>(i % 3)] = 0.0;           // on an edge
    if (i % 11 == 0) b = Vec3d::Unit(static_cast<Eigen::Index>(i % 3));  // on a vertex
    b /= b.sum();
    points.push_back({b[0] * t.corners_mm[0] + b[1] * t.corners_mm[1] + b[2] * t.corners_mm[2], t.component});
  }
  return points;
}

const std::vector<TruthLayer>& layers() {
  static const std::vector<TruthLayer> all = {{0.08}, {0.22},        {0.75},        {1.5166},
                                              {2.72}, {1.0488, 4.5}, {1.5166, 4.5}, {2.72, 8.1663}};
  return all;
}

class FastAgainstExact : public testing::TestWithParam<const char*> {};

TEST_P(FastAgainstExact, HoldsItsTolerance) {
  const Surface surface = rough_surface(make_builtin(GetParam()), 3);
  const std::vector<SurfacePoint> points = random_points(surface, 150, 5);
  const TruthValues exact = ExactEngine(surface).convolve(points, layers());
  const double largest = surface.largest_irradiance();
  for (const double tolerance : {1e-4, 1e-6}) {
    const TruthValues fast = FastEngine(surface, tolerance).convolve(points, layers());
    for (std::size_t l = 0; l < layers().size(); ++l) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LE((fast[l][i] - exact[l][i]).head<3>().cwiseAbs().maxCoeff(), tolerance * largest)
            << "s " << layers()[l].std_dev_mm << " r_max " << layers()[l].r_max_mm << " tolerance "
            << tolerance;
        EXPECT_LE(std::abs(fast[l][i][3] - exact[l][i][3]), tolerance);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, FastAgainstExact,
                         testing::Values("sphere", "plane", "wedge", "slab", "tube", "cards", "head"));

TEST(FastEngine, SameBitsForAnyNumberOfJobs) {
  const Surface surface = rough_surface(make_builtin("tube"), 3);
  const std::vector<SurfacePoint> points = random_points(surface, 3000, 9);
  const FastEngine engine(surface, 1e-4);
  const auto run = [&](int jobs) {
    const JobLimit limit(jobs);
    return engine.convolve(points, layers());
  };
  const TruthValues one = run(1);
  const TruthValues two = run(2);
  for (std::size_t l = 0; l < layers().size(); ++l) {
    for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(one[l][i], two[l][i]);
  }
}

TEST(FastEngine, MassOfAPlaneIsOne) {
  Mesh plane = make_builtin("plane");
  const Surface surface = rough_surface(plane, 3);
  const SurfacePoint middle{Vec3d(0.3, 0.1, 0.0), 0};
  const std::vector<TruthLayer> wanted = {{0.08}, {0.75}, {2.72}};
  const TruthValues values = FastEngine(surface, 1e-4).convolve(std::span(&middle, 1), wanted);
  for (const auto& layer : values) EXPECT_NEAR(layer[0][3], 1.0, 1e-4);
}

TEST(Audit, FindsAWrongValue) {
  const Surface surface = rough_surface(make_builtin("plane"), 3);
  const std::vector<SurfacePoint> points = random_points(surface, 20, 5);
  const std::vector<TruthLayer> layer = {{1.0}};
  const FastEngine engine(surface, 1e-4);
  TruthValues values = engine.convolve(points, layer);
  const std::vector<std::uint32_t> all = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const Certificate good = audit(surface, points, layer, values, 1e-4, engine.tail_bound(), all, 5);
  EXPECT_TRUE(good.passed());
  EXPECT_EQ(good.audited, 10U);
  // 5 random points that all hold exclude, at 95 %, that more than 1 - 0.05^(1/5) = 45.07 % are worse.
  EXPECT_NEAR(good.open_share, 0.4507, 1e-4);
  values[0][7][1] += 2e-4 * surface.largest_irradiance();
  const Certificate bad = audit(surface, points, layer, values, 1e-4, engine.tail_bound(), all, 5);
  EXPECT_FALSE(bad.passed());
  // The value is off by 2e-4, the engine by at most 1e-4; normalising may double it where the mass is one
  // half.
  EXPECT_GE(bad.max_error, 1e-4);
  EXPECT_LE(bad.max_error, 2.0 * 3e-4);
}

TEST(TriangleRules, IntegrateMonomialsUpToTheirDegree) {
  for (const TriangleRule& rule : triangle_rules()) {
    for (int i = 0; i <= rule.degree; ++i) {
      for (int j = 0; i + j <= rule.degree; ++j) {
        double sum = 0.0;
        for (const TriangleNode& node : rule.nodes) {
          sum += node.weight * std::pow(node.barycentric[1], i) * std::pow(node.barycentric[2], j);
        }
        // Mean of x^i y^j over the unit triangle: 2 i! j! / (i + j + 2)!.
        const double expected = 2.0 * std::tgamma(i + 1.0) * std::tgamma(j + 1.0) / std::tgamma(i + j + 3.0);
        // The rules' coordinates are given to 15 digits; 16 nodes add their rounding.
        EXPECT_NEAR(sum, expected, 1e-14) << "degree " << rule.degree << " x^" << i << " y^" << j;
      }
    }
  }
}

TEST(TriangleRules, RemainderBoundsEveryShape) {
  std::mt19937_64 generator(23);
  for (const TriangleRule& rule : triangle_rules()) {
    double largest = 0.0;
    for (int i = 0; i < 400; ++i) {
      // The first is equilateral; the others are random, many of them thin.
      std::array<Vec2d, 3> corner = {Vec2d(0.0, 0.0), Vec2d(1.0, 0.0), Vec2d(0.5, std::sqrt(0.75))};
      const double squeeze = std::pow(10.0, -3.0 * uniform(generator));
      for (Vec2d& c : corner) {
        if (i > 0) c = Vec2d(uniform(generator), squeeze * uniform(generator));
      }
      const Vec2d centroid = (corner[0] + corner[1] + corner[2]) / 3.0;
      double radius = 0.0;
      for (const Vec2d& c : corner) radius = std::max(radius, (c - centroid).norm());
      const auto rho = [&](const Vec3d& b) {
        return (b[0] * corner[0] + b[1] * corner[1] + b[2] * corner[2] - centroid).norm() / radius;
      };
      double sum = 0.0;
      for (const TriangleNode& node : rule.nodes)
        sum += node.weight * std::pow(rho(node.barycentric), rule.degree);
      // The exact mean by midpoints of n^2 parts: O(n^-2) of a value below 1, 1e-4 for n = 40.
      const int n = 40;
      double mean = 0.0;
      for (int a = 0; a < n; ++a) {
        for (int b = 0; a + b < n; ++b) {
          mean += std::pow(rho(Vec3d(a + 1.0 / 3, b + 1.0 / 3, n - a - b - 2.0 / 3) / n), rule.degree);
          if (a + b + 1 < n)
            mean += std::pow(rho(Vec3d(a + 2.0 / 3, b + 2.0 / 3, n - a - b - 4.0 / 3) / n), rule.degree);
        }
      }
      largest = std::max(largest, sum + mean / (n * n));
    }
    EXPECT_LE(largest, rule.remainder + 2e-4) << rule.degree;
    EXPECT_GE(largest, rule.remainder - 2e-4) << rule.degree;
  }
}

}  // namespace
}  // namespace truescatter
