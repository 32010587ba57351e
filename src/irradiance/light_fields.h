#pragma once

#include <vector>

#include "irradiance/lighting.h"
#include "irradiance/shading_mesh.h"

namespace truescatter {

// What a light without size that casts shadows gives of a shading mesh's irradiance: for methods that follow
// light from where it comes.
struct LightField {
  Light light;                  // directional or point
  CornerIrradiance irradiance;  // empty: all that the mesh has
};

// One for each light without size that casts shadows, in the order of `lights`; the scene's others (an
// environment, a light without shadows) have none. `lights`, normal map and albedo are those that `shading`
// was lit by.
//
// Each field is its light's own at the corners. Where every light has one, the last is what the others leave
// of the mesh's irradiance, so that they sum to it; a single light's is all of it.
std::vector<LightField> light_fields(const ShadingMesh& shading, const Mesh& mesh,
                                     const std::vector<Light>& lights, const NormalMap& normal_map = {},
                                     const SurfaceAlbedo& albedo = {});

// What fields leave of the mesh's irradiance: that of the scene's other lights.
CornerIrradiance rest_of_irradiance(const ShadingMesh& shading, const std::vector<LightField>& fields);

}  // namespace truescatter
