#include "irradiance/mesh_point.h"

namespace truescatter {

Vec3d position_mm(const Mesh& mesh, const MeshPoint& point) {
  Vec3d position = Vec3d::Zero();
  for (int c = 0; c < 3; ++c) position += point.barycentric[c] * mesh.corner(point.triangle, c);
  return position;
}

Vec3d interpolated_normal(const Mesh& mesh, const MeshPoint& point) {
  Vec3d normal = Vec3d::Zero();
  for (int c = 0; c < 3; ++c) {
    normal += point.barycentric[c] * mesh.corner_normals[point.triangle][static_cast<std::size_t>(c)];
  }
  return normal.normalized();
}

bool same_normal(const Vec3d& a, const Vec3d& b) { return (a - b).squaredNorm() < 1e-18; }

}  // namespace truescatter
