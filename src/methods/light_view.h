#pragma once

#include "core/vec.h"
#include "irradiance/lighting.h"
#include "irradiance/shading_mesh.h"

namespace truescatter {

// A mesh as a light without size sees it, as Camera has its view space: looking along -z, to the middle of
// the mesh's bounding box. A directional light sees it in parallel; a point light, at the origin of view
// space, in perspective, and nothing of what lies more than 80 degrees off the middle along either axis.
struct LightView {
  Mat4d view;        // world to the light's view space, mm
  Mat4d projection;  // view to OpenGL clip space; holds the whole mesh, within the 80 degrees
  bool point;        // else directional: light travels along -z
};

// `light` is directional or a point, `shading` not empty.
LightView light_view(const ShadingMesh& shading, const Light& light);

}  // namespace truescatter
