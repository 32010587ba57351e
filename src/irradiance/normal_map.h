#pragma once

#include <array>
#include <vector>

#include "core/vec.h"
#include "irradiance/mesh_point.h"
#include "scene/mesh.h"
#include "scene/uv_texture.h"

namespace truescatter {

struct NormalMapSettings {
  double strength = 1.0;    // multiplies the relief's slope; 0 is flat
  bool green_down = false;  // green is the slope against v (Direct3D's habit), not along it
};

// Relief in tangent space. A texel (r, g, b) in [0, 1], linear, is the direction
// (strength (2r - 1), +-strength (2g - 1), 2b - 1) in the frame (T, B, N): with 8 bits the flattest texel,
// 128, leans by 1/255 along each axis. What points below the surface (b < 1/2: a damaged texel) is laid into
// it.
//
// N is the interpolated normal. T is the tangent along u: at a corner the mean of dP/du, made perpendicular
// to the corner's normal and unit and weighted with the angle, over the triangles around the vertex that
// share the corner's normal, UV and handedness; inside a triangle interpolated and made perpendicular to N
// (after MikkTSpace). B = N x T, turned round where the triangle is mirrored in UV. So the mapped normal is
// continuous inside a chart; at a chart's border it is not, see Lighting.
class NormalMap {
 public:
  NormalMap() = default;  // no map: the interpolated normal
  // The mesh has UVs; the image has three channels or more.
  NormalMap(const Mesh& mesh, Image image, const NormalMapSettings& settings);

  bool empty() const { return texture_.empty(); }
  // The mapped unit normal; `mesh` as constructed. Where the UVs have no area: the interpolated normal.
  Vec3d normal(const Mesh& mesh, const MeshPoint& point) const;

 private:
  UvTexture texture_;
  NormalMapSettings settings_;
  std::vector<std::array<Vec3d, 3>> corner_tangents_;  // unit; 0 where there is none
  std::vector<double> handedness_;                     // +1, -1 where mirrored in UV, 0 without area
};

}  // namespace truescatter
