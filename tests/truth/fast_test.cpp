#include "truth/fast.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/parallel.h"
#include "scene/builtin.h"
#include "support/random.h"
#include "truth/audit.h"
#include "truth/exact.h"
#include "truth/triangle_rules.h"

namespace truescatter {
namespace {

using test::uniform;

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

// A layer at 20 points of a rough plane, audited at the first 10 of them, 5 of these drawn at random.
class AuditOfALayer : public testing::Test {
 protected:
  Certificate certificate() const {
    const std::vector<SurfacePoint> audited(points_.begin(), points_.begin() + 10);
    const std::vector<std::uint32_t> indices = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    const TruthValues exact =
        ExactEngine(surface_, audit_reach_std_devs(engine_.tolerance())).convolve(audited, layer_);
    return audit(values_, exact[0], indices,
                 {engine_.tolerance(), engine_.tail_bound(), surface_.largest_irradiance(), 5});
  }

  const Surface surface_ = rough_surface(make_builtin("plane"), 3);
  const std::vector<SurfacePoint> points_ = random_points(surface_, 20, 5);
  const std::vector<TruthLayer> layer_ = {{1.0}};
  const FastEngine engine_{surface_, 1e-4};
  std::vector<Vec4d> values_ = engine_.convolve(points_, layer_)[0];
};

TEST_F(AuditOfALayer, PassesWhatKeepsItsPromise) {
  const Certificate good = certificate();
  EXPECT_TRUE(good.passed());
  EXPECT_EQ(good.audited, 10U);
  // 5 random points that all hold exclude, at 95 %, that more than 1 - 0.05^(1/5) = 45.07 % are worse.
  EXPECT_NEAR(good.open_share, 0.4507, 1e-4);
}

TEST_F(AuditOfALayer, FindsAWrongValue) {
  values_[7][1] += 2e-4 * surface_.largest_irradiance();
  const Certificate bad = certificate();
  EXPECT_FALSE(bad.passed());
  // The value is off by 2e-4, the engine by at most 1e-4; normalising may double it where the mass is one
  // half.
  EXPECT_GE(bad.max_error, 1e-4);
  EXPECT_LE(bad.max_error, 2.0 * 3e-4);
}

// Comparisons with what is not a number are false, so a maximum passes over it.
TEST_F(AuditOfALayer, FindsAValueThatIsNoNumber) {
  const Vec4d good = values_[7];
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int c = 0; c < 4; ++c) {
      values_[7] = good;
      values_[7][c] = wrong;
      EXPECT_FALSE(certificate().passed()) << c;
    }
  }
}

// The closed form must reach as far as the tolerance asks, or the audit blames the engine for its own tail.
TEST(Audit, PassesAtTheSmallestToleranceThatAnExperimentMayAsk) {
  const Surface surface = rough_surface(make_builtin("plane", {{"size_mm", 40.0}, {"edge_mm", 0.5}}), 3);
  std::vector<SurfacePoint> points = random_points(surface, 200, 5);
  std::erase_if(points, [](const SurfacePoint& p) { return p.position_mm.cwiseAbs().maxCoeff() > 10.0; });
  ASSERT_GE(points.size(), 10U);
  points.resize(10);
  const std::vector<TruthLayer> layer = {{1.3}};
  const FastEngine engine(surface, 1e-9);
  const std::vector<std::uint32_t> all = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const TruthValues values = engine.convolve(points, layer);
  const TruthValues exact = ExactEngine(surface, audit_reach_std_devs(1e-9)).convolve(points, layer);
  const Certificate certificate =
      audit(values[0], exact[0], all, {1e-9, engine.tail_bound(), surface.largest_irradiance(), 5});
  EXPECT_LE(certificate.max_error, 1e-9);
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

// The bound is about Taylor terms; here whole Gaussians are integrated over a plane of triangles as large as
// a budget allows, with the worst irradiance: at each corner 1 where that raises the error, else 0.
// So 4 deviations of one kink's error are never exceeded.
TEST(TriangleRules, AKinksLargestErrorIsAtMostFourDeviations) {
  for (const TriangleRule& rule : triangle_rules()) {
    EXPECT_LT(rule.kink_rms, rule.kink_error) << "degree " << rule.degree;
    EXPECT_LE(rule.kink_error, 4.0 * rule.kink_rms) << "degree " << rule.degree;
  }
}

TEST(TriangleRules, GaussianErrorBoundsAPlaneUnderTheWorstLight) {
  std::mt19937_64 generator(29);
  const HermiteMoments moments(0.0);
  for (const TriangleRule& rule : triangle_rules()) {
    for (const double budget : {6e-5, 6e-7}) {
      double radius = 3.0;
      while (gaussian_error(rule, moments, radius) > budget) radius *= 0.99;
      double worst = 0.0;
      for (int trial = 0; trial < 40; ++trial) {
        // Equilateral triangles of circumradius `radius`, sheared and turned, the Gaussian somewhere on them.
        const double side = radius * std::sqrt(3.0);
        const double shear = trial % 2 == 0 ? 0.0 : 0.3 * uniform(generator);
        const Vec2d a(side, 0.0);
        Vec2d b(side * (0.5 - shear), side * std::sqrt(0.75));
        b *= 1.0 - 0.5 * shear;
        const Vec2d offset = uniform(generator) * a + uniform(generator) * b;
        double error = 0.0;
        const int n = std::min(40, static_cast<int>(std::ceil(7.0 / side)) + 2);
        for (int i = -n; i <= n; ++i) {
          for (int j = -n; j <= n; ++j) {
            for (const bool upper : {false, true}) {
              const Vec2d o = i * a + j * b - offset;
              const std::array<Vec2d, 3> x = upper ? std::array<Vec2d, 3>{o + a + b, o + b, o + a}
                                                   : std::array<Vec2d, 3>{o, o + a, o + b};
              const Vec2d centroid = (x[0] + x[1] + x[2]) / 3.0;
              // The bound is stated for corners within `radius`: shrink by what the shear added.
              double farthest = 0.0;
              for (const Vec2d& corner : x) farthest = std::max(farthest, (corner - centroid).norm());
              const double shrink = radius / farthest;
              SurfaceTriangle triangle;
              for (std::size_t c = 0; c < 3; ++c)
                triangle.corners_mm[c] = Vec3d(x[c].x(), x[c].y(), 0.0) * shrink;
              const double area = triangle.area_mm2();
              Vec3d sum = Vec3d::Zero();
              for (const TriangleNode& node : rule.nodes) {
                const Vec3d at = node.barycentric[0] * triangle.corners_mm[0] +
                                 node.barycentric[1] * triangle.corners_mm[1] +
                                 node.barycentric[2] * triangle.corners_mm[2];
                sum +=
                    node.weight * area * std::exp(-0.5 * at.squaredNorm()) / (2.0 * kPi) * node.barycentric;
              }
              for (std::size_t c = 0; c < 3; ++c)
                triangle.irradiance[c] = Vec3d::Unit(static_cast<Eigen::Index>(c));
              const Vec4d exact = convolve_triangle_exact(triangle, Vec3d::Zero(), {1.0});
              for (Eigen::Index c = 0; c < 3; ++c) error += std::max(0.0, sum[c] - exact[c]);
            }
          }
        }
        worst = std::max(worst, error);
      }
      // Rounding of the closed form, of some 2000 triangles at the smallest radius: far below the budget.
      EXPECT_LE(worst, budget) << "degree " << rule.degree;
      // Not an idle bound: within a factor of 1000 of what happens.
      EXPECT_GE(worst, 1e-3 * budget) << "degree " << rule.degree;
    }
  }
}

}  // namespace
}  // namespace truescatter
