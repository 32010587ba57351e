#pragma once

#include <cstddef>

#include "core/vec.h"
#include "scene/mesh.h"

namespace truescatter {

// A point on a mesh: a triangle and barycentric coordinates in the order of its corners.
struct MeshPoint {
  std::size_t triangle = 0;
  Vec3d barycentric = Vec3d::Zero();
};

Vec3d position_mm(const Mesh& mesh, const MeshPoint& point);
// The corners' normals interpolated linearly, then made unit length.
Vec3d interpolated_normal(const Mesh& mesh, const MeshPoint& point);

// Whether two unit normals agree to 1e-9: they are one but for rounding.
bool same_normal(const Vec3d& a, const Vec3d& b);

}  // namespace truescatter
