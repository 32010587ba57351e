#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "irradiance/lighting.h"
#include "irradiance/shading_mesh.h"
#include "truth/geodesic_surface.h"
#include "truth/surface.h"

namespace truescatter::test {

// A scene under light with shadows, as a run has it: refined to its shadow edges; all of it skin.
struct LitScene {
  Mesh mesh;
  ShadingMesh shading;
  Surface surface;  // a triangle for each of the shading mesh

  LitScene(Mesh from, const Light& light, const RefinementSettings& settings)
      : mesh(std::move(from)),
        shading(make_shading_mesh(mesh, Lighting(mesh, {light}), SkinMask(), settings)) {
    for (const ShadingTriangle& triangle : shading.triangles) {
      surface.triangles.push_back(
          {{shading.corner(triangle, 0), shading.corner(triangle, 1), shading.corner(triangle, 2)},
           triangle.irradiance,
           triangle.component});
    }
  }

  GeodesicSurface geodesic_surface() const {
    std::vector<GeodesicPiece> pieces;
    for (const ShadingTriangle& triangle : shading.triangles)
      pieces.push_back({triangle.base, triangle.base_barycentric, triangle.irradiance, triangle.component});
    return {IntrinsicMesh(mesh.positions_mm, mesh.triangles), pieces};
  }

  // A point of the shading mesh, as either metric wants it.
  SurfacePoint euclidean(const MeshPoint& point) const {
    const SurfaceTriangle& triangle = surface.triangles[point.triangle];
    Vec3d at = Vec3d::Zero();
    for (std::size_t c = 0; c < 3; ++c)
      at += point.barycentric[static_cast<Eigen::Index>(c)] * triangle.corners_mm[c];
    return {at, triangle.component};
  }
  GeodesicTarget geodesic(const MeshPoint& point) const {
    const ShadingTriangle& triangle = shading.triangles[point.triangle];
    Vec3d at = Vec3d::Zero();
    for (std::size_t c = 0; c < 3; ++c)
      at += point.barycentric[static_cast<Eigen::Index>(c)] * triangle.base_barycentric[c];
    return {{triangle.base, at.cwiseMax(0.0) / at.cwiseMax(0.0).sum()}, triangle.component};
  }
};

}  // namespace truescatter::test
