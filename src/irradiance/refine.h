#pragma once

#include "irradiance/shading_mesh.h"

namespace truescatter {

// The refinement behind make_shading_mesh: triangles with their lighting, before labels and components.
void refine(ShadingMesh& shading, const Mesh& mesh, const Lighting& lighting, const SkinMask& mask,
            const RefinementSettings& settings);

}  // namespace truescatter
