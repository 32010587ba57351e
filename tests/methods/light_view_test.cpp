#include "methods/light_view.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "support/render.h"

namespace truescatter {
namespace {

void expect_rigid(const Mat4d& view) {
  const Mat3d turn = view.block<3, 3>(0, 0);
  EXPECT_LT((turn * turn.transpose() - Mat3d::Identity()).norm(), 1e-12);
  EXPECT_GT(turn.determinant(), 0.0);
}

// The largest magnitude of a clip coordinate over w, of the whole mesh.
double reach(const ShadingMesh& shading, const LightView& light) {
  double largest = 0.0;
  for (const Vec3d& p : shading.positions_mm) {
    const Vec4d clip = light.projection * light.view * p.homogeneous();
    EXPECT_GT(clip.w(), 0.0);
    largest = std::max(largest, clip.head<3>().cwiseAbs().maxCoeff() / clip.w());
  }
  return largest;
}

TEST(LightView, DirectionalLightSeesTheWholeMeshAndTravelsAlongMinusZ) {
  const ShadingMesh shading = test::shade(make_builtin("slab"), test::lamp(Vec3d::UnitZ()));
  for (const Vec3d& direction :
       {Vec3d(0.0, 0.0, 1.0), Vec3d(0.0, 1.0, 0.0), Vec3d(0.0, -1.0, 0.0), Vec3d(-0.6, 0.3, -0.5)}) {
    const Light light = test::lamp(direction);
    const LightView view = light_view(shading, 0, light);
    EXPECT_FALSE(view.point);
    expect_rigid(view.view);
    EXPECT_LT((view.view.block<3, 3>(0, 0) * light.direction - Vec3d::UnitZ()).norm(), 1e-12);
    EXPECT_LT(reach(shading, view), 1.0);
    EXPECT_GT(reach(shading, view), 0.98);  // and wastes no more than the margin
  }
}

TEST(LightView, PointLightSeesTheWholeMeshFromItsPlace) {
  const ShadingMesh shading = test::shade(make_builtin("sphere"), test::lamp(Vec3d::UnitZ()));
  Light light;
  light.kind = LightKind::point;
  for (const Vec3d& position : {Vec3d(300.0, 50.0, -200.0), Vec3d(0.0, 26.0, 0.0)}) {
    light.position_mm = position;
    const LightView view = light_view(shading, 0, light);
    EXPECT_TRUE(view.point);
    expect_rigid(view.view);
    EXPECT_LT((view.view * position.homogeneous()).head<3>().norm(), 1e-9);
    // From a millimetre above the sphere, radius 25, the tangents lean asin(25 / 26) = 74 degrees.
    EXPECT_LT(reach(shading, view), 1.0);
  }
  // In the middle of it, where nothing is in front of all the mesh.
  light.position_mm = Vec3d::Zero();
  const LightView inside = light_view(shading, 0, light);
  EXPECT_TRUE(inside.view.allFinite() && inside.projection.allFinite());
}

}  // namespace
}  // namespace truescatter
