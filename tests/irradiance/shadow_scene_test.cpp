#include "irradiance/shadow_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "irradiance/mesh_point.h"
#include "scene/builtin.h"

namespace truescatter {
namespace {

// Two slabs 2 mm thick, 4 mm apart along z.
Mesh two_slabs() {
  Mesh mesh = make_builtin("slab", {{"size_mm", 20.0}, {"thickness_mm", 2.0}});
  const Mesh one = mesh;
  const int count = static_cast<int>(one.positions_mm.size());
  for (const Vec3d& p : one.positions_mm) mesh.positions_mm.push_back(p - Vec3d(0.0, 0.0, 6.0));
  for (const auto& t : one.triangles) mesh.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  return mesh;
}

// The middle of the triangle of the face z = z_mm that is nearest to (x, y).
std::pair<Vec3d, std::size_t> on_face(const Mesh& mesh, double x_mm, double y_mm, double z_mm) {
  std::pair<Vec3d, std::size_t> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Vec3d middle = position_mm(mesh, {t, Vec3d::Constant(1.0 / 3.0)});
    const double d = (middle - Vec3d(x_mm, y_mm, z_mm)).norm();
    if (std::abs(middle.z() - z_mm) > 1e-9 || d >= least) continue;
    least = d;
    best = {middle, t};
  }
  return best;
}

// What the straight way between two points of the mesh meets, its own triangles left out.
TEST(ShadowScene, CrossesWhatLiesBetweenTwoOfItsPoints) {
  const Mesh mesh = two_slabs();
  const ShadowScene scene(mesh);
  const auto crossed = [&](double from_z, double to_z, double shift_mm) {
    const auto [from, from_triangle] = on_face(mesh, 0.5, 0.2, from_z);
    const auto [to, to_triangle] = on_face(mesh, 0.5 + shift_mm, 0.2, to_z);
    return scene.crossed_between(from, from_triangle, to, to_triangle);
  };
  for (const double shift_mm : {0.0, 2.0, 7.0}) {
    EXPECT_FALSE(crossed(1.0, -1.0, shift_mm)) << "through the first slab";
    EXPECT_FALSE(crossed(-1.0, -5.0, shift_mm)) << "through the gap";
    EXPECT_TRUE(crossed(1.0, -5.0, shift_mm)) << "out of the first slab's far side";
    EXPECT_TRUE(crossed(1.0, -7.0, shift_mm)) << "through both";
    EXPECT_TRUE(crossed(-7.0, 1.0, shift_mm)) << "and back";
  }
}

// A ball lies on one side of each of its facets, so no ray that starts above a facet and goes up from it
// meets the ball, wherever it stands: 1e5 mm from the origin single precision rounds coordinates by 0.004 mm,
// and the ball's own 1e-4 would be 0.002.
TEST(ShadowScene, ABallDoesNotShadeItselfFarFromTheOrigin) {
  Mesh ball = make_builtin("sphere", {{"radius_mm", 10.0}, {"edge_mm", 2.0}});
  for (const double away_mm : {0.0, 1e5}) {
    Mesh moved = ball;
    for (Vec3d& p : moved.positions_mm) p += Vec3d(away_mm, -away_mm, away_mm);
    const ShadowScene scene(moved);
    int shaded = 0;
    for (std::size_t t = 0; t < moved.triangle_count(); ++t) {
      const Vec3d normal = (moved.corner(t, 1) - moved.corner(t, 0))
                               .cross(moved.corner(t, 2) - moved.corner(t, 0))
                               .normalized();
      const Vec3d along = (moved.corner(t, 1) - moved.corner(t, 0)).normalized();
      const Vec3d origin = position_mm(moved, {t, Vec3d::Constant(1.0 / 3.0)}) + scene.offset_mm(t) * normal;
      for (const double sine : {0.05, 0.3, 1.0}) {
        const Vec3d up = sine * normal + std::sqrt(1.0 - sine * sine) * along;
        if (scene.occluded(origin, up, std::numeric_limits<double>::infinity())) ++shaded;
      }
    }
    EXPECT_EQ(shaded, 0) << away_mm;
  }
}

}  // namespace
}  // namespace truescatter
