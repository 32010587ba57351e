#include "irradiance/normal_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace truescatter {
namespace {

struct TriangleTangent {
  Vec3d along_u = Vec3d::Zero();  // dP/du
  double handedness = 0.0;
};

TriangleTangent tangent_of(const Mesh& mesh, std::size_t t) {
  const std::array<Vec2d, 3>& uv = (*mesh.corner_uvs)[t];
  const Vec2d a = uv[1] - uv[0];
  const Vec2d b = uv[2] - uv[0];
  const double area = a.x() * b.y() - a.y() * b.x();
  const Vec3d along_u = b.y() * (mesh.corner(t, 1) - mesh.corner(t, 0)) -
                        a.y() * (mesh.corner(t, 2) - mesh.corner(t, 0));  // area dP/du
  if (area == 0.0 || along_u.isZero(0.0)) return {};
  return {along_u / area, area > 0.0 ? 1.0 : -1.0};
}

// The unit part of `v` across the unit `normal`; zero where there is none.
Vec3d across(const Vec3d& normal, const Vec3d& v) {
  const Vec3d part = v - normal.dot(v) * normal;
  const double length = part.norm();
  return length > 1e-9 * v.norm() ? Vec3d(part / length) : Vec3d::Zero();
}

}  // namespace

NormalMap::NormalMap(const Mesh& mesh, Image image, const NormalMapSettings& settings)
    : texture_(std::move(image)), settings_(settings) {
  assert(mesh.has_uvs());
  std::vector<TriangleTangent> tangents;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    tangents.push_back(tangent_of(mesh, t));
    handedness_.push_back(tangents.back().handedness);
  }
  const CornersByVertex corners(mesh.positions_mm.size(), mesh.triangle_count(),
                                [&](std::size_t t) { return mesh.triangles[t]; });
  corner_tangents_.resize(mesh.triangle_count());
  for (std::size_t corner = 0; corner < 3 * mesh.triangle_count(); ++corner) {
    const std::size_t t = corner / 3;
    const Vec3d& normal = mesh.corner_normals[t][corner % 3];
    Vec3d sum = Vec3d::Zero();
    for (const std::size_t at : corners.around(mesh.triangles[t][corner % 3])) {
      const std::size_t other = at / 3;
      const std::size_t c = at % 3;
      const bool joined = handedness_[other] == handedness_[t] &&
                          same_normal(mesh.corner_normals[other][c], normal) &&
                          (*mesh.corner_uvs)[other][c] == (*mesh.corner_uvs)[t][corner % 3];
      if (!joined) continue;
      sum += corner_angle_rad(mesh, other, static_cast<int>(c)) * across(normal, tangents[other].along_u);
    }
    corner_tangents_[t][corner % 3] = across(normal, sum);
  }
}

Vec3d NormalMap::normal(const Mesh& mesh, const MeshPoint& point) const {
  Vec3d n = interpolated_normal(mesh, point);
  if (empty()) return n;
  Vec3d tangent = Vec3d::Zero();
  Vec2d uv = Vec2d::Zero();
  for (int c = 0; c < 3; ++c) {
    const auto corner = static_cast<std::size_t>(c);
    tangent += point.barycentric[c] * corner_tangents_[point.triangle][corner];
    uv += point.barycentric[c] * (*mesh.corner_uvs)[point.triangle][corner];
  }
  tangent = across(n, tangent);
  if (tangent.isZero(0.0)) return n;
  const Vec3d bitangent = handedness_[point.triangle] * n.cross(tangent);
  const Vec3d texel = 2.0 * texture_.rgb(uv) - Vec3d::Ones();
  const double green = settings_.green_down ? -texel.y() : texel.y();
  const Vec3d mapped =
      settings_.strength * (texel.x() * tangent + green * bitangent) + std::max(0.0, texel.z()) * n;
  const double length = mapped.norm();
  return length > 0.0 ? Vec3d(mapped / length) : n;
}

}  // namespace truescatter
