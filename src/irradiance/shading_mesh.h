#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/vec.h"
#include "irradiance/lighting.h"
#include "irradiance/skin_mask.h"
#include "scene/camera.h"
#include "scene/mesh.h"

namespace truescatter {

// One triangle of the shading mesh, a part of one triangle of the scene's mesh.
struct ShadingTriangle {
  std::array<int, 3> vertices{};          // into ShadingMesh::positions_mm
  std::array<Vec3d, 3> normals;           // interpolated, unit
  std::array<Vec3d, 3> irradiance;        // RGB: linear in between is I, by definition
  std::array<Vec2d, 3> uvs;               // zero where the mesh has none
  std::size_t base = 0;                   // the triangle of the scene's mesh
  std::array<Vec3d, 3> base_barycentric;  // of the corners, in the base triangle
  bool skin = true;
  bool scatters = true;   // part of S, which gives and receives light in the truth: skin, or everything
  bool transmits = true;  // methods that draw transmitters draw it; the truth does not know it
  int component = -1;     // connected piece of S; -1 for what is not of it
};

// How well the piecewise linear irradiance resolves the real lighting, in units of the largest irradiance of
// S, over S: no part of any method's error (README, Definitions).
struct ShadingResidual {
  double mean = 0.0;  // area-weighted
  double p99 = 0.0;
};

// The scene's mesh after conforming, in-plane refinement, with the irradiance I that both the methods and the
// truth read (README, Definitions).
struct ShadingMesh {
  std::vector<Vec3d> positions_mm;
  std::vector<ShadingTriangle> triangles;
  std::vector<std::size_t> character_starts = {
      0};  // each character's first triangle; they lie one after the other
  bool has_uvs = false;
  int component_count = 0;
  ShadingResidual residual;

  std::span<const ShadingTriangle> character_triangles(std::size_t character) const {
    const std::size_t end =
        character + 1 < character_starts.size() ? character_starts[character + 1] : triangles.size();
    return std::span(triangles).subspan(character_starts[character], end - character_starts[character]);
  }
  const Vec3d& corner(const ShadingTriangle& triangle, std::size_t c) const {
    return positions_mm[static_cast<std::size_t>(triangle.vertices[c])];
  }
};

struct RefinementSettings {
  double tolerance = 0.02;  // of the largest possible irradiance, in any channel
  double floor_mm = 0.4;    // no edge that is at most this long is split
  // Skin whose front lies in one of these views, hidden or not, has no edge longer than this.
  std::vector<Camera> views = {};
  double visible_edge_mm = std::numeric_limits<double>::infinity();
};

// Refines until, at every edge's midpoint and every triangle's centroid, the real lighting differs from the
// linear value by at most `tolerance`, or edges are down to `floor_mm`; likewise along the mask's border. An
// edge is split for both its triangles; the longest edge of a triangle is split before any other of it
// (Rivara's closure), so that angles stay bounded.
//
// A normal map, or an albedo, is finer than any shadow edge and as fine everywhere: the lighting that asks
// for splits is the smooth one, without them, and `visible_edge_mm` bounds the edges where they are looked
// at. The corners' irradiance is that of the mapped normals, times the albedo; a vertex has one value for all
// the charts that meet there.
//
// S is the skin, in its connected pieces.
ShadingMesh make_shading_mesh(const Mesh& mesh, const Lighting& lighting, const SkinMask& mask,
                              const RefinementSettings& settings);

// Takes all of the surface into S, in its connected pieces: what is not skin is still not measured, nor drawn
// as skin, but gives light to it and receives it (truth.mask_truth = all).
void scatter_everywhere(ShadingMesh& shading);

// The irradiance of every triangle's corners, in the order of ShadingMesh::triangles.
using CornerIrradiance = std::vector<std::array<Vec3d, 3>>;

// What `lighting`, normal map and albedo included, gives at the corners of `shading`, which need not have
// been made by it. The corners around a vertex that share an interpolated normal share the value.
CornerIrradiance corner_irradiance(const ShadingMesh& shading, const Lighting& lighting);

// The largest irradiance of any channel at any corner of S: the unit of every tolerance but the refinement's
// own, for that must be known beforehand.
double largest_irradiance(const ShadingMesh& shading);

// The residual of `shading` against the real lighting at `samples` points of S drawn with `seed`,
// uniform in area. Zero for a shading mesh whose S is dark.
ShadingResidual measure_residual(const ShadingMesh& shading, const Lighting& lighting, std::size_t samples,
                                 std::uint64_t seed);

}  // namespace truescatter
