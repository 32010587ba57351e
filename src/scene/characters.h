#pragma once

#include <span>

#include "scene/mesh.h"

namespace truescatter {

// Where a character stands: the mesh, turned about its own +y axis, from +z towards +x, then moved.
struct CharacterPlace {
  Vec3d position_mm = Vec3d::Zero();
  double rotation_deg = 0.0;

  bool operator==(const CharacterPlace&) const = default;
};

// A point in the world in the coordinates of the mesh that a character is a copy of.
Vec3d to_own_coordinates(const CharacterPlace& place, const Vec3d& world_mm);

// A copy of `one` (a single character) at each place, in order (one at least). Whether copies meet in space
// is not looked at.
Mesh place_characters(const Mesh& one, std::span<const CharacterPlace> places);

}  // namespace truescatter
