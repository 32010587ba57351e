#include "irradiance/shading_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <span>

#include "core/parallel.h"
#include "irradiance/refine.h"

namespace truescatter {
namespace {

void label_skin(ShadingMesh& shading, const SkinMask& mask) {
  for (ShadingTriangle& triangle : shading.triangles) {
    triangle.skin = mask.is_skin((triangle.uvs[0] + triangle.uvs[1] + triangle.uvs[2]) / 3.0);
    triangle.scatters = triangle.skin;
  }
}

// Puts the triangles of each character together, otherwise in their order.
void sort_by_character(ShadingMesh& shading, const Mesh& mesh) {
  if (mesh.characters == 1) return;
  const auto before = [&](const ShadingTriangle& a, const ShadingTriangle& b) {
    return mesh.character_of(a.base) < mesh.character_of(b.base);
  };
  std::stable_sort(shading.triangles.begin(), shading.triangles.end(), before);
  shading.character_starts.clear();
  for (std::size_t t = 0; t < shading.triangles.size(); ++t) {
    if (t == 0 || before(shading.triangles[t - 1], shading.triangles[t]))
      shading.character_starts.push_back(t);
  }
}

void label_components(ShadingMesh& shading) {
  const std::vector<int> components = truescatter::label_components(
      shading.triangles.size(), [&](std::size_t t) { return shading.triangles[t].vertices; },
      [&](std::size_t t) { return shading.triangles[t].scatters; });
  shading.component_count = 0;
  for (std::size_t t = 0; t < components.size(); ++t) {
    shading.triangles[t].component = components[t];
    shading.component_count = std::max(shading.component_count, components[t] + 1);
  }
}

// Replaces the smooth lighting of every corner by that with the normal map and the albedo.
void apply_maps(ShadingMesh& shading, const Lighting& lighting) {
  const CornerIrradiance values = corner_irradiance(shading, lighting);
  for (std::size_t t = 0; t < values.size(); ++t) shading.triangles[t].irradiance = values[t];
}

}  // namespace

CornerIrradiance corner_irradiance(const ShadingMesh& shading, const Lighting& lighting) {
  CornerIrradiance values(shading.triangles.size());
  const CornersByVertex corners(shading.positions_mm.size(), shading.triangles.size(),
                                [&](std::size_t t) { return shading.triangles[t].vertices; });
  parallel_for(shading.positions_mm.size(), [&](std::size_t vertex) {
    const std::span<const std::size_t> around = corners.around(static_cast<int>(vertex));
    std::vector<std::size_t> left(around.begin(), around.end());
    while (!left.empty()) {
      const ShadingTriangle& first = shading.triangles[left.front() / 3];
      const Vec3d normal = first.normals[left.front() % 3];
      const auto others = std::stable_partition(left.begin(), left.end(), [&](std::size_t corner) {
        return same_normal(shading.triangles[corner / 3].normals[corner % 3], normal);
      });
      std::vector<MeshPoint> place;
      for (auto at = left.begin(); at != others; ++at) {
        const ShadingTriangle& triangle = shading.triangles[*at / 3];
        place.push_back({triangle.base, triangle.base_barycentric[*at % 3]});
      }
      const Vec3d irradiance = lighting.irradiance(place);
      for (auto at = left.begin(); at != others; ++at) {
        values[*at / 3][*at % 3] = irradiance;
      }
      left.erase(left.begin(), others);
    }
  });
  return values;
}

ShadingMesh make_shading_mesh(const Mesh& mesh, const Lighting& lighting, const SkinMask& mask,
                              const RefinementSettings& settings) {
  ShadingMesh shading;
  shading.has_uvs = mesh.has_uvs();
  refine(shading, mesh, lighting, mask, settings);
  sort_by_character(shading, mesh);
  if (lighting.has_maps()) apply_maps(shading, lighting);
  label_skin(shading, mask);
  label_components(shading);
  return shading;
}

void scatter_everywhere(ShadingMesh& shading) {
  for (ShadingTriangle& triangle : shading.triangles) triangle.scatters = true;
  label_components(shading);
}

double largest_irradiance(const ShadingMesh& shading) {
  double largest = 0.0;
  for (const ShadingTriangle& triangle : shading.triangles) {
    if (!triangle.scatters) continue;
    for (const Vec3d& value : triangle.irradiance) largest = std::max(largest, value.maxCoeff());
  }
  return largest;
}

ShadingResidual measure_residual(const ShadingMesh& shading, const Lighting& lighting, std::size_t samples,
                                 std::uint64_t seed) {
  std::vector<double> cumulative_area;
  std::vector<std::size_t> scattering;
  double area = 0.0;
  for (std::size_t t = 0; t < shading.triangles.size(); ++t) {
    const ShadingTriangle& triangle = shading.triangles[t];
    if (!triangle.scatters) continue;
    const Vec3d a = shading.corner(triangle, 0);
    area += 0.5 * (shading.corner(triangle, 1) - a).cross(shading.corner(triangle, 2) - a).norm();
    cumulative_area.push_back(area);
    scattering.push_back(t);
  }
  const double largest = largest_irradiance(shading);
  if (scattering.empty() || samples == 0 || !(largest > 0.0)) return {};

  // 53 bits of the generator, for the standard distributions differ between libraries.
  std::mt19937_64 generator(seed);
  const auto uniform = [&] { return static_cast<double>(generator() >> 11U) * 0x1.0p-53; };
  struct Draw {
    std::size_t triangle;
    Vec3d barycentric;
  };
  std::vector<Draw> draws;
  for (std::size_t i = 0; i < samples; ++i) {
    const auto at = std::lower_bound(cumulative_area.begin(), cumulative_area.end(), uniform() * area);
    const double root = std::sqrt(uniform());
    const double b = uniform();
    draws.push_back({scattering[static_cast<std::size_t>(at - cumulative_area.begin())],
                     Vec3d(1.0 - root, root * (1.0 - b), root * b)});
  }
  std::vector<double> errors(samples);
  parallel_for(samples, [&](std::size_t i) {
    const ShadingTriangle& triangle = shading.triangles[draws[i].triangle];
    Vec3d linear = Vec3d::Zero();
    Vec3d barycentric = Vec3d::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
      linear += draws[i].barycentric[static_cast<Eigen::Index>(c)] * triangle.irradiance[c];
      barycentric += draws[i].barycentric[static_cast<Eigen::Index>(c)] * triangle.base_barycentric[c];
    }
    const Vec3d real = lighting.irradiance({triangle.base, barycentric});
    errors[i] = (real - linear).cwiseAbs().maxCoeff() / largest;
  });
  ShadingResidual residual;
  residual.mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(samples);
  const auto p99 = errors.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(samples - 1));
  std::nth_element(errors.begin(), p99, errors.end());
  residual.p99 = *p99;
  return residual;
}

}  // namespace truescatter
