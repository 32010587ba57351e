#pragma once

#include "core/vec.h"
#include "scene/implicit_mesh.h"

namespace truescatter {

// The built-in bust as an implicit function: negative inside, zero on the skin, roughly a distance in mm
// near the skin. It is mirror symmetric in x.
double head_distance_mm(const Vec3d& p_mm);

// Value and gradient of the above, from one set of samples.
ImplicitSample head_sample(const Vec3d& p_mm);

// How finely the skin around a point must be meshed: the target edge length, given the one that is wanted
// where nothing special happens. Thin and tightly curved parts ask for less.
double head_edge_mm(const Vec3d& p_mm, double edge_mm);

// The parts into which the UV atlas is cut.
enum class HeadPart { face, scalp, neck_front, neck_back, base, ear_front, ear_back };
HeadPart head_part(const Vec3d& p_mm);

}  // namespace truescatter
