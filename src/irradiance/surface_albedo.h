#pragma once

#include <span>
#include <utility>

#include "irradiance/mesh_point.h"
#include "scene/uv_texture.h"

namespace truescatter {

// What of a surface's albedo a colours the light before it scatters: a^exponent, per channel. The rest of it,
// a^(1 - exponent), comes after the scattering (the walkthrough's MIX) and is no part of the irradiance.
class SurfaceAlbedo {
 public:
  SurfaceAlbedo() = default;  // none: 1
  // The texture has three channels or more, none negative; `exponent` in [0, 1]. For meshes with UVs.
  SurfaceAlbedo(UvTexture texture, double exponent) : texture_(std::move(texture)), exponent_(exponent) {}

  // Whether it is 1 everywhere.
  bool empty() const { return texture_.empty() || exponent_ == 0.0; }
  Vec3d value(const Mesh& mesh, const MeshPoint& point) const;
  // At one place, given as a point of each triangle that meets there: the mean over those that differ in UV.
  Vec3d value(const Mesh& mesh, std::span<const MeshPoint> place) const;

 private:
  UvTexture texture_;
  double exponent_ = 0.0;
};

// A colour to a power, per channel; no channel is negative.
Vec3d power(const Vec3d& colour, double exponent);

}  // namespace truescatter
