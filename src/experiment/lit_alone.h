#pragma once

#include <vector>

#include "irradiance/light_fields.h"
#include "irradiance/shading_mesh.h"

namespace truescatter {

// A scene with one connected piece of its skin lit and everything else dark, for measuring what methods carry
// from one surface to another.

// `shading` with irradiance 0 but on the skin of `component`.
ShadingMesh lit_alone(const ShadingMesh& shading, int component);

// The light fields of `shading`, likewise. One that is all of the mesh's irradiance stays that.
std::vector<LightField> lit_alone(const std::vector<LightField>& lights, const ShadingMesh& shading,
                                  int component);

}  // namespace truescatter
