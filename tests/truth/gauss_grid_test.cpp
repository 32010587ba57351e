#include "truth/gauss_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/parallel.h"
#include "support/random.h"

namespace truescatter {
namespace {

using test::uniform;

// Sources on a sphere of radius 5 mm whose areas sum to its own, with irradiance up to 1; points on it too.
struct Fixture {
  std::vector<GaussSource> sources;
  std::vector<Vec3d> points;

  explicit Fixture(bool gray) {
    std::mt19937_64 generator(7);
    const auto on_sphere = [&] {
      const double z = 2.0 * uniform(generator) - 1.0;
      const double phi = 2.0 * kPi * uniform(generator);
      const double rho = std::sqrt(1.0 - z * z);
      return Vec3d(5.0 * rho * std::cos(phi) + 100.0, 5.0 * rho * std::sin(phi) - 40.0, 5.0 * z);
    };
    constexpr int kSources = 4000;
    const double area = 4.0 * kPi * 25.0 / kSources;
    for (int i = 0; i < kSources; ++i) {
      Vec3d irradiance(uniform(generator), uniform(generator), uniform(generator));
      if (gray) irradiance = Vec3d::Constant(irradiance.x());
      sources.push_back(
          {on_sphere(), {area * irradiance.x(), area * irradiance.y(), area * irradiance.z(), area}});
    }
    for (int i = 0; i < 300; ++i) points.push_back(on_sphere());
  }
};

Vec4d direct_sum(const std::vector<GaussSource>& sources, const Vec3d& point, double s) {
  Vec4d sum = Vec4d::Zero();
  for (const GaussSource& source : sources) {
    const double r2 = (source.position_mm - point).squaredNorm();
    sum += source.weight * std::exp(-0.5 * r2 / (s * s)) / (2.0 * kPi * s * s);
  }
  return sum;
}

template <typename Scalar>
void expect_sums(bool gray, double budget, double rounding) {
  const Fixture fixture(gray);
  // Much smaller than the sphere, and so large that the whole sphere is in reach.
  for (const double s : {0.3, 1.0, 4.0}) {
    std::vector<Vec4d> sums(fixture.points.size(), Vec4d::Zero());
    add_gauss_sums<Scalar>(GaussLattice(s, budget), s, fixture.sources, fixture.points, gray, sums);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const Vec4d expected = direct_sum(fixture.sources, fixture.points[i], s);
      // The bound is relative to a plane of mass 1; random sources give up to `mass` of it here and there.
      const double mass = std::max(1.0, expected[3]);
      EXPECT_LE((sums[i] - expected).cwiseAbs().maxCoeff(), (budget + rounding) * mass)
          << "s " << s << " budget " << budget << " point " << i;
    }
  }
}

// Rounding: products of three kernels, a sum of a few thousand positive terms in bundles, and positions known
// to one unit in the last place of a cell's 5 s: a dozen units in the last place.
TEST(GaussGrid, MeetsItsBudgetInSinglePrecision) {
  for (const bool gray : {false, true}) {
    expect_sums<float>(gray, 1e-3, 1e-6);
    expect_sums<float>(gray, 1e-5, 1e-6);
  }
}

TEST(GaussGrid, MeetsItsBudgetInDoublePrecision) {
  for (const bool gray : {false, true}) {
    expect_sums<double>(gray, 1e-7, 1e-14);
    expect_sums<double>(gray, 1e-10, 1e-14);
  }
}

// The budget is spent, not a bound that anything would meet.
TEST(GaussGrid, ErrsByAboutItsBudget) {
  const Fixture fixture(true);
  std::vector<Vec4d> sums(fixture.points.size(), Vec4d::Zero());
  add_gauss_sums<double>(GaussLattice(1.0, 1e-3), 1.0, fixture.sources, fixture.points, true, sums);
  double worst = 0.0;
  for (std::size_t i = 0; i < sums.size(); ++i)
    worst = std::max(worst,
                     (sums[i] - direct_sum(fixture.sources, fixture.points[i], 1.0)).cwiseAbs().maxCoeff());
  EXPECT_GT(worst, 1e-5);
}

TEST(GaussGrid, SameBitsForAnyNumberOfJobs) {
  const Fixture fixture(false);
  const auto run = [&](int jobs) {
    const JobLimit limit(jobs);
    std::vector<Vec4d> sums(fixture.points.size(), Vec4d::Zero());
    add_gauss_sums<float>(GaussLattice(0.5, 1e-5), 0.5, fixture.sources, fixture.points, false, sums);
    return sums;
  };
  const std::vector<Vec4d> one = run(1);
  const std::vector<Vec4d> two = run(2);
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i], two[i]);
}

TEST(GaussGrid, NothingToSumIsNothing) {
  const Fixture fixture(true);
  std::vector<Vec4d> none;
  add_gauss_sums<float>(GaussLattice(1.0, 1e-5), 1.0, fixture.sources, {}, true, none);
  std::vector<Vec4d> sums(fixture.points.size(), Vec4d::Zero());
  add_gauss_sums<float>(GaussLattice(1.0, 1e-5), 1.0, {}, fixture.points, true, sums);
  for (const Vec4d& sum : sums) EXPECT_EQ(sum, Vec4d(Vec4d::Zero()));
}

}  // namespace
}  // namespace truescatter
