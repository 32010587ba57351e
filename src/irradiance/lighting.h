#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/vec.h"
#include "irradiance/environment.h"
#include "irradiance/mesh_point.h"
#include "irradiance/normal_map.h"
#include "irradiance/shadow_scene.h"
#include "irradiance/surface_albedo.h"
#include "scene/mesh.h"

namespace truescatter {

enum class LightKind { directional, point, environment };

// A light without size, or one from everywhere. Irradiance on a surface that faces it: `color` for a
// directional light; for a point light `color` at the distance `reference_mm`, falling with the square of the
// distance. An environment is `color` times its radiance; its shadows are directional occlusion, see
// EnvironmentIrradiance.
struct Light {
  LightKind kind = LightKind::directional;
  Vec3d direction = Vec3d::UnitZ();   // directional: unit vector from the surface towards the light
  Vec3d position_mm = Vec3d::Zero();  // point
  double reference_mm = 1000.0;       // point; > 0
  Vec3d color = Vec3d::Ones();
  bool shadows = true;
  EnvironmentSh environment = dark_environment();  // environment: radiance
  int occlusion_rays = 1024;                       // environment, with shadows: > 0
};

// The real lighting of a surface: I = sum over lights of color * falloff * max(0, n.l) * V, with the
// visibility V of the whole mesh and the mapped normal n: without a normal map, the interpolated one. V is
// the geometry's, whatever the map says. An environment adds its irradiance, with the same n and V. The sum
// is multiplied by what of the albedo comes before the scattering.
//
// A shadow ray starts from the point lifted to the smooth surface that the normals describe (Hanika, Ray
// Tracing Gems II, chapter 4: out of the tangent planes of the three corners, never below the facet), so that
// coarse facets cast no blocks on themselves. These normals, too, are the interpolated ones.
class Lighting {
 public:
  Lighting(const Mesh& mesh, const std::vector<Light>& lights, NormalMap normal_map = {},
           SurfaceAlbedo albedo = {});

  // Whether `irradiance` differs from `smooth_irradiance`.
  bool has_maps() const { return !normal_map_.empty() || !albedo_.empty(); }
  Vec3d irradiance(const MeshPoint& point) const;
  // At one place of the surface, given as a point of each triangle that meets there. Where charts of the UV
  // atlas meet, the map has a normal for each: n is the unit mean of those that differ, so that the
  // irradiance is one. Likewise the albedo.
  Vec3d irradiance(std::span<const MeshPoint> place) const;
  // As if there were no normal map and no albedo.
  Vec3d smooth_irradiance(const MeshPoint& point) const;
  // An upper bound of any channel of `smooth_irradiance` over the mesh: every light unoccluded and facing,
  // and a point light at its distance from the nearest point of any triangle. Infinite where one lies on the
  // mesh. Of an environment: see EnvironmentIrradiance.
  double largest_possible() const { return largest_possible_; }

 private:
  Vec3d irradiance(const MeshPoint& point, const Vec3d& normal) const;
  double visibility(const Vec3d& origin_mm, const Light& light) const;
  bool hidden(const Vec3d& origin_mm, const Vec3d& direction) const;

  const Mesh& mesh_;
  std::vector<Light> lights_;  // but for environments
  struct Environment {
    EnvironmentIrradiance irradiance;
    bool occluded;
  };
  std::vector<Environment> environments_;
  NormalMap normal_map_;
  SurfaceAlbedo albedo_;
  ShadowScene shadows_;
  double largest_possible_ = 0.0;
};

}  // namespace truescatter
