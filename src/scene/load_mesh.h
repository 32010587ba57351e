#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "scene/mesh.h"

namespace truescatter {

enum class NormalSource {
  automatic,       // the file's where it has them, else angle-weighted
  file,            // the file's; an Error (input) where it has none
  angle_weighted,  // angle-weighted, whatever the file says
};

struct LoadOptions {
  double unit_mm = 1.0;  // millimetres per unit of the file; > 0
  NormalSource normals = NormalSource::automatic;
  int loop_subdivisions = 0;  // 0..6; the normals are angle-weighted where this is not 0
  bool flip_v = false;        // v -> 1 - v, for files that break their format's convention
};

// Loads OBJ, PLY, OFF (own readers, in double precision), glTF, GLB, FBX (assimp, in float), by the file's
// extension. Polygons are triangulated, node transforms are applied, exactly coincident positions are
// joined, UVs are kept per corner with v up (none, unless every corner has one). Triangles keep the file's
// order, vertices that of their first mention. Degenerate triangles are kept: they have no area and do no
// harm. Faces at non-manifold edges are kept too.
//
// Throws Error (input) that names the file, and the line where the format is a text: no such file, unknown
// extension, no triangle, a coordinate that is not finite or absurdly large, an index out of range, `unit_mm`
// not positive, normals asked for that the file does not have.
Mesh load_mesh(const std::filesystem::path& path, const LoadOptions& options);

// The same, for callers that have data by the file's vertices or faces.
struct LoadedMesh {
  Mesh mesh;
  std::vector<int> vertex_of_file_vertex;  // of each vertex of the file (OBJ: each `v` line), in file order
  // The file's face of each triangle before subdivision, from 0; the identity where all are triangles.
  // Subdivision puts the children of triangle t at 4 t .. 4 t + 3.
  std::vector<int> file_face_of_triangle;
};

LoadedMesh load_mesh_in_file_order(const std::filesystem::path& path, const LoadOptions& options);

// One step of Loop subdivision (positions: Loop 1987 with Warren's weights, boundary rule for open edges;
// UVs: linear, so that seams stay where they are; normals: angle-weighted afterwards). An edge of three
// or more triangles counts as open. Vertices keep their index; the children of triangle t are 4 t .. 4 t + 3.
Mesh loop_subdivide(const Mesh& mesh);

// What is wrong with a mesh's UVs, counted over triangles, and how dense they are.
struct UvReport {
  std::size_t triangles = 0;
  std::size_t outside_unit_square = 0;  // triangles with a corner outside [0, 1]^2 by more than 1e-6
  std::size_t flipped = 0;              // wound against the majority of the UV area
  std::size_t zero_area = 0;            // UV area below 1e-12 while the triangle has area in space
  std::size_t overlapping = 0;          // share interior points with another triangle in UV, deeper than 1e-7
  double mm_per_unit_median = 0.0;      // sqrt(area in space / area in UV), area-weighted quantiles:
  double mm_per_unit_p05 = 0.0;         //   divided by the texture size this is mm per texel
  double mm_per_unit_p95 = 0.0;
  double anisotropy_p95 = 1.0;  // largest over smallest singular value of dP/duv
};

// Only `triangles` is set for a mesh without UVs.
UvReport inspect_uvs(const Mesh& mesh);

// The larger over the smaller singular value of a triangle's map from UV to the surface, at least 1 but for
// rounding; infinite or not a number where the triangle has no area in UV.
double uv_anisotropy(const Mesh& mesh, std::size_t triangle);

}  // namespace truescatter
