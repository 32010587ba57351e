#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/vec.h"
#include "irradiance/shadow_scene.h"
#include "scene/mesh.h"

namespace truescatter {

enum class LightKind { directional, point };

// A light without size. Irradiance on a surface that faces it: `color` for a directional light; for a point
// light `color` at the distance `reference_mm`, falling with the square of the distance.
struct Light {
  LightKind kind = LightKind::directional;
  Vec3d direction = Vec3d::UnitZ();   // directional: unit vector from the surface towards the light
  Vec3d position_mm = Vec3d::Zero();  // point
  double reference_mm = 1000.0;       // point; > 0
  Vec3d color = Vec3d::Ones();
  bool shadows = true;
};

// A point on a mesh: a triangle and barycentric coordinates in the order of its corners.
struct MeshPoint {
  std::size_t triangle = 0;
  Vec3d barycentric = Vec3d::Zero();
};

Vec3d position_mm(const Mesh& mesh, const MeshPoint& point);
// The corners' normals interpolated linearly, then made unit length.
Vec3d interpolated_normal(const Mesh& mesh, const MeshPoint& point);

// The real lighting of a surface: I = sum over lights of color * falloff * max(0, n.l) * V, with the
// interpolated normal n and the visibility V of the whole mesh.
//
// A shadow ray starts from the point lifted to the smooth surface that the normals describe (Hanika, Ray
// Tracing Gems II, chapter 4: out of the tangent planes of the three corners, never below the facet), so that
// coarse facets cast no blocks on themselves.
class Lighting {
 public:
  Lighting(const Mesh& mesh, std::vector<Light> lights);

  Vec3d irradiance(const MeshPoint& point) const;
  // An upper bound of any channel of `irradiance` over the mesh: every light unoccluded and facing, and a
  // point light at its distance from the nearest point of any triangle. Infinite where one lies on the mesh.
  double largest_possible() const { return largest_possible_; }

 private:
  double visibility(const Vec3d& origin_mm, const Light& light) const;

  const Mesh& mesh_;
  std::vector<Light> lights_;
  ShadowScene shadows_;
  double largest_possible_ = 0.0;
};

}  // namespace truescatter
