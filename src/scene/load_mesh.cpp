#include "scene/load_mesh.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "scene/soup.h"

namespace truescatter {
namespace {

// What no mesh of a thing with skin comes near, and what arithmetic still bears: products of four coordinates
// stay finite, and a texel's index stays exact.
constexpr double kFarthestMm = 1e9;
constexpr double kFarthestUv = 1e6;

void check_options(const SourceLocation& where, const LoadOptions& options) {
  if (!std::isfinite(options.unit_mm) || options.unit_mm <= 0.0) {
    throw_input_error(where, "unit_mm is {}: it must be a finite number above 0", options.unit_mm);
  }
  if (options.loop_subdivisions < 0 || options.loop_subdivisions > 6) {
    throw_input_error(where, "loop_subdivisions is {}: it must be 0 to 6", options.loop_subdivisions);
  }
}

Soup read_soup(const std::filesystem::path& path, const SourceLocation& where) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) throw_input_error(where, "there is no such file");
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".obj") return read_obj(path);
  if (extension == ".ply") return read_ply(path);
  if (extension == ".off") return read_off(path);
  if (extension == ".gltf" || extension == ".glb" || extension == ".fbx") return read_assimp(path);
  throw_input_error(where, "\"{}\" is not the extension of a known format: obj, ply, off, gltf, glb, fbx",
                    extension);
}

// Does `has` hold for every corner of every triangle?
template <typename Predicate>
bool every_corner(const Soup& soup, Predicate has) {
  return std::all_of(soup.triangles.begin(), soup.triangles.end(), [&has](const auto& triangle) {
    return std::all_of(triangle.begin(), triangle.end(), has);
  });
}

void copy_positions(const Soup& soup, double unit_mm, const SourceLocation& where, Mesh& mesh) {
  mesh.positions_mm.reserve(soup.positions.size());
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    mesh.positions_mm.emplace_back(unit_mm * soup.positions[i]);
    if (!(mesh.positions_mm.back().cwiseAbs().maxCoeff() <= kFarthestMm)) {
      throw_input_error(where, "vertex {} has a coordinate beyond {} mm: unit_mm is {}", i, kFarthestMm,
                        unit_mm);
    }
  }
}

void copy_triangles(const Soup& soup, bool flip_v, Mesh& mesh) {
  const bool has_uvs = every_corner(soup, [](const SoupCorner& corner) { return corner.uv >= 0; });
  if (has_uvs) mesh.corner_uvs.emplace();
  mesh.triangles.reserve(soup.triangles.size());
  for (const std::array<SoupCorner, 3>& corners : soup.triangles) {
    mesh.triangles.push_back({corners[0].position, corners[1].position, corners[2].position});
    if (!has_uvs) continue;
    std::array<Vec2d, 3> uvs;
    for (std::size_t c = 0; c < 3; ++c) {
      uvs[c] = soup.uvs[static_cast<std::size_t>(corners[c].uv)];
      if (flip_v) uvs[c].y() = 1.0 - uvs[c].y();
    }
    mesh.corner_uvs->push_back(uvs);
  }
}

void check_uvs(const Mesh& mesh, const SourceLocation& where) {
  if (!mesh.corner_uvs) return;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const Vec2d& uv : (*mesh.corner_uvs)[t]) {
      if (!uv.allFinite())
        throw_input_error(where, "triangle {} has a texture coordinate that is not finite", t);
      if (uv.cwiseAbs().maxCoeff() > kFarthestUv)
        throw_input_error(where, "triangle {} has a texture coordinate beyond {}", t, kFarthestUv);
    }
  }
}

// The file's normals at unit length; where one has no length, the angle-weighted normal stays.
void copy_normals(const Soup& soup, Mesh& mesh) {
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d& normal = soup.normals[static_cast<std::size_t>(soup.triangles[t][c].normal)];
      const double length = normal.norm();
      if (std::isfinite(length) && length > 0.0) mesh.corner_normals[t][c] = normal / length;
    }
  }
}

void set_normals(const Soup& soup, NormalSource source, const SourceLocation& where, Mesh& mesh) {
  const bool has_normals = every_corner(soup, [](const SoupCorner& corner) { return corner.normal >= 0; });
  if (source == NormalSource::file && !has_normals) {
    throw_input_error(where, "the file's normals are asked for, and not every corner of it has one");
  }
  set_angle_weighted_normals(mesh);
  if (has_normals && source != NormalSource::angle_weighted) copy_normals(soup, mesh);
}

}  // namespace

LoadedMesh load_mesh_in_file_order(const std::filesystem::path& path, const LoadOptions& options) {
  const SourceLocation where{path.string(), 0, 0};
  check_options(where, options);
  Soup soup = read_soup(path, where);
  if (soup.triangles.empty()) throw_input_error(where, "the file has no triangle");

  LoadedMesh loaded;
  Mesh& mesh = loaded.mesh;
  copy_positions(soup, options.unit_mm, where, mesh);
  copy_triangles(soup, options.flip_v, mesh);
  check_uvs(mesh, where);
  loaded.vertex_of_file_vertex = weld_coincident_positions(mesh);
  set_normals(soup, options.normals, where, mesh);
  loaded.file_face_of_triangle = std::move(soup.face_of_triangle);
  for (int i = 0; i < options.loop_subdivisions; ++i) mesh = loop_subdivide(mesh);
  return loaded;
}

Mesh load_mesh(const std::filesystem::path& path, const LoadOptions& options) {
  return load_mesh_in_file_order(path, options).mesh;
}

}  // namespace truescatter
