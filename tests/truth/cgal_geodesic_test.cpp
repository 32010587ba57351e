#include "truth/cgal_geodesic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "scene/mesh.h"
#include "support/error_of.h"
#include "support/random.h"

namespace truescatter {
namespace {

// Barycentrics are raised to 1e-12, so points move by that share of an edge; the rest is rounding.
constexpr double kAllowed = 1e-11;

using test::uniform;

MeshPoint random_point(std::mt19937_64& generator, const Mesh& mesh) {
  MeshPoint point{generator() % mesh.triangles.size(), {}};
  for (double& b : point.barycentric) b = uniform(generator);
  point.barycentric /= point.barycentric.sum();
  return point;
}

// (cells x cells) squares of the plane, at z(x, y); the corners of every triangle turned by its index.
template <typename Height>
Mesh sheet(int cells, double size, const Height& z) {
  Mesh mesh;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const double x = size * i / cells;
      const double y = size * j / cells;
      mesh.positions_mm.emplace_back(x, y, z(x, y));
    }
  }
  const auto add = [&](int a, int b, int c) {
    std::array<int, 3> triangle = {a, b, c};
    std::rotate(triangle.begin(), triangle.begin() + static_cast<std::ptrdiff_t>(mesh.triangles.size() % 3),
                triangle.end());
    mesh.triangles.push_back(triangle);
  };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i;
      add(a, a + 1, a + cells + 2);
      add(a, a + cells + 2, a + cells + 1);
    }
  }
  return mesh;
}

TEST(CgalGeodesics, OnAPlaneIsEuclidean) {
  std::mt19937_64 generator(1);
  const Mesh mesh = sheet(5, 3.0, [](double x, double y) { return 0.5 * x - 0.2 * y; });
  const CgalGeodesics geodesics(mesh.positions_mm, mesh.triangles);
  for (int i = 0; i < 12; ++i) {
    MeshPoint source = random_point(generator, mesh);
    if (i % 3 == 1) source.barycentric = {0.3, 0.0, 0.7};  // on an edge
    if (i % 3 == 2) source.barycentric = {0.0, 1.0, 0.0};  // at a vertex
    std::vector<MeshPoint> targets;
    for (int k = 0; k < 40; ++k) targets.push_back(random_point(generator, mesh));
    const std::vector<double> found = geodesics.distances_mm(source, targets);
    for (std::size_t k = 0; k < targets.size(); ++k) {
      EXPECT_NEAR(found[k], (position_mm(mesh, source) - position_mm(mesh, targets[k])).norm(), kAllowed);
    }
  }
}

// The corner of a cube, three unit squares that meet at the origin; by hand, each unfolded onto the next.
TEST(CgalGeodesics, UnfoldsACube) {
  Mesh mesh;
  mesh.positions_mm = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, -1}, {1, 0, -1}, {0, 1, -1}};
  mesh.triangles = {{0, 1, 2}, {2, 3, 0}, {5, 1, 0}, {5, 0, 4}, {0, 3, 6}, {4, 0, 6}};
  const CgalGeodesics geodesics(mesh.positions_mm, mesh.triangles);
  const MeshPoint source{0, {0.2, 0.5, 0.3}};                     // (0.8, 0.3, 0)
  const std::vector<MeshPoint> targets = {{2, {0.5, 0.3, 0.2}},   // (0.8, 0, -0.5)
                                          {3, {0.1, 0.6, 0.3}},   // (0.1, 0, -0.4)
                                          {4, {0.2, 0.5, 0.3}}};  // (0, 0.8, -0.3)
  const std::vector<double> found = geodesics.distances_mm(source, targets);
  EXPECT_NEAR(found[0], 0.8, kAllowed);                         // straight down: 0.3 + 0.5
  EXPECT_NEAR(found[1], std::hypot(0.8 - 0.1, 0.7), kAllowed);  // y turns into depth: 0.3 + 0.4
  EXPECT_NEAR(found[2], std::hypot(0.8 + 0.3, 0.5), kAllowed);  // x turns into depth
}

// Around the inner corner of an L the path bends: two straight pieces.
TEST(CgalGeodesics, BendsAroundACorner) {
  Mesh mesh;
  mesh.positions_mm = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0},
                       {1, 1, 0}, {2, 1, 0}, {0, 2, 0}, {1, 2, 0}};
  mesh.triangles = {{0, 1, 4}, {4, 3, 0}, {1, 2, 5}, {5, 4, 1}, {3, 4, 7}, {7, 6, 3}};
  const CgalGeodesics geodesics(mesh.positions_mm, mesh.triangles);
  const MeshPoint source{2, {0.1, 0.2, 0.7}};
  const std::vector<MeshPoint> targets = {{5, {0.6, 0.3, 0.1}}};
  const Vec3d corner(1, 1, 0);
  EXPECT_NEAR(geodesics.distances_mm(source, targets)[0],
              (position_mm(mesh, source) - corner).norm() + (position_mm(mesh, targets[0]) - corner).norm(),
              kAllowed);
}

// Symmetric, at least Euclidean, and no longer than by way of a third point.
TEST(CgalGeodesics, IsADistanceOnABumpySheet) {
  std::mt19937_64 generator(5);
  const Mesh mesh = sheet(8, 4.0, [](double x, double y) { return std::sin(2 * x) * std::cos(1.5 * y); });
  const CgalGeodesics geodesics(mesh.positions_mm, mesh.triangles);
  std::vector<MeshPoint> points;
  for (int i = 0; i < 8; ++i) points.push_back(random_point(generator, mesh));
  std::vector<std::vector<double>> d;
  for (const MeshPoint& source : points) d.push_back(geodesics.distances_mm(source, points));
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      EXPECT_NEAR(d[i][j], d[j][i], kAllowed);
      EXPECT_GE(d[i][j], (position_mm(mesh, points[i]) - position_mm(mesh, points[j])).norm() - kAllowed);
      for (std::size_t k = 0; k < points.size(); ++k) EXPECT_LE(d[i][j], d[i][k] + d[k][j] + kAllowed);
    }
  }
}

// On the line from the source through a corner of its own face, where CGAL 5.5 by itself goes astray.
TEST(CgalGeodesics, FindsTheStraightLineToACorner) {
  const Mesh mesh = sheet(5, 5.0, [](double x, double y) { return 0.8 * std::sin(4.0 * x * x + 7.0 * y); });
  const CgalGeodesics geodesics(mesh.positions_mm, mesh.triangles);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const MeshPoint source{t, Vec3d::Constant(1.0 / 3.0)};
    const CgalGeodesics::From from(geodesics, source);
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 32; ++k) {
        const MeshPoint target{t, Vec3d((1.0 - k / 32.0) * source.barycentric + k / 32.0 * Vec3d::Unit(c))};
        EXPECT_NEAR(from.distance_mm(target), (position_mm(mesh, source) - position_mm(mesh, target)).norm(),
                    kAllowed);
      }
    }
  }
}

TEST(CgalGeodesics, OtherComponentsAreInfinitelyFar) {
  Mesh mesh;
  mesh.positions_mm = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const std::vector<MeshPoint> other = {{1, Vec3d::Constant(1.0 / 3.0)}};
  EXPECT_EQ(CgalGeodesics(mesh.positions_mm, mesh.triangles).distances_mm({0, {0.2, 0.2, 0.6}}, other)[0],
            std::numeric_limits<double>::infinity());
}

TEST(CgalGeodesics, RefusesWhatHasNoGeodesics) {
  const std::vector<Vec3d> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {2, 0, 0}};
  const auto refusal = [&](std::vector<std::array<int, 3>> triangles) {
    const auto error = test::error_of([&] { const CgalGeodesics refused(x, triangles); });
    return error ? std::string(error->what()) : std::string("no error");
  };
  EXPECT_EQ(refusal({{0, 1, 2}, {1, 0, 3}}), "no error");
  EXPECT_EQ(refusal({{0, 1, 2}, {0, 1, 4}}).substr(0, 21), "triangle 1 (from 0) h");
  EXPECT_EQ(refusal({{0, 1, 2}, {0, 1, 3}}).substr(0, 38), "triangle 1 (from 0) does not fit to it");
}

}  // namespace
}  // namespace truescatter
