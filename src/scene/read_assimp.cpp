// glTF, GLB and FBX through assimp. Positions have the precision of float, which is what glTF stores.
// assimp's readers turn glTF's v, which runs down, so that v is up for every format.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>

#include "core/error.h"
#include "scene/soup.h"

namespace truescatter {
namespace {

Vec3d to_vec3d(const aiVector3D& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

Mat4d to_mat4d(const aiMatrix4x4& m) {
  Mat4d result;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      result(row, column) = static_cast<double>(m[static_cast<unsigned>(row)][static_cast<unsigned>(column)]);
    }
  }
  return result;
}

void check_finite(const Vec3d& position, const SourceLocation& where, const aiMesh& mesh, unsigned vertex) {
  if (position.allFinite()) return;
  throw_input_error(where, "vertex {} of mesh \"{}\" is ({}, {}, {}): coordinates must be finite", vertex,
                    mesh.mName.C_Str(), position.x(), position.y(), position.z());
}

class SceneReader {
 public:
  SceneReader(const aiScene& scene, SourceLocation where) : scene_(scene), where_(std::move(where)) {}

  Soup read() {
    if (scene_.mRootNode != nullptr) add_node(*scene_.mRootNode, Mat4d::Identity());
    return std::move(soup_);
  }

 private:
  void add_node(const aiNode& node, const Mat4d& parent) {
    const Mat4d to_world = parent * to_mat4d(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) add_mesh(*scene_.mMeshes[node.mMeshes[i]], to_world);
    for (unsigned i = 0; i < node.mNumChildren; ++i) add_node(*node.mChildren[i], to_world);
  }

  void add_mesh(const aiMesh& mesh, const Mat4d& to_world) {
    const int first_position = static_cast<int>(soup_.positions.size());
    const int first_uv = mesh.HasTextureCoords(0) ? static_cast<int>(soup_.uvs.size()) : -1;
    const int first_normal = mesh.HasNormals() ? static_cast<int>(soup_.normals.size()) : -1;
    add_vertices(mesh, to_world);
    // A mirroring transform turns the winding round.
    const bool mirrored = to_world.topLeftCorner<3, 3>().determinant() < 0.0;
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;  // points and lines have no surface
      std::vector<SoupCorner> corners;
      for (const unsigned c : {0U, mirrored ? 2U : 1U, mirrored ? 1U : 2U}) {
        check_index(mesh, face.mIndices[c]);
        const int index = static_cast<int>(face.mIndices[c]);
        corners.push_back({first_position + index, first_uv < 0 ? -1 : first_uv + index,
                           first_normal < 0 ? -1 : first_normal + index});
      }
      soup_.add_face(static_cast<int>(soup_.triangles.size()), corners);
    }
  }

  void add_vertices(const aiMesh& mesh, const Mat4d& to_world) {
    // Cofactors instead of the inverse transpose: the same direction, and no division by a zero scale.
    const Mat3d linear = to_world.topLeftCorner<3, 3>();
    Mat3d cofactors;
    cofactors << linear.col(1).cross(linear.col(2)), linear.col(2).cross(linear.col(0)),
        linear.col(0).cross(linear.col(1));
    if (linear.determinant() < 0.0) cofactors = -cofactors;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const Vec3d in_mesh = to_vec3d(mesh.mVertices[i]);
      check_finite(in_mesh, where_, mesh, i);
      soup_.positions.emplace_back((to_world * in_mesh.homogeneous()).head<3>());
      if (mesh.HasNormals()) soup_.normals.emplace_back(cofactors * to_vec3d(mesh.mNormals[i]));
      if (mesh.HasTextureCoords(0)) soup_.uvs.emplace_back(to_vec3d(mesh.mTextureCoords[0][i]).head<2>());
    }
  }

  void check_index(const aiMesh& mesh, unsigned index) const {
    if (index < mesh.mNumVertices) return;
    throw_input_error(where_, "{} is out of range: mesh \"{}\" has {} vertices", index, mesh.mName.C_Str(),
                      mesh.mNumVertices);
  }

  const aiScene& scene_;
  SourceLocation where_;
  Soup soup_;
};

// A binary glTF states its own length: assimp takes a shorter one for no glTF at all.
void check_glb_length(const std::filesystem::path& path, const SourceLocation& where) {
  std::array<unsigned char, 12> header{};  // "glTF", version, length; little endian
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(header.data()), header.size())) return;
  if (std::memcmp(header.data(), "glTF", 4) != 0) return;
  std::uint64_t stated = 0;
  for (std::size_t i = 0; i < 4; ++i) stated |= std::uint64_t{header[8 + i]} << (8 * i);
  const std::uint64_t actual = std::filesystem::file_size(path);
  if (actual < stated) {
    throw_input_error(where, "the file is damaged or cut off: it has {} bytes, and its header says {}",
                      actual, stated);
  }
}

}  // namespace

Soup read_assimp(const std::filesystem::path& path) {
  const SourceLocation where{path.string(), 0, 0};
  check_glb_length(path, where);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_Triangulate);
  if (scene == nullptr) throw_input_error(where, "{}", importer.GetErrorString());
  return SceneReader(*scene, where).read();
}

}  // namespace truescatter
