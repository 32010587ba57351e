#include "truth/geodesic_brute.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.h"
#include "scene/mesh.h"
#include "support/random.h"
#include "truth/geodesic_exact.h"

namespace truescatter {
namespace {

using test::uniform;

Vec3d random_in_unit_cube(std::mt19937_64& generator) {
  return {uniform(generator), uniform(generator), uniform(generator)};
}

// An octahedron, its faces cut in four and its vertices moved off the sphere by up to a fifth: cones and
// saddles all over, and no boundary.
Mesh rough_ball(std::uint64_t seed) {
  Mesh mesh;
  mesh.positions_mm = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (const int x : {0, 1}) {
    for (const int y : {2, 3}) {
      for (const int z : {4, 5}) {
        const bool outward = (x + y + z) % 2 == 0;
        mesh.triangles.push_back(outward ? std::array{x, y, z} : std::array{x, z, y});
      }
    }
  }
  const auto cut = [&] {
    std::vector<std::array<int, 3>> finer;
    for (const std::array<int, 3>& t : mesh.triangles) {
      std::array<int, 3> middle{};
      for (std::size_t e = 0; e < 3; ++e) {
        const auto a = static_cast<std::size_t>(t[e]);
        const auto b = static_cast<std::size_t>(t[(e + 1) % 3]);
        middle[e] = static_cast<int>(mesh.positions_mm.size());
        mesh.positions_mm.push_back((mesh.positions_mm[a] + mesh.positions_mm[b]).normalized());
      }
      finer.push_back({t[0], middle[0], middle[2]});
      finer.push_back({middle[0], t[1], middle[1]});
      finer.push_back({middle[2], middle[1], t[2]});
      finer.push_back({middle[0], middle[1], middle[2]});
    }
    mesh.triangles = finer;
    weld_coincident_positions(mesh);
  };
  cut();
  std::mt19937_64 generator(seed);
  for (Vec3d& p : mesh.positions_mm) p *= 2.0 * (0.8 + 0.4 * uniform(generator));
  return mesh;
}

// A pyramid without its base: a cone with a boundary.
Mesh pyramid() {
  Mesh mesh;
  mesh.positions_mm = {{0.2, -0.1, 1.5}, {2, 0, 0}, {0, 2, 0}, {-2, 0, 0}, {0, -2, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}};
  return mesh;
}

// An L of three squares with a bump: paths bend round the inner corner, which lies on the boundary.
Mesh bumpy_l() {
  Mesh mesh;
  mesh.positions_mm = {{0, 0, 0}, {1, 0, 0.3}, {2, 0, 0}, {0, 1, 0.4},
                       {1, 1, 0}, {2, 1, 0.2}, {0, 2, 0}, {1, 2, 0.5}};
  mesh.triangles = {{0, 1, 4}, {4, 3, 0}, {1, 2, 5}, {5, 4, 1}, {3, 4, 7}, {7, 6, 3}};
  return mesh;
}

struct Scene {
  const char* name;
  Mesh mesh;
  GeodesicSurface surface;
};

Scene lit(const char* name, const Mesh& mesh, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<Vec3d> value;
  for (std::size_t v = 0; v < mesh.positions_mm.size(); ++v) value.push_back(random_in_unit_cube(generator));
  std::vector<GeodesicPiece> pieces;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    if (f % 7 == 3) continue;  // no skin there
    GeodesicPiece piece{f, {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()}, {}, 0};
    for (std::size_t c = 0; c < 3; ++c)
      piece.irradiance[c] = value[static_cast<std::size_t>(mesh.triangles[f][c])];
    pieces.push_back(piece);
  }
  return {name, mesh, {IntrinsicMesh(mesh.positions_mm, mesh.triangles), pieces}};
}

std::vector<Scene> scenes() {
  return {lit("ball", rough_ball(3), 5), lit("pyramid", pyramid(), 7), lit("L", bumpy_l(), 9)};
}

// Inside a face, on an edge and at a vertex.
std::vector<GeodesicTarget> targets(const Mesh& mesh, std::uint64_t seed, int count) {
  std::mt19937_64 generator(seed);
  std::vector<GeodesicTarget> result;
  for (int i = 0; i < count; ++i) {
    Vec3d b = random_in_unit_cube(generator);
    if (i % 3 == 1) b[i / 3 % 3] = 0.0;
    if (i % 3 == 2) b = Vec3d::Unit(i / 3 % 3);
    result.push_back({{generator() % mesh.triangles.size(), b / b.sum()}, 0});
  }
  return result;
}

const std::vector<TruthLayer> kLayers = {{0.15}, {0.6}, {1.5}, {0.6, 0.9}, {1.5, 2.1}};

// What it may err by: the tolerance, the tail of tolerance/100 of a plane's mass for each of at most 32
// faces, and the exact engine's own 1e-11. Light is at most 1.
void expect_agree(const Scene& scene, const DistanceFrom& distances, double tolerance, int count) {
  const GeodesicExactEngine exact(scene.surface);
  const GeodesicBruteEngine brute(scene.surface, distances, tolerance);
  GeodesicField field(scene.surface.mesh());
  for (const GeodesicTarget& target : targets(scene.mesh, 11, count)) {
    const std::vector<Vec4d> expected = exact.convolve(field, target, kLayers);
    const std::vector<Vec4d> found = brute.convolve(target, kLayers);
    for (std::size_t l = 0; l < kLayers.size(); ++l) {
      EXPECT_LE((found[l] - expected[l]).cwiseAbs().maxCoeff(), 1.32 * tolerance + 1e-11)
          << scene.name << " s " << kLayers[l].std_dev_mm << " r_max " << kLayers[l].r_max_mm << " face "
          << target.point.face;
    }
  }
}

TEST(GeodesicBrute, AgreesWithTheExactEngine) {
  for (const Scene& scene : scenes()) {
    for (const double tolerance : {1e-4, 1e-7})
      expect_agree(scene, distances_by_windows(scene.surface.mesh()), tolerance, 6);
    expect_agree(scene, distances_by_windows(scene.surface.mesh()), 1e-9, 1);
  }
}

TEST(GeodesicBrute, AgreesByDistancesOfCgal) {
  for (const Scene& scene : scenes()) {
    const CgalGeodesics cgal(scene.mesh.positions_mm, scene.mesh.triangles);
    expect_agree(scene, distances_by_cgal(scene.surface.mesh(), cgal), 1e-6, 3);
  }
}

}  // namespace
}  // namespace truescatter
