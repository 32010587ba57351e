#include "scene/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "scene/load_mesh.h"

namespace truescatter {
namespace {

Mesh make_mesh(std::vector<Vec3d> positions, std::vector<std::array<int, 3>> triangles) {
  Mesh mesh;
  mesh.positions_mm = std::move(positions);
  mesh.triangles = std::move(triangles);
  return mesh;
}

// Two triangles of the unit square; the second is turned by `angle_deg` about the shared edge (the y axis).
Mesh make_hinge(double angle_deg) {
  const double angle = angle_deg * kPi / 180.0;
  return make_mesh({{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {std::cos(angle), 0, -std::sin(angle)}},
                   {{0, 1, 2}, {0, 3, 1}});
}

Mesh make_icosahedron() {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  Mesh mesh = make_mesh({{-1, g, 0},
                         {1, g, 0},
                         {-1, -g, 0},
                         {1, -g, 0},
                         {0, -1, g},
                         {0, 1, g},
                         {0, -1, -g},
                         {0, 1, -g},
                         {g, 0, -1},
                         {g, 0, 1},
                         {-g, 0, -1},
                         {-g, 0, 1}},
                        {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                         {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                         {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}});
  for (Vec3d& position : mesh.positions_mm) position.normalize();
  return mesh;
}

// How unround the mesh is: largest over smallest distance from the origin, minus 1.
double roundness_error(const Mesh& mesh) {
  double low = HUGE_VAL;
  double high = 0.0;
  for (const Vec3d& position : mesh.positions_mm) {
    low = std::min(low, position.norm());
    high = std::max(high, position.norm());
  }
  return high / low - 1.0;
}

double uv_area(const Mesh& mesh) {
  double sum = 0.0;
  for (const auto& uv : *mesh.corner_uvs) {
    const Vec2d a = uv[1] - uv[0];
    const Vec2d b = uv[2] - uv[0];
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

TEST(Mesh, AreaAndNormalOfATriangle) {
  // Legs 3 and 4 in the plane z = 0: area 6, normal +z.
  const Mesh mesh = make_mesh({{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {{0, 1, 2}, {0, 2, 1}});
  EXPECT_DOUBLE_EQ(triangle_area_mm2(mesh, 0), 6.0);
  EXPECT_DOUBLE_EQ(surface_area_mm2(mesh), 12.0);
  EXPECT_EQ(triangle_normal(mesh, 0), Vec3d(0, 0, 1));
  EXPECT_EQ(triangle_normal(mesh, 1), Vec3d(0, 0, -1));
}

TEST(Mesh, NormalOfADegenerateTriangleIsZero) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {0, 0, 1}});
  EXPECT_EQ(triangle_normal(mesh, 0), Vec3d(0, 0, 0));
  EXPECT_EQ(triangle_normal(mesh, 1), Vec3d(0, 0, 0));
  EXPECT_EQ(surface_area_mm2(mesh), 0.0);
}

TEST(Mesh, DistanceFromATriangleIsToItsNearestPoint) {
  const Vec3d a(0.0, 0.0, 0.0);
  const Vec3d b(4.0, 0.0, 0.0);
  const Vec3d c(0.0, 3.0, 0.0);
  const auto distance2 = [&](const Vec3d& p) { return squared_distance_to_triangle(p, a, b, c); };
  EXPECT_NEAR(distance2({1.0, 1.0, -2.0}), 4.0, 1e-14);      // above the inside
  EXPECT_NEAR(distance2({2.0, -3.0, 4.0}), 25.0, 1e-14);     // beside the edge ab
  EXPECT_NEAR(distance2({-3.0, -4.0, 12.0}), 169.0, 1e-13);  // beyond the corner a
  EXPECT_NEAR(distance2({9.0, 0.0, 0.0}), 25.0, 1e-14);      // beyond the corner b
  EXPECT_NEAR(distance2({4.0, 3.0, 0.0}), 5.76, 1e-14);      // across bc: 12/5 from the line 3x + 4y = 12
  EXPECT_EQ(distance2({4.0, 0.0, 0.0}), 0.0);
  // Without area: the segment from (0, 0, 0) to (4, 0, 0), and a point.
  EXPECT_NEAR(squared_distance_to_triangle({2.0, 5.0, 0.0}, a, b, {1.0, 0.0, 0.0}), 25.0, 1e-14);
  EXPECT_NEAR(squared_distance_to_triangle({0.0, 0.0, 7.0}, a, a, a), 49.0, 1e-14);

  // Against the nearest of many points of the triangle: never farther, and nearer by no more than their
  // spacing, for the nearest point lies in a cell of 4 / 200 x 3 / 200, within 0.025 of its corners.
  unsigned state = 7;
  const auto random = [&state] {
    state = state * 1664525U + 1013904223U;
    return static_cast<double>(state >> 8U) / 16777216.0;
  };
  for (int i = 0; i < 50; ++i) {
    const Vec3d p(12.0 * random() - 4.0, 11.0 * random() - 4.0, 4.0 * random() - 2.0);
    double sampled = 1e9;
    for (int u = 0; u <= 200; ++u) {
      for (int v = 0; v <= 200 - u; ++v)
        sampled = std::min(sampled, (p - (a + u / 200.0 * (b - a) + v / 200.0 * (c - a))).norm());
    }
    const double exact = std::sqrt(distance2(p));
    EXPECT_LE(exact, sampled + 1e-12);
    EXPECT_GE(exact, sampled - 0.025) << p.transpose();
  }
}

TEST(Mesh, NormalsAreWeightedByAngle) {
  // At the origin: +z with 90 degrees in one triangle, +y with 2 x 45 degrees in two. The mean is halfway
  // between y and z, although there are two faces on one side.
  Mesh mesh =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}}, {{0, 1, 2}, {0, 3, 4}, {0, 4, 1}});
  set_angle_weighted_normals(mesh);
  const Vec3d expected = Vec3d(0, 1, 1).normalized();
  for (std::size_t t = 0; t < 3; ++t) EXPECT_LT((mesh.corner_normals[t][0] - expected).norm(), 1e-15);
}

TEST(Mesh, CreaseAngleDecidesWhoSharesANormal) {
  Mesh mesh = make_hinge(60.0);
  set_angle_weighted_normals(mesh, 59.9);
  EXPECT_LT((mesh.corner_normals[0][0] - triangle_normal(mesh, 0)).norm(), 1e-15);
  EXPECT_LT((mesh.corner_normals[1][0] - triangle_normal(mesh, 1)).norm(), 1e-15);

  set_angle_weighted_normals(mesh, 60.1);
  EXPECT_LT((mesh.corner_normals[0][0] - mesh.corner_normals[1][0]).norm(), 1e-15);
  // Both have 90 degrees at vertex 0: the mean leans by half of the 60 degrees.
  EXPECT_NEAR(std::acos(mesh.corner_normals[0][0].z()) * 180.0 / kPi, 30.0, 1e-9);
  // The outer corners belong to one face each.
  EXPECT_LT((mesh.corner_normals[1][1] - triangle_normal(mesh, 1)).norm(), 1e-15);
}

TEST(Mesh, SmoothnessIsTransitiveAroundAVertex) {
  // A fan of four faces, each 30 degrees from the next: 40 degrees joins all of them.
  std::vector<Vec3d> positions{{0, 0, 0}};
  for (int i = 0; i <= 4; ++i) {
    const double angle = i * kPi / 6.0;
    positions.emplace_back(std::cos(angle), std::sin(angle), 1.0);
  }
  Mesh mesh = make_mesh(positions, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}});
  set_angle_weighted_normals(mesh, 40.0);
  for (std::size_t t = 1; t < 4; ++t) {
    EXPECT_LT((mesh.corner_normals[t][0] - mesh.corner_normals[0][0]).norm(), 1e-14);
  }
}

TEST(Mesh, ADegenerateTriangleTakesTheSmoothNormalAndBridgesNoCrease) {
  Mesh mesh = make_hinge(90.0);
  mesh.triangles.push_back({0, 1, 1});
  set_angle_weighted_normals(mesh, 30.0);
  EXPECT_LT((mesh.corner_normals[0][0] - triangle_normal(mesh, 0)).norm(), 1e-15);
  EXPECT_LT((mesh.corner_normals[1][0] - triangle_normal(mesh, 1)).norm(), 1e-15);
  for (const Vec3d& normal : mesh.corner_normals[2]) EXPECT_NEAR(normal.norm(), 1.0, 1e-15);
  EXPECT_NEAR(mesh.corner_normals[2][0].x(), mesh.corner_normals[2][0].z(), 1e-15);
}

TEST(Mesh, WeldJoinsExactlyEqualPositionsOnly) {
  const double above = std::nextafter(1.0, 2.0);
  Mesh mesh =
      make_mesh({{1, 0, 0}, {0.0, 1, 0}, {above, 0, 0}, {-0.0, 1, -0.0}, {1, 0, 0}}, {{0, 1, 2}, {3, 4, 2}});
  EXPECT_EQ(weld_coincident_positions(mesh), (std::vector<int>{0, 1, 2, 1, 0}));
  EXPECT_EQ(mesh.positions_mm.size(), 3U);
  EXPECT_EQ(mesh.triangles[1], (std::array<int, 3>{1, 0, 2}));
}

TEST(Mesh, WeldKeepsTheOrderOfAMeshWithoutDuplicates) {
  Mesh mesh = make_icosahedron();
  const Mesh before = mesh;
  const std::vector<int> map = weld_coincident_positions(mesh);
  for (std::size_t i = 0; i < map.size(); ++i) EXPECT_EQ(map[i], static_cast<int>(i));
  EXPECT_EQ(mesh.triangles, before.triangles);
}

TEST(Loop, MakesAnIcosahedronRounderAndFourTimesAsFine) {
  Mesh mesh = make_icosahedron();
  double last_step_deg = HUGE_VAL;
  for (int level = 1; level <= 4; ++level) {
    mesh = loop_subdivide(mesh);
    EXPECT_EQ(mesh.triangles.size(), 20U << (2 * level));
    // Euler: V = F/2 + 2 on a sphere.
    EXPECT_EQ(mesh.positions_mm.size(), mesh.triangles.size() / 2 + 2);
    // Smooth: the largest angle between a face's normal and its corners' normals halves with each step.
    // Near the twelve vertices of valence 5 curvature is not continuous, hence 0.6 and not 0.5.
    double step_deg = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const Vec3d& normal : mesh.corner_normals[t]) {
        step_deg =
            std::max(step_deg, std::acos(std::min(1.0, normal.dot(triangle_normal(mesh, t)))) * 180.0 / kPi);
      }
    }
    if (level > 1) {
      EXPECT_LT(step_deg, 0.6 * last_step_deg);
    }
    last_step_deg = step_deg;
  }
  // Where a vertex of valence 5 goes: (vertex, mean of its ring) is mapped by [[1 - 5 beta, 5 beta], [3/8,
  // 5/8]] with 5 beta = 3/8: eigenvalues 1, with the left eigenvector (1, 1) / 2, and 1/4. The mean starts at
  // 1 / sqrt(5), so the limit is (1 + 1 / sqrt(5)) / 2, and a quarter of the distance to it is left each
  // time.
  const double limit = 0.5 * (1.0 + 1.0 / std::sqrt(5.0));
  EXPECT_NEAR(mesh.positions_mm[0].norm(), limit + (1.0 - limit) / 256.0, 1e-14);
  // The corners are the outermost part of the limit surface, which is a sphere to about 3 %.
  EXPECT_LT(roundness_error(mesh), 0.035);
}

TEST(Loop, InteriorRulesAreWarrens) {
  // One step on an icosahedron of circumradius 1: n = 5, beta = 3/40; the neighbours' sum is 5 (1/sqrt 5) p.
  // So p' = (1 - 5 beta) p + beta sqrt(5) p.
  const Mesh mesh = loop_subdivide(make_icosahedron());
  const double beta = 3.0 / 40.0;
  EXPECT_NEAR(mesh.positions_mm[0].norm(), 1.0 - 5.0 * beta + beta * std::sqrt(5.0), 1e-15);
  // A tetrahedron: n = 3, beta = 3/16; the neighbours' sum is -p: p' = (1 - 9/16 - 3/16) p = p / 4.
  const Mesh tetrahedron = loop_subdivide(make_mesh({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
                                                    {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}));
  EXPECT_LT((tetrahedron.positions_mm[0] - Vec3d(0.25, 0.25, 0.25)).norm(), 1e-15);
}

TEST(Loop, KeepsAPlanarMeshPlanarAndItsStraightBoundary) {
  // A 2 x 2 square of eight triangles around a centre.
  Mesh mesh =
      make_mesh({{0, 0, 3},
                 {1, 0, 3},
                 {1, 1, 3},
                 {0, 1, 3},
                 {-1, 1, 3},
                 {-1, 0, 3},
                 {-1, -1, 3},
                 {0, -1, 3},
                 {1, -1, 3}},
                {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 7}, {0, 7, 8}, {0, 8, 1}});
  mesh = loop_subdivide(loop_subdivide(mesh));
  for (const Vec3d& position : mesh.positions_mm) {
    EXPECT_EQ(position.z(), 3.0);
    EXPECT_LE(position.head<2>().cwiseAbs().maxCoeff(), 1.0);
  }
  for (const auto& normals : mesh.corner_normals) EXPECT_LT((normals[0] - Vec3d::UnitZ()).norm(), 1e-15);
  // Boundary rule at the first step: the mid-side (1, 0) stays, the corner (1, 1) is cut to 3/4 + 1/8 (1 +
  // 0). After the first step it is at 7/8, after the second nearer to the B-spline: below 1 and above 5/6.
  EXPECT_LT((mesh.positions_mm[1] - Vec3d(1, 0, 3)).norm(), 0.2);
  EXPECT_GT(mesh.positions_mm[2].x(), 5.0 / 6.0 - 1e-12);
}

TEST(Loop, AnEdgeOfThreeTrianglesIsACrease) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}},
                              {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
  const Mesh fine = loop_subdivide(mesh);
  EXPECT_EQ(fine.triangles.size(), 12U);
  // Its midpoint is the plain one, and its ends, where more than two creases meet, stay.
  EXPECT_EQ(fine.positions_mm[0], mesh.positions_mm[0]);
  const bool has_midpoint = std::any_of(fine.positions_mm.begin() + 5, fine.positions_mm.end(),
                                        [](const Vec3d& p) { return p == Vec3d(0, 0, 0.5); });
  EXPECT_TRUE(has_midpoint);
}

TEST(Loop, KeepsUvAreasAndSeams) {
  Mesh mesh = make_hinge(30.0);
  // The two faces lie apart in UV: areas 1/8 and 1/2.
  mesh.corner_uvs = {{{Vec2d(0, 0), Vec2d(0.5, 0), Vec2d(0, 0.5)}, {Vec2d(2, 2), Vec2d(3, 2), Vec2d(2, 3)}}};
  const Mesh fine = loop_subdivide(mesh);
  EXPECT_NEAR(uv_area(fine), 0.625, 1e-15);
  for (std::size_t t = 0; t < 4; ++t) {
    for (const Vec2d& uv : (*fine.corner_uvs)[t]) EXPECT_LE(uv.maxCoeff(), 0.5);
    for (const Vec2d& uv : (*fine.corner_uvs)[t + 4]) EXPECT_GE(uv.minCoeff(), 2.0);
  }
}

TEST(Loop, IsTheSameForAnyOrderOfTheTriangles) {
  const Mesh mesh = make_icosahedron();
  Mesh reversed = mesh;
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  const auto sorted = [](const Mesh& m) {
    std::multiset<std::array<double, 3>> set;
    for (const Vec3d& p : m.positions_mm) set.insert({p.x(), p.y(), p.z()});
    return set;
  };
  const auto a = sorted(loop_subdivide(mesh));
  const auto b = sorted(loop_subdivide(reversed));
  ASSERT_EQ(a.size(), b.size());
  for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j) {
    // The two opposite vertices are summed in another order: a unit in the last place.
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR((*i)[k], (*j)[k], 1e-15);
  }
}

// A strip of three unit triangles in space; the test sets their UVs.
Mesh make_uv_case(std::vector<std::array<Vec2d, 3>> uvs) {
  Mesh mesh;
  for (std::size_t t = 0; t < uvs.size(); ++t) {
    const double x = 2.0 * static_cast<double>(t);
    const int first = static_cast<int>(mesh.positions_mm.size());
    mesh.positions_mm.insert(mesh.positions_mm.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  mesh.corner_uvs = std::move(uvs);
  set_angle_weighted_normals(mesh);
  return mesh;
}

TEST(UvReport, SharedEdgesAndVerticesAreNoOverlap) {
  const UvReport report = inspect_uvs(make_uv_case({{Vec2d(0, 0), Vec2d(0.5, 0), Vec2d(0, 0.5)},
                                                    {Vec2d(0.5, 0), Vec2d(0.5, 0.5), Vec2d(0, 0.5)},
                                                    {Vec2d(0.5, 0.5), Vec2d(1, 0.5), Vec2d(0.5, 1)}}));
  EXPECT_EQ(report.triangles, 3U);
  EXPECT_EQ(report.overlapping, 0U);
  EXPECT_EQ(report.flipped, 0U);
  EXPECT_EQ(report.zero_area, 0U);
  EXPECT_EQ(report.outside_unit_square, 0U);
  // All have area 1/2 in space and 1/8 in UV, similar shapes: 2 mm per unit, isotropic.
  EXPECT_NEAR(report.mm_per_unit_median, 2.0, 1e-14);
  EXPECT_NEAR(report.mm_per_unit_p05, 2.0, 1e-14);
  EXPECT_NEAR(report.mm_per_unit_p95, 2.0, 1e-14);
}

TEST(UvReport, FoldOverCountsAsFlippedAndOverlapping) {
  // The second is the first's neighbour over the edge (0,0.5)-(0.5,0), folded back onto it.
  const UvReport report = inspect_uvs(make_uv_case({{Vec2d(0, 0), Vec2d(0.5, 0), Vec2d(0, 0.5)},
                                                    {Vec2d(0.5, 0), Vec2d(0.1, 0.1), Vec2d(0, 0.5)},
                                                    {Vec2d(0.5, 0.5), Vec2d(1, 0.5), Vec2d(0.5, 1)}}));
  EXPECT_EQ(report.flipped, 1U);
  EXPECT_EQ(report.overlapping, 2U);
}

TEST(UvReport, OneInsideTheOtherAndIdenticalOnesOverlap) {
  const std::array<Vec2d, 3> large{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)};
  const std::array<Vec2d, 3> inside{Vec2d(0.1, 0.1), Vec2d(0.2, 0.1), Vec2d(0.1, 0.2)};
  EXPECT_EQ(inspect_uvs(make_uv_case({large, inside})).overlapping, 2U);
  EXPECT_EQ(inspect_uvs(make_uv_case({large, large})).overlapping, 2U);
}

TEST(UvReport, ACrossWithoutAnyVertexInsideOverlaps) {
  const std::array<Vec2d, 3> flat{Vec2d(0, 0.45), Vec2d(1, 0.5), Vec2d(0, 0.55)};
  const std::array<Vec2d, 3> tall{Vec2d(0.45, 0), Vec2d(0.55, 0), Vec2d(0.5, 1)};
  EXPECT_EQ(inspect_uvs(make_uv_case({flat, tall})).overlapping, 2U);
}

TEST(UvReport, BoxesThatMeetWhileTrianglesDoNotAreNoOverlap) {
  EXPECT_EQ(inspect_uvs(make_uv_case({{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)},
                                      {Vec2d(1, 1), Vec2d(0.1, 1), Vec2d(1, 0.1)}}))
                .overlapping,
            0U);
}

TEST(UvReport, CountsZeroAreaAndOutside) {
  const UvReport report = inspect_uvs(make_uv_case({{Vec2d(0, 0), Vec2d(0.5, 0), Vec2d(1, 0)},
                                                    {Vec2d(0.5, 0.5), Vec2d(1.1, 0.5), Vec2d(0.5, 1)},
                                                    {Vec2d(-1e-7, 0.5), Vec2d(0.4, 0.5), Vec2d(0.1, 1)}}));
  EXPECT_EQ(report.zero_area, 1U);
  EXPECT_EQ(report.outside_unit_square, 1U);
  EXPECT_EQ(report.overlapping, 0U);
}

TEST(UvReport, MeasuresAnisotropy) {
  // One mm is 1/4 along u and 1 along v: singular values 4 and 1, ratio 4, sqrt(area ratio) = 2.
  const UvReport report = inspect_uvs(make_uv_case({{Vec2d(0, 0), Vec2d(0.25, 0), Vec2d(0, 1)}}));
  EXPECT_NEAR(report.anisotropy_p95, 4.0, 1e-12);
  EXPECT_NEAR(report.mm_per_unit_median, 2.0, 1e-14);
  // A shear by 1: singular values of [[1, 1], [0, 1]] are the golden ratio and its inverse.
  const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
  const UvReport sheared = inspect_uvs(make_uv_case({{Vec2d(0, 0), Vec2d(1, 0), Vec2d(1, 1)}}));
  EXPECT_NEAR(sheared.anisotropy_p95, golden * golden, 1e-12);
}

TEST(UvReport, WithoutUvsOnlyCountsTriangles) {
  const UvReport report = inspect_uvs(make_icosahedron());
  EXPECT_EQ(report.triangles, 20U);
  EXPECT_EQ(report.overlapping, 0U);
  EXPECT_EQ(report.mm_per_unit_median, 0.0);
}

// The plain definition of an overlap, over all pairs: clip one triangle by the other and measure what is
// left.
double clipped_area(const std::array<Vec2d, 3>& subject, const std::array<Vec2d, 3>& clip) {
  const auto cross = [](const Vec2d& a, const Vec2d& b) { return a.x() * b.y() - a.y() * b.x(); };
  std::vector<Vec2d> polygon(subject.begin(), subject.end());
  const double winding = cross(clip[1] - clip[0], clip[2] - clip[0]) > 0.0 ? 1.0 : -1.0;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<Vec2d> kept;
    const auto side = [&](const Vec2d& p) {
      return winding * cross(clip[(c + 1) % 3] - clip[c], p - clip[c]);
    };
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec2d& a = polygon[i];
      const Vec2d& b = polygon[(i + 1) % polygon.size()];
      if (side(a) >= 0.0) kept.push_back(a);
      if ((side(a) > 0.0 && side(b) < 0.0) || (side(a) < 0.0 && side(b) > 0.0)) {
        kept.emplace_back(a + (b - a) * side(a) / (side(a) - side(b)));
      }
    }
    polygon = kept;
  }
  double area = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    area += 0.5 * cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return std::abs(area);
}

TEST(UvReport, AgreesWithClippingAllPairs) {
  // 300 small random triangles: some overlap, most do not.
  unsigned state = 12345;
  const auto random = [&state] {
    state = state * 1664525U + 1013904223U;
    return static_cast<double>(state >> 8U) / 16777216.0;
  };
  std::vector<std::array<Vec2d, 3>> uvs;
  for (int i = 0; i < 300; ++i) {
    const Vec2d at(random(), random());
    uvs.push_back({at, at + 0.06 * Vec2d(random(), random()), at + 0.06 * Vec2d(random(), -random())});
  }
  std::set<std::size_t> expected;
  for (std::size_t i = 0; i < uvs.size(); ++i) {
    for (std::size_t j = 0; j < uvs.size(); ++j) {
      if (i != j && clipped_area(uvs[i], uvs[j]) > 1e-9) expected.insert(i);
    }
  }
  EXPECT_GT(expected.size(), 50U);
  EXPECT_LT(expected.size(), 290U);
  EXPECT_EQ(inspect_uvs(make_uv_case(uvs)).overlapping, expected.size());
}

}  // namespace
}  // namespace truescatter
