#pragma once

#include <functional>

#include "core/vec.h"
#include "scene/mesh.h"

namespace truescatter {

// A function of space, and its gradient, at a point.
struct ImplicitSample {
  double value_mm;  // roughly a distance near the surface
  Vec3d gradient;
};

// A closed surface, given by a function that is negative inside.
struct ImplicitSurface {
  std::function<double(const Vec3d&)> value_mm;
  std::function<ImplicitSample(const Vec3d&)> sample;
  std::function<double(const Vec3d&)> edge_mm;  // wanted edge length at a point
  Vec3d lower_mm;                               // a box that holds the surface
  Vec3d upper_mm;
  double cell_mm;    // of the first, coarse extraction: half of the thinnest part, or less
  double steepness;  // an upper bound of |gradient| where the value is not small
};

// Meshes the surface: a closed manifold of well-shaped triangles of about the wanted size, with vertices
// on the surface. Normals are the function's gradients; there are no UVs. Deterministic.
Mesh mesh_implicit(const ImplicitSurface& surface);

}  // namespace truescatter
