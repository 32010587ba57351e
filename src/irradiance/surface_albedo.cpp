#include "irradiance/surface_albedo.h"

#include <algorithm>
#include <vector>

namespace truescatter {
namespace {

Vec2d uv_of(const Mesh& mesh, const MeshPoint& point) {
  Vec2d uv = Vec2d::Zero();
  for (int c = 0; c < 3; ++c)
    uv += point.barycentric[c] * (*mesh.corner_uvs)[point.triangle][static_cast<std::size_t>(c)];
  return uv;
}

}  // namespace

Vec3d power(const Vec3d& colour, double exponent) { return colour.array().pow(exponent); }

Vec3d SurfaceAlbedo::value(const Mesh& mesh, const MeshPoint& point) const {
  if (empty()) return Vec3d::Ones();
  return power(texture_.rgb(uv_of(mesh, point)), exponent_);
}

Vec3d SurfaceAlbedo::value(const Mesh& mesh, std::span<const MeshPoint> place) const {
  if (empty()) return Vec3d::Ones();
  std::vector<Vec2d> uvs;
  Vec3d sum = Vec3d::Zero();
  for (const MeshPoint& point : place) {
    const Vec2d uv = uv_of(mesh, point);
    // One vertex's UV, interpolated in two triangles, differs by rounding.
    const bool known = std::any_of(uvs.begin(), uvs.end(),
                                   [&](const Vec2d& other) { return (other - uv).squaredNorm() < 1e-18; });
    if (known) continue;
    uvs.push_back(uv);
    sum += value(mesh, point);
  }
  return sum / static_cast<double>(uvs.size());
}

}  // namespace truescatter
