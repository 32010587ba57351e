#include "irradiance/light_fields.h"

#include <utility>

namespace truescatter {
namespace {

bool has_field(const Light& light) { return light.kind != LightKind::environment && light.shadows; }

}  // namespace

CornerIrradiance rest_of_irradiance(const ShadingMesh& shading, const std::vector<LightField>& fields) {
  CornerIrradiance rest(shading.triangles.size());
  for (std::size_t t = 0; t < rest.size(); ++t) {
    rest[t] = shading.triangles[t].irradiance;
    for (const LightField& field : fields) {
      const std::array<Vec3d, 3>& given = field.irradiance.empty() ? rest[t] : field.irradiance[t];
      for (std::size_t c = 0; c < 3; ++c) rest[t][c] -= given[c];
    }
  }
  return rest;
}

std::vector<LightField> light_fields(const ShadingMesh& shading, const Mesh& mesh,
                                     const std::vector<Light>& lights, const NormalMap& normal_map,
                                     const SurfaceAlbedo& albedo) {
  std::vector<Light> with_field;
  for (const Light& light : lights) {
    if (has_field(light)) with_field.push_back(light);
  }
  const bool all = with_field.size() == lights.size();
  if (all && lights.size() == 1) return {{lights.front(), {}}};
  std::vector<LightField> fields;
  for (const Light& light : with_field) {
    if (all && fields.size() + 1 == lights.size()) {
      CornerIrradiance rest = rest_of_irradiance(shading, fields);
      fields.push_back({light, std::move(rest)});
    } else {
      fields.push_back({light, corner_irradiance(shading, Lighting(mesh, {light}, normal_map, albedo))});
    }
  }
  return fields;
}

}  // namespace truescatter
