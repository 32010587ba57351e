#include "truth/brute.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/sampling.h"
#include "truth/exact.h"

namespace truescatter {
namespace {

using test::random_vec;
using test::uniform;

Surface random_soup(std::mt19937_64& generator, int count, double size) {
  Surface surface;
  for (int i = 0; i < count; ++i) {
    SurfaceTriangle triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      triangle.corners_mm[c] = random_vec(generator, size);
      triangle.irradiance[c] = 3.0 * random_vec(generator, 1.0).cwiseAbs();
    }
    surface.triangles.push_back(triangle);
  }
  return surface;
}

Vec3d point_on(const SurfaceTriangle& triangle, Vec3d b) {
  b /= b.sum();
  return b[0] * triangle.corners_mm[0] + b[1] * triangle.corners_mm[1] + b[2] * triangle.corners_mm[2];
}

// What the two may differ by: the quadrature's tolerance; the tail that is left out, tolerance/100 of a
// plane's mass, for each of `triangles` planes at most; and the closed form's rounding, some 1e-15 an edge.
void expect_agree(const Surface& surface, const Vec3d& point, const TruthLayer& layer, double tolerance,
                  double rounding = 1e-14) {
  const Vec4d exact = ExactEngine(surface).convolve({point, 0}, layer);
  const Vec4d brute = BruteEngine(surface, tolerance).convolve({point, 0}, layer);
  const auto triangles = static_cast<double>(surface.triangles.size());
  const double allowed = tolerance * (1.0 + 0.01 * triangles) + rounding * triangles;
  EXPECT_LE((brute - exact).head<3>().cwiseAbs().maxCoeff(), allowed * surface.largest_irradiance())
      << "s " << layer.std_dev_mm << " r_max " << layer.r_max_mm;
  EXPECT_LE(std::abs(brute[3] - exact[3]), allowed)
      << "s " << layer.std_dev_mm << " r_max " << layer.r_max_mm;
}

// Inside, on edges, at corners and off the surface; Gaussians from a twentieth to the size of the triangles.
TEST(BruteEngine, EqualsTheClosedFormOnRandomSoups) {
  std::mt19937_64 generator(3);
  for (int i = 0; i < 24; ++i) {
    const Surface surface = random_soup(generator, 10, 2.0);
    const double s = std::exp(uniform(generator, std::log(0.1), std::log(2.0)));
    const SurfaceTriangle& triangle = surface.triangles[static_cast<std::size_t>(i) % 10];
    Vec3d b = random_vec(generator, 1.0).cwiseAbs();
    if (i % 3 == 1) b[i % 9 / 3] = 0.0;
    if (i % 6 == 2) b = Vec3d::Unit(i % 3);
    const Vec3d point = i % 4 == 3 ? random_vec(generator, 2.0) : point_on(triangle, b);
    expect_agree(surface, point, {s}, i % 2 == 0 ? 1e-10 : 1e-12);
  }
}

// The cut sphere crosses triangles, lies within one, passes through a corner, touches a plane, and takes all.
TEST(BruteEngine, EqualsTheClosedFormWithACutOff) {
  std::mt19937_64 generator(5);
  for (int i = 0; i < 24; ++i) {
    const Surface surface = random_soup(generator, 10, 2.0);
    const SurfaceTriangle& triangle = surface.triangles[static_cast<std::size_t>(i) % 10];
    const Vec3d point = point_on(triangle, random_vec(generator, 1.0).cwiseAbs() + Vec3d::Constant(1e-3));
    const double to_corner = (triangle.corners_mm[static_cast<std::size_t>(i) % 3] - point).norm();
    const double s = std::exp(uniform(generator, std::log(0.2), std::log(2.0)));
    for (const double r_max : {0.05, uniform(generator, 0.1, 3.0), to_corner, 20.0}) {
      expect_agree(surface, point, {s, r_max}, i % 2 == 0 ? 1e-10 : 1e-12);
    }
  }
}

// From height h, the plane's mass within r_max is exp(-h^2/2s^2) - exp(-r_max^2/2s^2): here of two triangles
// of which the Gaussian is a hundredth.
TEST(BruteEngine, FindsASmallGaussianInALargeTriangle) {
  const double s = 0.1;
  const Vec3d one = Vec3d::Ones();
  Surface surface;
  surface.triangles.push_back(
      {{Vec3d(-10, -10, 0), Vec3d(10, -10, 0), Vec3d(10, 10, 0)}, {one, one, one}, 0});
  surface.triangles.push_back(
      {{Vec3d(-10, -10, 0), Vec3d(10, 10, 0), Vec3d(-10, 10, 0)}, {one, one, one}, 0});
  const BruteEngine brute(surface);
  for (const double h : {0.0, 0.07}) {
    const Vec3d point(3.21, -1.23, h);
    const double at_foot = std::exp(-0.5 * h * h / (s * s));
    EXPECT_NEAR(brute.convolve({point, 0}, {s})[3], at_foot, 1.1e-10);
    EXPECT_NEAR(brute.convolve({point, 0}, {s, 0.15})[0], at_foot - std::exp(-0.5 * 0.15 * 0.15 / (s * s)),
                1.1e-10);
  }
  EXPECT_EQ(brute.convolve({Vec3d(0, 0, 0.2), 0}, {s, 0.15}), Vec4d::Zero());
}

// A needle of 20 by 1e-4, and triangles without area. Irradiance changes by 1 over 1e-4, so the closed form's
// gradient term is 1e4 s times what it sums to, and its rounding with it.
TEST(BruteEngine, TakesSlivers) {
  Surface surface;
  const std::array<Vec3d, 3> light = {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};
  surface.triangles.push_back({{Vec3d(-10, 0, 0), Vec3d(10, 0, 0), Vec3d(10, 1e-4, 0)}, light, 0});
  surface.triangles.push_back({{Vec3d(-10, 0, 0), Vec3d(0, 0, 0), Vec3d(10, 0, 0)}, light, 0});
  surface.triangles.push_back({{Vec3d(1, 1, 0), Vec3d(1, 1, 0), Vec3d(1, 1, 0)}, light, 0});
  for (const double r_max : {0.9, 2.0, 100.0})
    expect_agree(surface, Vec3d::Zero(), {0.8, r_max}, 1e-12, 1e-14 * 1e4 * 0.8);
}

TEST(BruteEngine, StaysInItsComponent) {
  std::mt19937_64 generator(9);
  Surface surface = random_soup(generator, 4, 2.0);
  const Vec4d before = BruteEngine(surface).convolve({Vec3d::Zero(), 0}, {1.0});
  for (const SurfaceTriangle& t : random_soup(generator, 4, 2.0).triangles) {
    surface.triangles.push_back(t);
    surface.triangles.back().component = 1;
  }
  EXPECT_LT((BruteEngine(surface).convolve({Vec3d::Zero(), 0}, {1.0}) - before).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace truescatter
