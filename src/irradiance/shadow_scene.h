#pragma once

#include <cstddef>
#include <memory>
#include <vector>

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
  // their offset_mm() of either end, for there single precision finds the triangles across an edge that an
  // end lies close to.
  bool crossed_between(const Vec3d& from_mm, std::size_t from, const Vec3d& to_mm, std::size_t to) const;

  // How far a ray's origin must leave a facet for single precision not to find it again: 1e-4 of the extent
  // of the facet's character, so that shadows do not depend on what else the scene holds; or 1e-6 of its
  // largest coordinate, where that is more: seventeen times what a coordinate is rounded by.
  double offset_mm(std::size_t triangle) const { return offsets_mm_[triangle / triangles_per_character_]; }
  // Of all facets.
  double largest_offset_mm() const;

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
  std::size_t triangles_per_character_;
  std::vector<double> offsets_mm_;  // of each character
};

}  // namespace truescatter
