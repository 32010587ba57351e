#include "truth/exact.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "support/sampling.h"

namespace truescatter {
namespace {

using test::random_triangle;
using test::random_vec;
using test::uniform;

// Gauss-Legendre nodes on [0, 1] by Newton's method on the Legendre polynomial: independent of all code under
// test.
struct Node {
  double x;
  double w;
};
std::vector<Node> gauss_legendre(int n) {
  std::vector<Node> nodes;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5));
    double derivative = 1.0;
    for (int iteration = 0; iteration < 50; ++iteration) {
      double p0 = 1.0;
      double p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      derivative = n * (x * p1 - p0) / (x * x - 1.0);
      x -= p1 / derivative;
    }
    nodes.push_back({0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * derivative * derivative)});
  }
  return nodes;
}

// The plain integral by a product rule on the square, folded onto the triangle (Duffy), on 4^level parts.
Vec4d brute_force(const SurfaceTriangle& t, const Vec3d& point, double s, const std::vector<Node>& rule,
                  int level) {
  if (level > 0) {
    Vec4d sum = Vec4d::Zero();
    const auto mid = [](const auto& v, int i, int j) {
      return Vec3d(0.5 * (v[static_cast<std::size_t>(i)] + v[static_cast<std::size_t>(j)]));
    };
    const auto& x = t.corners_mm;
    const auto& e = t.irradiance;
    const std::array<Vec3d, 3> xm = {mid(x, 0, 1), mid(x, 1, 2), mid(x, 2, 0)};
    const std::array<Vec3d, 3> em = {mid(e, 0, 1), mid(e, 1, 2), mid(e, 2, 0)};
    sum += brute_force({{x[0], xm[0], xm[2]}, {e[0], em[0], em[2]}, 0}, point, s, rule, level - 1);
    sum += brute_force({{xm[0], x[1], xm[1]}, {em[0], e[1], em[1]}, 0}, point, s, rule, level - 1);
    sum += brute_force({{xm[2], xm[1], x[2]}, {em[2], em[1], e[2]}, 0}, point, s, rule, level - 1);
    sum += brute_force({{xm[0], xm[1], xm[2]}, {em[0], em[1], em[2]}, 0}, point, s, rule, level - 1);
    return sum;
  }
  Vec4d sum = Vec4d::Zero();
  for (const Node& a : rule) {
    for (const Node& b : rule) {
      const double u = a.x;
      const double v = b.x * (1.0 - a.x);
      const Vec3d x = (1.0 - u - v) * t.corners_mm[0] + u * t.corners_mm[1] + v * t.corners_mm[2];
      const Vec3d e = (1.0 - u - v) * t.irradiance[0] + u * t.irradiance[1] + v * t.irradiance[2];
      const double g = std::exp(-(x - point).squaredNorm() / (2 * s * s)) / (2 * kPi * s * s);
      const double weight = 2.0 * t.area_mm2() * a.w * b.w * (1.0 - a.x) * g;
      sum += weight * Vec4d(e.x(), e.y(), e.z(), 1.0);
    }
  }
  return sum;
}

// The reference's own error: its difference from a coarser rule on the same parts, which bounds it
// generously.
TEST(ExactTriangle, EqualsBruteForceOnRandomTriangles) {
  std::mt19937_64 generator(7);
  const std::vector<Node> fine = gauss_legendre(30);
  const std::vector<Node> coarse = gauss_legendre(24);
  for (int i = 0; i < 200; ++i) {
    const SurfaceTriangle triangle = random_triangle(generator, 2.0);
    const double s = std::exp(uniform(generator, std::log(0.3), std::log(3.0)));
    Vec3d point = random_vec(generator, 2.5);
    // Every other point lies on the triangle, some of them on its edges and corners.
    if (i % 2 == 0) {
      Vec3d b = random_vec(generator, 1.0).cwiseAbs();
      if (i % 3 == 0) b[i % 9 / 3] = 0.0;
      if (i % 10 == 0) b = Vec3d::Unit(i % 3);
      b /= b.sum();
      point = b[0] * triangle.corners_mm[0] + b[1] * triangle.corners_mm[1] + b[2] * triangle.corners_mm[2];
    }
    const Vec4d expected = brute_force(triangle, point, s, fine, 3);
    const double reference_error =
        (expected - brute_force(triangle, point, s, coarse, 3)).cwiseAbs().maxCoeff();
    const Vec4d value = convolve_triangle_exact(triangle, point, {s});
    EXPECT_LT((value - expected).cwiseAbs().maxCoeff(), 1e-11 + reference_error)
        << "triangle " << i << " s " << s;
  }
}

TEST(ExactTriangle, OrderOfCornersDoesNotMatter) {
  std::mt19937_64 generator(11);
  for (int i = 0; i < 50; ++i) {
    const SurfaceTriangle t = random_triangle(generator, 2.0);
    const SurfaceTriangle flipped{{t.corners_mm[0], t.corners_mm[2], t.corners_mm[1]},
                                  {t.irradiance[0], t.irradiance[2], t.irradiance[1]},
                                  0};
    const Vec3d point = random_vec(generator, 2.0);
    const TruthLayer layer{0.8, i % 2 == 0 ? 1.5 : std::numeric_limits<double>::infinity()};
    EXPECT_LT(
        (convolve_triangle_exact(t, point, layer) - convolve_triangle_exact(flipped, point, layer)).norm(),
        1e-12);
  }
}

TEST(ExactTriangle, CutOffIsAdditiveOverSubdivision) {
  // A triangle and its four parts, which the cut-off sphere crosses elsewhere, give one value.
  std::mt19937_64 generator(13);
  for (int i = 0; i < 100; ++i) {
    const SurfaceTriangle t = random_triangle(generator, 2.0);
    const Vec3d point = random_vec(generator, 2.0);
    const TruthLayer layer{1.1, uniform(generator, 0.5, 3.0)};
    const auto& x = t.corners_mm;
    const auto& e = t.irradiance;
    const std::array<Vec3d, 3> xm = {0.5 * (x[0] + x[1]), 0.5 * (x[1] + x[2]), 0.5 * (x[2] + x[0])};
    const std::array<Vec3d, 3> em = {0.5 * (e[0] + e[1]), 0.5 * (e[1] + e[2]), 0.5 * (e[2] + e[0])};
    Vec4d parts = convolve_triangle_exact({{x[0], xm[0], xm[2]}, {e[0], em[0], em[2]}, 0}, point, layer);
    parts += convolve_triangle_exact({{xm[0], x[1], xm[1]}, {em[0], e[1], em[1]}, 0}, point, layer);
    parts += convolve_triangle_exact({{xm[2], xm[1], x[2]}, {em[2], em[1], e[2]}, 0}, point, layer);
    parts += convolve_triangle_exact({{xm[0], xm[1], xm[2]}, {em[0], em[1], em[2]}, 0}, point, layer);
    EXPECT_LT((convolve_triangle_exact(t, point, layer) - parts).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(ExactTriangle, WithoutAreaIsZero) {
  const SurfaceTriangle line{
      {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(2, 0, 0)}, {Vec3d::Ones(), Vec3d::Ones(), Vec3d::Ones()}, 0};
  EXPECT_EQ(convolve_triangle_exact(line, Vec3d(0.5, 0.1, 0.0), {1.0}), Vec4d::Zero());
}

// A sheet of 9 x 9 cells of about 1 mm with random heights and irradiance, seen from points on it.
Surface random_sheet(std::mt19937_64& generator) {
  constexpr int kCells = 9;
  std::vector<Vec3d> x;
  std::vector<Vec3d> e;
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      x.emplace_back(Vec3d(i, j, 0.0) + random_vec(generator, 0.3));
      e.emplace_back(random_vec(generator, 1.0).cwiseAbs());
    }
  }
  Surface sheet;
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      const auto a = static_cast<std::size_t>(j * (kCells + 1) + i);
      const std::size_t b = a + 1;
      const std::size_t c = a + kCells + 1;
      const std::size_t d = c + 1;
      sheet.triangles.push_back({{x[a], x[b], x[d]}, {e[a], e[b], e[d]}, 0});
      sheet.triangles.push_back({{x[a], x[d], x[c]}, {e[a], e[d], e[c]}, 0});
    }
  }
  return sheet;
}

// The engine's reach leaves out at most 9e-17 of a plane's mass, and 162 triangles round by 1e-16 each.
TEST(ExactEngine, EqualsBruteForceOnARandomMesh) {
  std::mt19937_64 generator(19);
  const std::vector<Node> fine = gauss_legendre(24);
  const std::vector<Node> coarse = gauss_legendre(18);
  for (int mesh = 0; mesh < 3; ++mesh) {
    const Surface sheet = random_sheet(generator);
    const ExactEngine engine(sheet);
    for (const double s : {0.3, 0.9, 2.5}) {
      for (int i = 0; i < 4; ++i) {
        const SurfaceTriangle& t = sheet.triangles[generator() % sheet.triangles.size()];
        Vec3d b = random_vec(generator, 1.0).cwiseAbs();
        b /= b.sum();
        const Vec3d point = b[0] * t.corners_mm[0] + b[1] * t.corners_mm[1] + b[2] * t.corners_mm[2];
        Vec4d expected = Vec4d::Zero();
        Vec4d rough = Vec4d::Zero();
        for (const SurfaceTriangle& triangle : sheet.triangles) {
          expected += brute_force(triangle, point, s, fine, 1);
          rough += brute_force(triangle, point, s, coarse, 1);
        }
        const double reference_error = (expected - rough).cwiseAbs().maxCoeff();
        EXPECT_LT(reference_error, 1e-10);
        EXPECT_LT((engine.convolve({point, 0}, {s}) - expected).cwiseAbs().maxCoeff(),
                  1e-11 + reference_error)
            << "mesh " << mesh << " s " << s;
      }
    }
  }
}

TEST(ExactEngine, StaysInItsComponent) {
  std::mt19937_64 generator(17);
  Surface surface;
  for (int i = 0; i < 40; ++i) {
    surface.triangles.push_back(random_triangle(generator, 2.0));
    surface.triangles.back().component = i % 2;
  }
  Surface even;
  for (const SurfaceTriangle& t : surface.triangles) {
    if (t.component == 0) even.triangles.push_back(t);
  }
  const SurfacePoint point{Vec3d(0.1, 0.2, 0.3), 0};
  EXPECT_LT((ExactEngine(surface).convolve(point, {1.0}) - ExactEngine(even).convolve(point, {1.0})).norm(),
            1e-14);
}

}  // namespace
}  // namespace truescatter
