#pragma once

#include "core/vec.h"
#include "irradiance/lighting.h"
#include "irradiance/shading_mesh.h"

namespace truescatter {

// A character as a light without size sees it, as Camera has its view space: looking along -z, to the middle
// of its bounding box. A directional light sees it in parallel; a point light, at the origin of view space,
// in perspective, and nothing of what lies more than 80 degrees off the middle along either axis.
struct LightView {
  Mat4d view;        // world to the light's view space, mm
  Mat4d projection;  // view to OpenGL clip space; holds the whole character, within the 80 degrees
  bool point;        // else directional: light travels along -z
};

// `light` is directional or a point; `character` of `shading`, from 0, has a triangle. The others do not
// change the view.
LightView light_view(const ShadingMesh& shading, std::size_t character, const Light& light);

}  // namespace truescatter
