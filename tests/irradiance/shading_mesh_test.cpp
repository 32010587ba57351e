#include "irradiance/shading_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "scene/builtin.h"
#include "scene/characters.h"
#include "support/lamp.h"

namespace truescatter {
namespace {

using test::lamp;

Light shadowing(const Vec3d& direction) { return lamp(direction, true); }

ShadingMesh shade(const Mesh& mesh, const Light& light, const SkinMask& mask = {}, double tolerance = 0.02,
                  double floor_mm = 0.4) {
  return make_shading_mesh(mesh, Lighting(mesh, {light}), mask, {tolerance, floor_mm});
}

double area_mm2(const ShadingMesh& shading) {
  double area = 0.0;
  for (const ShadingTriangle& t : shading.triangles) {
    const Vec3d a = shading.corner(t, 0);
    area += 0.5 * (shading.corner(t, 1) - a).cross(shading.corner(t, 2) - a).norm();
  }
  return area;
}

// How many edges have one triangle, and how many more than two.
std::pair<int, int> boundary_and_crowded_edges(const ShadingMesh& shading) {
  std::map<std::pair<int, int>, int> uses;
  for (const ShadingTriangle& t : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      ++uses[std::minmax(t.vertices[c], t.vertices[(c + 1) % 3])];
    }
  }
  int boundary = 0;
  int crowded = 0;
  for (const auto& [edge, count] : uses) {
    if (count == 1) ++boundary;
    if (count > 2) ++crowded;
  }
  return {boundary, crowded};
}

TEST(Lighting, IsLambertOnAPlane) {
  const Mesh plane = make_builtin("plane");
  const Vec3d direction = Vec3d(1.0, 2.0, 2.0) / 3.0;
  const Lighting lighting(plane, {shadowing(direction)});
  // n = z, so n.l = 2/3; nothing shades a plane.
  EXPECT_NEAR(lighting.irradiance({5, Vec3d(0.2, 0.3, 0.5)}).x(), 2.0 / 3.0, 1e-12);
  const Lighting from_behind(plane, {shadowing(Vec3d(0.0, 0.0, -1.0))});
  EXPECT_EQ(from_behind.irradiance({5, Vec3d(0.2, 0.3, 0.5)}), Vec3d::Zero());
}

TEST(Lighting, PointLightFallsWithTheSquareOfTheDistance) {
  const Mesh plane = make_builtin("plane");
  Light light;
  light.kind = LightKind::point;
  light.reference_mm = 100.0;
  const MeshPoint point{7, Vec3d(0.2, 0.3, 0.5)};
  const Vec3d x = position_mm(plane, point);
  light.position_mm = x + Vec3d(0.0, 0.0, 200.0);
  EXPECT_NEAR(Lighting(plane, {light}).irradiance(point).y(), 0.25, 1e-12);
}

// Two triangles that make a square of `size` mm around the origin, in z = 0, facing +z.
Mesh big_square(double size) {
  Mesh mesh;
  const double half = 0.5 * size;
  mesh.positions_mm = {{-half, -half, 0.0}, {half, -half, 0.0}, {half, half, 0.0}, {-half, half, 0.0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  set_angle_weighted_normals(mesh);
  return mesh;
}

Light point_light(const Vec3d& position_mm, double reference_mm) {
  Light light;
  light.kind = LightKind::point;
  light.position_mm = position_mm;
  light.reference_mm = reference_mm;
  return light;
}

TEST(Lighting, LargestPossibleHoldsInsideATriangleToo) {
  // A lamp 10 mm above a triangle's inside, over 40 mm from every vertex: (20 / 10)^2 = 4 right below it.
  const Mesh square = big_square(100.0);
  const Lighting above(square, {point_light({20.0, -5.0, 10.0}, 20.0)});
  EXPECT_NEAR(above.largest_possible(), 4.0, 1e-12);
  // Below it lies x = 20, y = -5 in triangle (0, 1, 2): b1 = (x - y) / 100, b2 = (y + 50) / 100.
  const MeshPoint below{0, Vec3d(0.3, 0.25, 0.45)};
  EXPECT_NEAR((position_mm(square, below) - Vec3d(20.0, -5.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(above.irradiance(below).x(), 4.0, 1e-12);
  // Beside the square, 30 mm beyond its edge and 40 mm up: 50 mm from the edge, (20 / 50)^2.
  EXPECT_NEAR(Lighting(square, {point_light({80.0, 7.0, 40.0}, 20.0)}).largest_possible(), 0.16, 1e-12);
  // Beyond a corner by (3, 4, 12): 13 mm. Two lamps add up: 4 + (26 / 13)^2.
  EXPECT_NEAR(Lighting(square, {point_light({20.0, -5.0, 10.0}, 20.0), point_light({53.0, 54.0, 12.0}, 26.0)})
                  .largest_possible(),
              8.0, 1e-12);
  EXPECT_TRUE(std::isinf(Lighting(square, {point_light({20.0, -5.0, 0.0}, 20.0)}).largest_possible()));
}

TEST(Lighting, FrontCardShadesTheBackCard) {
  // Cards: the front one covers x < 0, 20 mm above the back one. Lit along -z from above, the back card is
  // dark where x < 0.
  const Mesh cards = make_builtin("cards");
  const Lighting lighting(cards, {shadowing(Vec3d::UnitZ())});
  for (std::size_t t = 0; t < cards.triangle_count(); ++t) {
    const MeshPoint middle{t, Vec3d::Constant(1.0 / 3.0)};
    const Vec3d x = position_mm(cards, middle);
    const bool dark = x.z() < 0.0 && x.x() < -0.1;
    if (std::abs(x.x()) < 0.1) continue;
    EXPECT_NEAR(lighting.irradiance(middle).x(), dark ? 0.0 : 1.0, 1e-12) << x.transpose();
  }
}

TEST(Lighting, CoarseSphereCastsNoBlocksOnItself) {
  // 6 mm edges on a radius of 25 mm: facets stand 0.2 mm below the sphere. The true sphere is lit wherever
  // n.l > 0; the faceted one, with shadows, must not lose light there. Within a facet's tilt of the
  // terminator (edge / radius = 0.24) the lamp grazes and the lift may fall short.
  const Mesh sphere = make_builtin("sphere", {{"edge_mm", 6.0}});
  const Light light = shadowing(Vec3d(0.3, 0.5, 1.0));
  const Lighting shadowed(sphere, {light});
  for (std::size_t t = 0; t < sphere.triangle_count(); ++t) {
    for (const Vec3d& b :
         {Vec3d(1.0 / 3, 1.0 / 3, 1.0 / 3), Vec3d(0.9, 0.05, 0.05), Vec3d(0.05, 0.9, 0.05)}) {
      const double cosine = interpolated_normal(sphere, {t, b}).dot(light.direction);
      if (cosine > 0.24) {
        EXPECT_NEAR(shadowed.irradiance({t, b}).x(), cosine, 1e-12) << "triangle " << t;
      }
    }
  }
}

TEST(Refinement, LeavesAnEvenlyLitPlaneAlone) {
  const Mesh plane = make_builtin("plane");
  EXPECT_EQ(shade(plane, shadowing(Vec3d(0.0, 0.3, 1.0))).triangles.size(), plane.triangle_count());
}

TEST(Refinement, IsConformingInPlaneAndGoesToTheShadowEdge) {
  const Mesh cards = make_builtin("cards");
  const Light light = shadowing(Vec3d(0.4, 0.0, 1.0));
  const ShadingMesh shading = shade(cards, light, {}, 0.02, 0.25);
  EXPECT_GT(shading.triangles.size(), cards.triangle_count());
  EXPECT_NEAR(area_mm2(shading), surface_area_mm2(cards), 1e-9 * surface_area_mm2(cards));
  EXPECT_EQ(boundary_and_crowded_edges(shading).second, 0);
  // A T-junction would show as inner edges with one triangle: the boundary must stay the cards' outlines.
  double boundary_mm = 0.0;
  std::map<std::pair<int, int>, int> uses;
  for (const ShadingTriangle& t : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) ++uses[std::minmax(t.vertices[c], t.vertices[(c + 1) % 3])];
  }
  for (const auto& [edge, count] : uses) {
    if (count != 1) continue;
    boundary_mm += (shading.positions_mm[static_cast<std::size_t>(edge.first)] -
                    shading.positions_mm[static_cast<std::size_t>(edge.second)])
                       .norm();
  }
  // Back card 60 x 60, front card 30 x 60.
  EXPECT_NEAR(boundary_mm, 4 * 60.0 + 2 * 90.0, 1e-6);
  // The shadow's edge on the back card: the front card's edge x = 0 at z = 10, moved by the lamp's slope over
  // the gap of 20 mm to x = -8.
  double smallest_at_edge = 1e9;
  double smallest_away = 1e9;  // more than 6 mm: beyond what the closure can reach from edges of 2 mm
  for (const ShadingTriangle& t : shading.triangles) {
    const Vec3d middle = (shading.corner(t, 0) + shading.corner(t, 1) + shading.corner(t, 2)) / 3.0;
    const double length = (shading.corner(t, 1) - shading.corner(t, 0)).norm();
    const double distance = std::abs(middle.x() + 8.0);
    if (std::abs(middle.y()) > 26.0)
      continue;  // the shadow's ends lie on the outline, where rays graze the card
    if (middle.z() > 0.0 || distance > 6.0) smallest_away = std::min(smallest_away, length);
    if (middle.z() < 0.0 && distance < 0.5) smallest_at_edge = std::min(smallest_at_edge, length);
  }
  EXPECT_GT(smallest_away, 1.0);
  EXPECT_LE(smallest_at_edge, 0.25);
}

TEST(Refinement, ResolvesACurvedSurfaceToItsTolerance) {
  const Mesh sphere = make_builtin("sphere", {{"edge_mm", 6.0}});
  const Light light = lamp(Vec3d(0.3, 0.5, 1.0));
  const Lighting lighting(sphere, {light});
  const ShadingMesh shading = make_shading_mesh(sphere, lighting, {}, {0.01, 0.05});
  const ShadingResidual residual = measure_residual(shading, lighting, 5000, 1);
  // Every midpoint and centroid is within the tolerance; between them the error of linear interpolation of a
  // smooth function is no larger than at the worst of these, up to the kink at the terminator.
  EXPECT_LT(residual.p99, 0.01);
  EXPECT_GT(residual.p99, 0.0);
  EXPECT_LE(residual.mean, residual.p99);
}

TEST(Refinement, ResidualIsInUnitsOfTheLargestVertexIrradiance) {
  // One triangle, not refined (the floor is above its edges), 60 degrees off a lamp of colour 4: every vertex
  // has I = 2, which is half of what the lamp could do. Against a lamp of colour 6 the field is 1 too small
  // everywhere: half of the largest irradiance that it has.
  Mesh mesh = big_square(10.0);
  mesh.triangles.pop_back();
  mesh.corner_normals.pop_back();
  Light light = lamp(Vec3d(std::sqrt(3.0), 0.0, 1.0));
  light.color = Vec3d(4.0, 1.0, 0.0);
  const ShadingMesh shading = make_shading_mesh(mesh, Lighting(mesh, {light}), {}, {0.02, 100.0});
  EXPECT_NEAR(largest_irradiance(shading), 2.0, 1e-12);
  light.color.x() = 6.0;
  const ShadingResidual residual = measure_residual(shading, Lighting(mesh, {light}), 100, 1);
  EXPECT_NEAR(residual.mean, 0.5, 1e-12);
  EXPECT_NEAR(residual.p99, 0.5, 1e-12);
  light.color = Vec3d::Zero();
  const ShadingMesh dark = make_shading_mesh(mesh, Lighting(mesh, {light}), {}, {0.02, 100.0});
  EXPECT_EQ(measure_residual(dark, Lighting(mesh, {light}), 100, 1).mean, 0.0);
}

TEST(Refinement, MaskIsReadAtCentroidsAndItsBorderIsRefined) {
  Image half(64, 64, 1);
  for (int y = 0; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) half.at(x, y, 0) = 1.0F;
  }
  const Mesh plane = make_builtin("plane");
  const ShadingMesh shading = shade(plane, shadowing(Vec3d::UnitZ()), SkinMask(half), 0.02, 0.25);
  double skin = 0.0;
  for (const ShadingTriangle& t : shading.triangles) {
    const Vec3d a = shading.corner(t, 0);
    const double area = 0.5 * (shading.corner(t, 1) - a).cross(shading.corner(t, 2) - a).norm();
    EXPECT_EQ(t.skin, t.component >= 0);
    if (t.skin) skin += area;
  }
  // The plane's UVs may have a margin, so half of it is skin; triangles at the border are at most 0.25 mm
  // wide (their longest edge may be sqrt 2 times the shortest), along 60 mm.
  EXPECT_NEAR(skin, 0.5 * 3600.0, 60.0 * 0.25 * 2.0);
  EXPECT_EQ(shading.component_count, 1);
}

// The right half of the plane is skin, and all of it scatters: one component with the light of both halves.
TEST(ScatterEverywhere, TakesWhatIsNotSkinIntoS) {
  const Mesh plane = make_builtin("plane");
  ShadingMesh shading = shade(plane, shadowing(Vec3d::UnitZ()));
  for (ShadingTriangle& t : shading.triangles) {
    const double x = (shading.corner(t, 0) + shading.corner(t, 1) + shading.corner(t, 2)).x();
    t.skin = t.scatters = x > 0.0;
    t.component = t.skin ? 0 : -1;
    if (!t.skin) t.irradiance.fill(Vec3d(7.0, 0.0, 0.0));
  }
  EXPECT_NEAR(largest_irradiance(shading), 1.0, 1e-12);
  scatter_everywhere(shading);
  EXPECT_EQ(largest_irradiance(shading), 7.0);
  EXPECT_EQ(shading.component_count, 1);
  for (const ShadingTriangle& t : shading.triangles) {
    EXPECT_TRUE(t.scatters);
    EXPECT_EQ(t.component, 0);
    EXPECT_EQ(t.skin, t.irradiance[0].x() < 7.0);
  }
}

TEST(ScatterEverywhere, JoinsNothingThatIsApart) {
  ShadingMesh cards = shade(make_builtin("cards"), shadowing(Vec3d::UnitZ()));
  scatter_everywhere(cards);
  EXPECT_EQ(cards.component_count, 2);
}

TEST(Components, CardsAreTwo) {
  EXPECT_EQ(shade(make_builtin("cards"), shadowing(Vec3d::UnitZ())).component_count, 2);
  EXPECT_EQ(shade(make_builtin("wedge"), shadowing(Vec3d(0.1, 0.0, 1.0))).component_count, 1);
}

TEST(SkinMask, IsSkinFromOneHalfOn) {
  // Left 1, right 0: half way between the texels' centres, at u = 0.5, the value is 0.5 but for rounding.
  Image image(2, 1, 1);
  image.at(0, 0, 0) = 1.0F;
  const SkinMask mask(image);
  EXPECT_FALSE(mask.everywhere());
  EXPECT_TRUE(mask.is_skin(Vec2d(0.5 - 1e-9, 0.5)));
  EXPECT_FALSE(mask.is_skin(Vec2d(0.5 + 1e-9, 0.5)));
  EXPECT_TRUE(SkinMask().everywhere());
  EXPECT_TRUE(SkinMask().is_skin(Vec2d(0.1, 0.1)));
}

// Two squares, one above the other; the upper one shades the lower one from x = -5 on.
TEST(ShadingMesh, CharactersCastShadowsOntoOneAnotherAndLieOneAfterTheOther) {
  const Mesh square = make_builtin("plane", {{"size_mm", 20.0}, {"edge_mm", 5.0}});
  const std::vector<CharacterPlace> places = {{Vec3d(0.0, 0.0, -10.0)}, {Vec3d(5.0, 0.0, 10.0)}};
  const Mesh two = place_characters(square, places);
  const ShadingMesh shading = shade(two, shadowing(Vec3d::UnitZ()));
  ASSERT_EQ(shading.character_starts.size(), 2U);
  EXPECT_EQ(shading.character_starts[0], 0U);
  EXPECT_EQ(shading.component_count, 2);
  // Refinement to the shadow's edge splits the lower square alone.
  EXPECT_EQ(shading.triangles.size() - shading.character_starts[1], square.triangle_count());
  EXPECT_GT(shading.character_starts[1], square.triangle_count());
  for (std::size_t t = 0; t < shading.triangles.size(); ++t) {
    const ShadingTriangle& triangle = shading.triangles[t];
    const bool upper = t >= shading.character_starts[1];
    EXPECT_EQ(two.character_of(triangle.base), upper ? 1U : 0U);
    for (std::size_t c = 0; c < 3; ++c) {
      const double x = shading.corner(triangle, c).x();
      // The shadow begins at x = -5; the refinement's floor of 0.4 mm is where it may not be told. A ray from
      // the edges at y = +-10 meets the upper square's edge.
      if (upper || x < -5.4) {
        EXPECT_EQ(triangle.irradiance[c], Vec3d::Ones());
      } else if (x > -4.6 && std::abs(shading.corner(triangle, c).y()) < 10.0) {
        EXPECT_EQ(triangle.irradiance[c], Vec3d::Zero());
      }
    }
  }
}

// The largest difference of two meshes' irradiance at a corner, or infinity where they are not refined alike.
double largest_irradiance_difference(std::span<const ShadingTriangle> a, std::span<const ShadingTriangle> b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0.0;
  for (std::size_t t = 0; t < a.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c)
      largest = std::max(largest, (a[t].irradiance[c] - b[t].irradiance[c]).cwiseAbs().maxCoeff());
  }
  return largest;
}

// A character that neither shades another nor is shaded by it leaves its shadows as they are, to the bit,
// however far away it stands and whichever comes first: where a ray starts does not depend on what else the
// scene holds.
TEST(ShadingMesh, ADistantCharacterChangesNothing) {
  const Mesh head = make_builtin("head", {{"edge_mm", 6.0}});
  const Light light = shadowing(Vec3d(0.85, 0.35, 0.4));
  const ShadingMesh alone = shade(head, light);
  for (const double away_mm : {500.0, 20000.0}) {
    const CharacterPlace away{Vec3d(0.0, -away_mm, 0.4 * away_mm), 50.0};
    for (const std::size_t own : {0, 1}) {
      const std::vector<CharacterPlace> places =
          own == 0 ? std::vector<CharacterPlace>{{}, away} : std::vector<CharacterPlace>{away, {}};
      const ShadingMesh two = shade(place_characters(head, places), light);
      EXPECT_EQ(largest_irradiance_difference(alone.character_triangles(0), two.character_triangles(own)),
                0.0)
          << away_mm;
    }
  }
}

}  // namespace
}  // namespace truescatter
