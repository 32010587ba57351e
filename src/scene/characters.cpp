#include "scene/characters.h"

#include <cassert>

namespace truescatter {
namespace {

Mat3d turn_of(const CharacterPlace& place) {
  return Eigen::AngleAxisd(place.rotation_deg * kPi / 180.0, Vec3d::UnitY()).toRotationMatrix();
}

void append(const Mesh& one, const CharacterPlace& place, Mesh& all) {
  const Mat3d turn = turn_of(place);
  const auto first_vertex = static_cast<int>(all.positions_mm.size());
  for (const Vec3d& p : one.positions_mm) all.positions_mm.emplace_back(turn * p + place.position_mm);
  for (std::array<int, 3> triangle : one.triangles) {
    for (int& vertex : triangle) vertex += first_vertex;
    all.triangles.push_back(triangle);
  }
  for (const std::array<Vec3d, 3>& normals : one.corner_normals)
    all.corner_normals.push_back({turn * normals[0], turn * normals[1], turn * normals[2]});
  if (one.corner_uvs)
    all.corner_uvs->insert(all.corner_uvs->end(), one.corner_uvs->begin(), one.corner_uvs->end());
}

}  // namespace

Vec3d to_own_coordinates(const CharacterPlace& place, const Vec3d& world_mm) {
  return turn_of(place).transpose() * (world_mm - place.position_mm);
}

Mesh place_characters(const Mesh& one, std::span<const CharacterPlace> places) {
  assert(one.characters == 1 && !places.empty());
  Mesh all;
  all.characters = places.size();
  if (one.corner_uvs) all.corner_uvs.emplace();
  for (const CharacterPlace& place : places) append(one, place, all);
  return all;
}

}  // namespace truescatter
