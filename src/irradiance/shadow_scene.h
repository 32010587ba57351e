#pragma once

#include <cstddef>
#include <memory>

#include "scene/mesh.h"

namespace truescatter {

// Visibility rays against a mesh (Embree). Rays may be traced from any thread.
class ShadowScene {
 public:
  explicit ShadowScene(const Mesh& mesh);
  ~ShadowScene();
  ShadowScene(ShadowScene&&) noexcept;
  ShadowScene& operator=(ShadowScene&&) noexcept;

  // Whether anything lies between `origin_mm` and the point `distance_mm` along the unit `direction`.
  bool occluded(const Vec3d& origin_mm, const Vec3d& direction, double distance_mm) const;

  // Whether the mesh crosses the straight way between two of its points, which lie in the triangles `from`
  // and `to`. These two are passed over, for a line meets a plane but once; so is what lies within
  // offset_mm() of either end, for there single precision finds the triangles across an edge that an end lies
  // close to.
  bool crossed_between(const Vec3d& from_mm, std::size_t from, const Vec3d& to_mm, std::size_t to) const;

  // How far a ray's origin must leave its own facet for single precision not to find it again: 1e-4 of the
  // mesh's extent.
  double offset_mm() const { return offset_mm_; }

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
  double offset_mm_ = 0.0;
};

}  // namespace truescatter
