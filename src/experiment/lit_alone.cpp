#include "experiment/lit_alone.h"

namespace truescatter {

ShadingMesh lit_alone(const ShadingMesh& shading, int component) {
  ShadingMesh result = shading;
  for (ShadingTriangle& triangle : result.triangles) {
    if (triangle.component != component) triangle.irradiance.fill(Vec3d::Zero());
  }
  return result;
}

std::vector<LightField> lit_alone(const std::vector<LightField>& lights, const ShadingMesh& shading,
                                  int component) {
  std::vector<LightField> result = lights;
  for (LightField& field : result) {
    for (std::size_t t = 0; t < field.irradiance.size(); ++t) {
      if (shading.triangles[t].component != component) field.irradiance[t].fill(Vec3d::Zero());
    }
  }
  return result;
}

}  // namespace truescatter
