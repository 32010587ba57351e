// Distances along rough meshes, at a hundred thousand random points inside faces, against CGAL's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "robustness/unfolding.h"
#include "scene/builtin.h"
#include "support/sampling.h"
#include "truth/cgal_geodesic.h"
#include "truth/geodesic_field.h"

namespace truescatter {
namespace {

using test::random_barycentric;
using test::uniform;

Mesh roughened(Mesh mesh, double amplitude_mm, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  for (Vec3d& p : mesh.positions_mm) {
    for (double& x : p) x += amplitude_mm * (uniform(generator) - 0.5);
  }
  return mesh;
}

// Takes out triangles none of which share a vertex with another or with the border, so that every hole is a
// boundary of its own.
Mesh perforated(Mesh mesh, std::uint64_t seed) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : mesh.triangles) {
    for (std::size_t e = 0; e < 3; ++e) ++uses[std::minmax(t[e], t[(e + 1) % 3])];
  }
  std::vector<bool> taken(mesh.positions_mm.size(), false);
  for (const auto& [edge, count] : uses) {
    if (count == 1)
      taken[static_cast<std::size_t>(edge.first)] = taken[static_cast<std::size_t>(edge.second)] = true;
  }
  std::mt19937_64 generator(seed);
  std::erase_if(mesh.triangles, [&](const std::array<int, 3>& t) {
    const auto is_taken = [&](int v) { return taken[static_cast<std::size_t>(v)]; };
    if (uniform(generator) > 0.3 || std::any_of(t.begin(), t.end(), is_taken)) return false;
    for (const int v : t) taken[static_cast<std::size_t>(v)] = true;
    return true;
  });
  return mesh;
}

struct Scene {
  const char* name;
  Mesh mesh;
  double radius_mm;
};

std::vector<Scene> scenes() {
  std::vector<Scene> all;
  all.push_back(
      {"sphere", roughened(make_builtin("sphere", {{"radius_mm", 10.0}, {"edge_mm", 2.0}}), 0.8, 1), 16.0});
  const Mesh plane = make_builtin("plane", {{"size_mm", 20.0}, {"edge_mm", 1.2}});
  all.push_back({"sheet", roughened(plane, 1.0, 2), 12.0});
  all.push_back({"sheet with holes", perforated(roughened(plane, 0.7, 3), 4), 12.0});
  all.push_back(
      {"tube",
       roughened(make_builtin("tube", {{"radius_mm", 3.0}, {"length_mm", 24.0}, {"edge_mm", 1.6}}), 0.5, 5),
       14.0});
  all.push_back(
      {"slab",
       roughened(make_builtin("slab", {{"size_mm", 12.0}, {"thickness_mm", 1.0}, {"edge_mm", 1.5}}), 0.4, 6),
       10.0});
  // Triangles 20 times as long as high.
  Mesh drawn = roughened(plane, 0.7, 7);
  for (Vec3d& p : drawn.positions_mm) p.x() *= 20.0;
  all.push_back({"drawn out", drawn, 40.0});
  return all;
}

struct Disagreement {
  MeshPoint source;
  MeshPoint target;
  double found;
  double cgals;
};

// Both ways of computing round: a path of some dozen unfoldings of double precision, 1e-14 of the radius; for
// CGAL, a source on an edge is moved by 1e-12 of a face.
constexpr double kAllowed = 1e-10;  // of the radius
constexpr int kSources = 60;
constexpr std::size_t kPerSource = 280;  // 6 x 60 x 280 = 100,800

TEST(GeodesicDistances, AreCgalsAtAHundredThousandPoints) {
  std::size_t compared = 0;
  double worst = 0.0;
  for (const Scene& scene : scenes()) {
    const Mesh& mesh = scene.mesh;
    ASSERT_LE(mesh.triangle_count(), 2000U) << scene.name;
    const IntrinsicMesh intrinsic(mesh.positions_mm, mesh.triangles);
    const CgalGeodesics cgal(mesh.positions_mm, mesh.triangles);
    const test::Unfolding unfolding(mesh.positions_mm, mesh.triangles);
    GeodesicField field(intrinsic);
    std::mt19937_64 generator(31);
    std::vector<Disagreement> disagreements;
    for (int i = 0; i < kSources; ++i) {
      MeshPoint source{generator() % mesh.triangle_count(), random_barycentric(generator)};
      if (i % 3 == 1) source.barycentric[i / 3 % 3] = 0.0;
      if (i % 3 == 2) source.barycentric = Vec3d::Unit(i / 3 % 3);
      source.barycentric /= source.barycentric.sum();
      field.propagate({source.triangle, source.barycentric}, scene.radius_mm);
      const CgalGeodesics::From from(cgal, source);
      const Vec3d at = position_mm(mesh, source);
      for (std::size_t k = 0; k < kPerSource;) {
        const MeshPoint target{generator() % mesh.triangle_count(), random_barycentric(generator)};
        // A geodesic is at least as long.
        if ((position_mm(mesh, target) - at).norm() >= scene.radius_mm) continue;
        const double found =
            field.distance(target.triangle, flat_position(intrinsic, {target.triangle, target.barycentric}));
        const double cgals = from.distance_mm(target);
        // Beyond the radius a distance may be too long, or infinite.
        if (cgals >= scene.radius_mm && found >= scene.radius_mm) continue;
        ++k;
        ++compared;
        const double difference = std::abs(found - cgals);
        if (difference <= kAllowed * scene.radius_mm) {
          worst = std::max(worst, difference / scene.radius_mm);
        } else {
          disagreements.push_back({source, target, found, cgals});
        }
      }
    }
    int cgals_fault = 0;
    for (const Disagreement& d : disagreements) {
      const auto bound = static_cast<long double>(std::min(d.found, d.cgals)) + kAllowed * scene.radius_mm;
      const auto settled = static_cast<double>(unfolding.distance_mm(d.source, d.target, bound));
      std::printf(
          "%s: face %zu (%.17g %.17g %.17g) to face %zu (%.17g %.17g %.17g): %.15g, CGAL %.15g, unfolded "
          "%.15g\n",
          scene.name, d.source.triangle, d.source.barycentric[0], d.source.barycentric[1],
          d.source.barycentric[2], d.target.triangle, d.target.barycentric[0], d.target.barycentric[1],
          d.target.barycentric[2], d.found, d.cgals, settled);
      EXPECT_NEAR(d.found, settled, kAllowed * scene.radius_mm)
          << scene.name << " face " << d.target.triangle;
      if (std::abs(d.cgals - settled) > kAllowed * scene.radius_mm) ++cgals_fault;
    }
    std::printf("%s: %zu triangles, %zu disagreements, %d of them CGAL's fault\n", scene.name,
                mesh.triangle_count(), disagreements.size(), cgals_fault);
  }
  EXPECT_GE(compared, 100000U);
  std::printf("%zu points, off by at most %.1e of the radius where they agree\n", compared, worst);
}

// What settles a disagreement is right itself.
TEST(GeodesicDistances, UnfoldingFindsTheSame) {
  for (const Scene& scene : scenes()) {
    const Mesh& mesh = scene.mesh;
    const IntrinsicMesh intrinsic(mesh.positions_mm, mesh.triangles);
    const test::Unfolding unfolding(mesh.positions_mm, mesh.triangles);
    GeodesicField field(intrinsic);
    std::mt19937_64 generator(37);
    const double radius_mm = 0.5 * scene.radius_mm;
    for (int i = 0; i < 6; ++i) {
      MeshPoint source{generator() % mesh.triangle_count(), random_barycentric(generator)};
      if (i % 3 == 1) source.barycentric[i / 3 % 3] = 0.0;
      if (i % 3 == 2) source.barycentric = Vec3d::Unit(i / 3 % 3);
      source.barycentric /= source.barycentric.sum();
      field.propagate({source.triangle, source.barycentric}, radius_mm);
      for (int k = 0; k < 4;) {
        const auto covered = field.faces();
        const auto face = static_cast<std::size_t>(covered[generator() % covered.size()]);
        const MeshPoint target{face, random_barycentric(generator)};
        const double found = field.distance(face, flat_position(intrinsic, {face, target.barycentric}));
        if (found >= radius_mm) continue;
        ++k;
        const auto unfolded = static_cast<double>(unfolding.distance_mm(source, target, found + 1e-9L));
        EXPECT_NEAR(found, unfolded, kAllowed * radius_mm) << scene.name << " source " << i;
      }
    }
  }
}

}  // namespace
}  // namespace truescatter
