#include "methods/light_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

namespace truescatter {
namespace {

constexpr double kMargin = 1.01;        // so that the outermost points lie inside the picture
constexpr double kWidestTangent = 5.7;  // tan(80 degrees)

// World to view space: the origin at `eye_mm`, z along the unit vector `back`.
Mat4d looking_along(const Vec3d& back, const Vec3d& eye_mm) {
  const Vec3d up = std::abs(back.y()) < 0.9 ? Vec3d::UnitY() : Vec3d::UnitZ();
  const Vec3d right = up.cross(back).normalized();
  Mat4d m = Mat4d::Identity();
  m.block<1, 3>(0, 0) = right.transpose();
  m.block<1, 3>(1, 0) = back.cross(right).transpose();
  m.block<1, 3>(2, 0) = back.transpose();
  m.block<3, 1>(0, 3) = -m.block<3, 3>(0, 0) * eye_mm;
  return m;
}

std::vector<Vec3d> corners_mm(const ShadingMesh& shading, std::size_t character) {
  std::vector<Vec3d> corners;
  for (const ShadingTriangle& triangle : shading.character_triangles(character)) {
    for (std::size_t c = 0; c < 3; ++c) corners.push_back(shading.corner(triangle, c));
  }
  return corners;
}

// Half the size of the box about the origin that holds the points in this view space, with a margin.
Vec3d half_extent_mm(const std::vector<Vec3d>& points_mm, const Mat4d& view) {
  Vec3d half = Vec3d::Constant(1e-3);
  for (const Vec3d& p : points_mm)
    half = half.cwiseMax((view.block<3, 3>(0, 0) * p + view.block<3, 1>(0, 3)).cwiseAbs());
  return kMargin * half;
}

Mat4d parallel_projection(const Vec3d& half_mm) {
  return Vec4d(1.0 / half_mm.x(), 1.0 / half_mm.y(), -1.0 / half_mm.z(), 1.0).asDiagonal();
}

// The narrowest frustum about -z that holds the points, but for what lies beside or behind the origin.
Mat4d perspective_projection(const std::vector<Vec3d>& points_mm, const Mat4d& view) {
  Vec2d tangent = Vec2d::Constant(1e-3);
  double nearest_mm = std::numeric_limits<double>::infinity();
  double farthest_mm = 0.0;
  for (const Vec3d& p : points_mm) {
    const Vec3d at = view.block<3, 3>(0, 0) * p + view.block<3, 1>(0, 3);
    farthest_mm = std::max(farthest_mm, at.norm());
    nearest_mm = std::min(nearest_mm, -at.z());
    const Vec2d reach = at.head<2>().cwiseAbs();
    // Where z >= 0 the tangent has no bound.
    tangent = tangent.cwiseMax(at.z() < 0.0 ? Vec2d(reach / -at.z()) : Vec2d::Constant(kWidestTangent));
  }
  farthest_mm *= kMargin;
  nearest_mm = std::max(nearest_mm / kMargin, 1e-4 * farthest_mm);
  tangent = (kMargin * tangent).cwiseMin(kWidestTangent);
  Mat4d m = Mat4d::Zero();
  m(0, 0) = 1.0 / tangent.x();
  m(1, 1) = 1.0 / tangent.y();
  m(2, 2) = -(farthest_mm + nearest_mm) / (farthest_mm - nearest_mm);
  m(2, 3) = -2.0 * farthest_mm * nearest_mm / (farthest_mm - nearest_mm);
  m(3, 2) = -1.0;
  return m;
}

}  // namespace

LightView light_view(const ShadingMesh& shading, std::size_t character, const Light& light) {
  const std::vector<Vec3d> points_mm = corners_mm(shading, character);
  assert(light.kind != LightKind::environment && !points_mm.empty());
  Eigen::AlignedBox3d box;
  for (const Vec3d& p : points_mm) box.extend(p);
  const Vec3d middle_mm = box.center();
  if (light.kind == LightKind::directional) {
    const Mat4d view = looking_along(light.direction, middle_mm);
    return {view, parallel_projection(half_extent_mm(points_mm, view)), false};
  }
  const Vec3d away = light.position_mm - middle_mm;
  const Vec3d back = away.norm() > 0.0 ? Vec3d(away.normalized()) : Vec3d(Vec3d::UnitZ());
  const Mat4d view = looking_along(back, light.position_mm);
  return {view, perspective_projection(points_mm, view), true};
}

}  // namespace truescatter
