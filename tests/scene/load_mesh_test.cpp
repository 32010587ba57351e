#include "scene/load_mesh.h"

#include <gtest/gtest.h>

// MeshIO must come before the kernels, says OpenMesh.
#include <OpenMesh/Core/IO/MeshIO.hh>
//
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/error.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;

class LoadMesh : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) const {
    return temporary_.write(name, bytes);
  }

  LoadedMesh load(const std::string& name, const std::string& bytes, const LoadOptions& options = {}) const {
    return load_mesh_in_file_order(write(name, bytes), options);
  }

  // The error's message behind the folder's name.
  std::string error_of(const std::string& name, const std::string& bytes,
                       const LoadOptions& options = {}) const {
    return error_of_path(write(name, bytes), options);
  }

  std::string error_of_path(const fs::path& path, const LoadOptions& options = {}) const {
    try {
      load_mesh(path, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::input);
      const std::string message = error.what();
      const std::string start = folder_.string() + "/";
      return message.rfind(start, 0) == 0 ? message.substr(start.size()) : message;
    }
    return "no error";
  }

  const test::TempDir temporary_;
  const fs::path folder_ = temporary_.path();
};

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST_F(LoadMesh, ObjKeepsDoublePrecisionAndFileOrder) {
  const LoadedMesh loaded =
      load("a.obj", "v 0.1 0.2 0.3\nv 1.00000000000001 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 4 3 2\n");
  EXPECT_EQ(loaded.mesh.positions_mm[0], Vec3d(0.1, 0.2, 0.3));
  EXPECT_EQ(loaded.mesh.positions_mm[1].x(), 1.00000000000001);
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}, {3, 2, 1}}));
  EXPECT_EQ(loaded.vertex_of_file_vertex, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(loaded.file_face_of_triangle, (std::vector<int>{0, 1}));
  EXPECT_FALSE(loaded.mesh.has_uvs());
}

TEST_F(LoadMesh, ObjReadsEveryFormOfAFace) {
  const std::string attributes = kTriangle + "vt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n";
  for (const char* face : {"f 1 2 3", "f 1/1 2/2 3/3", "f 1//1 2//1 3//1", "f 1/1/1 2/2/1 3/3/1",
                           "f -3 -2 -1", "f -3/-3/-1 -2/-2/-1 -1/-1/-1", "f 1/1/ 2/2/ 3/3/", "f\t1  2 3   ",
                           "f 1 2 \\\n 3", "f 1 2 3 # a comment", "f +1 2 3\r"}) {
    const LoadedMesh loaded = load("a.obj", attributes + face + "\n");
    ASSERT_EQ(loaded.mesh.triangles.size(), 1U) << face;
    EXPECT_EQ(loaded.mesh.triangles[0], (std::array<int, 3>{0, 1, 2})) << face;
    EXPECT_EQ(loaded.mesh.corner_normals[0][0], Vec3d::UnitZ()) << face;
    const std::string text = face;
    const bool has_uvs = text.find('/') != std::string::npos && text.find("//") == std::string::npos;
    ASSERT_EQ(loaded.mesh.has_uvs(), has_uvs) << face;
    if (has_uvs) {
      EXPECT_EQ((*loaded.mesh.corner_uvs)[0][1], Vec2d(1, 0)) << face;
    }
  }
}

TEST_F(LoadMesh, ObjNegativeIndicesCountFromWhereTheyStand) {
  const LoadedMesh loaded = load("a.obj", kTriangle + "f -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\n");
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}, {3, 4, 5}}));
}

TEST_F(LoadMesh, ObjFacesMayComeBeforeTheirVertices) {
  EXPECT_EQ(load("a.obj", "f 1 2 3\n" + kTriangle).mesh.triangles.size(), 1U);
}

TEST_F(LoadMesh, ObjIgnoresWhatIsNotGeometry) {
  const LoadedMesh loaded =
      load("a.obj", "\xEF\xBB\xBF# head\nmtllib none.mtl\no thing\ng a b\ns off\nusemtl skin\n" +
                        std::string("v 0 0 0 0.5 0.5 0.5\nv 1 0 0 1\n\n  v 0 1 0\nl 1 2\nf 1 2 3"));
  EXPECT_EQ(loaded.mesh.triangles.size(), 1U);
}

TEST_F(LoadMesh, ObjKeepsDegenerateAndNonManifoldFaces) {
  const LoadedMesh loaded =
      load("a.obj",
           "v 0 0 0\nv 0 0 1\nv 1 0 0\nv -1 1 0\nv -1 -1 0\nf 1 2 3\nf 1 1 2\nf 1 2 4\nf 1 2 5\nf 3 2 1\n");
  EXPECT_EQ(loaded.mesh.triangles.size(), 5U);
  EXPECT_EQ(loaded.mesh.triangles[1], (std::array<int, 3>{0, 0, 1}));
  for (const auto& normals : loaded.mesh.corner_normals) {
    for (const Vec3d& normal : normals) EXPECT_NEAR(normal.norm(), 1.0, 1e-15);
  }
}

TEST_F(LoadMesh, ConvexPolygonsBecomeFans) {
  const LoadedMesh loaded =
      load("a.obj", "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\nf 1 2 3\n");
  EXPECT_EQ(loaded.mesh.triangles,
            (std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 1, 2}}));
  EXPECT_EQ(loaded.file_face_of_triangle, (std::vector<int>{0, 0, 0, 1}));
}

TEST_F(LoadMesh, ConcavePolygonsKeepTheirArea) {
  // An L of area 3, begun at each of its corners; and an arrow head of area 2 - 1 = 1.
  const std::string l_shape = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
  for (int start = 0; start < 6; ++start) {
    std::string face = "f";
    for (int i = 0; i < 6; ++i) face.append(" ").append(std::to_string((start + i) % 6 + 1));
    const LoadedMesh loaded = load("a.obj", l_shape + face + "\n");
    EXPECT_EQ(loaded.mesh.triangles.size(), 4U);
    EXPECT_NEAR(surface_area_mm2(loaded.mesh), 3.0, 1e-15);
    for (std::size_t t = 0; t < 4; ++t) EXPECT_GT(triangle_normal(loaded.mesh, t).z(), 0.0);
  }
  const LoadedMesh arrow = load("b.obj", "v -1 0 0\nv 0 1 0\nv 1 0 0\nv 0 2 0\nf 1 2 3 4\n");
  EXPECT_NEAR(surface_area_mm2(arrow.mesh), 1.0, 1e-15);
}

TEST_F(LoadMesh, PositionsSplitAtUvSeamsAreOneVertex) {
  // The edge x = 1 is there twice, with other UVs.
  const LoadedMesh loaded = load("a.obj",
                                 "v 0 0 0\nv 1 0 -0.0\nv 1 1 0\nv 1 0 0\nv 2 0 0\nv 1 1 0\n"
                                 "vt 0 0\nvt 0.4 0\nvt 0.4 1\nvt 0.6 0\nvt 1 0\nvt 0.6 1\n"
                                 "f 1/1 2/2 3/3\nf 4/4 5/5 6/6\n");
  EXPECT_EQ(loaded.mesh.positions_mm.size(), 4U);
  EXPECT_EQ(loaded.vertex_of_file_vertex, (std::vector<int>{0, 1, 2, 1, 3, 2}));
  EXPECT_EQ(loaded.mesh.triangles[1], (std::array<int, 3>{1, 3, 2}));
  EXPECT_EQ((*loaded.mesh.corner_uvs)[0][1], Vec2d(0.4, 0));
  EXPECT_EQ((*loaded.mesh.corner_uvs)[1][0], Vec2d(0.6, 0));
}

TEST_F(LoadMesh, UvsAreNoneUnlessEveryCornerHasThem) {
  EXPECT_FALSE(load("a.obj", kTriangle + "vt 0 0\nf 1/1 2/1 3/1\nf 1 2 3\n").mesh.has_uvs());
  EXPECT_FALSE(load("a.obj", kTriangle + "vt 0 0\nf 1/1 2/1 3\n").mesh.has_uvs());
}

TEST_F(LoadMesh, FlipVTurnsV) {
  LoadOptions options;
  options.flip_v = true;
  const LoadedMesh loaded = load("a.obj", kTriangle + "vt 0.25 0.25\nf 1/1 2/1 3/1\n", options);
  EXPECT_EQ((*loaded.mesh.corner_uvs)[0][0], Vec2d(0.25, 0.75));
}

TEST_F(LoadMesh, UnitScalesPositionsOnly) {
  LoadOptions options;
  options.unit_mm = 25.4;
  const LoadedMesh loaded = load("a.obj", kTriangle + "vt 0.5 1\nvn 0 0 2\nf 1/1/1 2/1/1 3/1/1\n", options);
  EXPECT_EQ(loaded.mesh.positions_mm[1], Vec3d(25.4, 0, 0));
  EXPECT_EQ((*loaded.mesh.corner_uvs)[0][1], Vec2d(0.5, 1));
  EXPECT_EQ(loaded.mesh.corner_normals[0][1], Vec3d(0, 0, 1));
}

TEST_F(LoadMesh, NormalsComeFromWhereTheyAreAskedFor) {
  const std::string with = kTriangle + "vn 1 0 0\nvn 0 0 0\nf 1//1 2//1 3//2\n";
  const std::string without = kTriangle + "vn 1 0 0\nf 1//1 2//1 3\n";
  LoadOptions options;
  // Where the file's normal has no length, the angle-weighted one stands in.
  EXPECT_EQ(load("a.obj", with, options).mesh.corner_normals[0][0], Vec3d::UnitX());
  EXPECT_EQ(load("a.obj", with, options).mesh.corner_normals[0][2], Vec3d::UnitZ());
  EXPECT_EQ(load("a.obj", without, options).mesh.corner_normals[0][0], Vec3d::UnitZ());
  options.normals = NormalSource::file;
  EXPECT_EQ(load("a.obj", with, options).mesh.corner_normals[0][0], Vec3d::UnitX());
  EXPECT_EQ(error_of("a.obj", without, options),
            "a.obj: the file's normals are asked for, and not every corner of it has one");
  options.normals = NormalSource::angle_weighted;
  EXPECT_EQ(load("a.obj", with, options).mesh.corner_normals[0][0], Vec3d::UnitZ());
}

TEST_F(LoadMesh, SubdividesOnLoading) {
  LoadOptions options;
  options.loop_subdivisions = 2;
  EXPECT_EQ(load("a.obj", kTriangle + "f 1 2 3\n", options).mesh.triangles.size(), 16U);
}

TEST_F(LoadMesh, OptionsOutOfRangeAreErrors) {
  LoadOptions options;
  for (const double unit : {0.0, -1.0}) {
    options.unit_mm = unit;
    EXPECT_NE(error_of("a.obj", kTriangle + "f 1 2 3\n", options).find("it must be a finite number above 0"),
              std::string::npos);
  }
  options.unit_mm = HUGE_VAL;
  EXPECT_EQ(error_of("a.obj", "", options), "a.obj: unit_mm is inf: it must be a finite number above 0");
  options.unit_mm = 1e308;
  EXPECT_EQ(error_of("a.obj", "v 0 0 0\nv 10 0 0\nv 0 1 0\nf 1 2 3\n", options),
            "a.obj: vertex 1 has a coordinate beyond 1000000000 mm: unit_mm is 1e+308");
  options = {};
  options.loop_subdivisions = 7;
  EXPECT_EQ(error_of("a.obj", "", options), "a.obj: loop_subdivisions is 7: it must be 0 to 6");
}

TEST_F(LoadMesh, FilesThatAreNotThereOrUnknownOrEmptyAreErrors) {
  EXPECT_EQ(error_of_path(folder_ / "none.obj"), "none.obj: there is no such file");
  EXPECT_EQ(error_of_path(folder_), folder_.string() + ": there is no such file");
  EXPECT_EQ(error_of("a.stl", ""),
            "a.stl: \".stl\" is not the extension of a known format: obj, ply, off, gltf, glb, fbx");
  EXPECT_EQ(error_of("a.obj", ""), "a.obj: the file has no triangle");
  EXPECT_EQ(error_of("a.obj", kTriangle), "a.obj: the file has no triangle");
  EXPECT_EQ(error_of("a.off", "OFF\n0 0 0\n"), "a.off: the file has no triangle");
  EXPECT_EQ(load("UPPER.OBJ", kTriangle + "f 1 2 3\n").mesh.triangles.size(), 1U);
}

TEST_F(LoadMesh, ObjErrorsNameTheLine) {
  const std::string face = "f 1 2 3\n";
  EXPECT_EQ(error_of("a.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\n" + face),
            "a.obj:2: \"nan\" is not finite: a coordinate must be a finite number");
  EXPECT_EQ(error_of("a.obj", "# c\n\nv 0 0 -inf\n"),
            "a.obj:3: \"-inf\" is not finite: a coordinate must be a finite number");
  EXPECT_EQ(error_of("a.obj", "v 0 1e999 0\n"),
            "a.obj:1: \"1e999\" is not finite: a coordinate must be a finite number");
  EXPECT_EQ(error_of("a.obj", "v 0 0,5 0\n"),
            "a.obj:1: \"0,5\" is not a number: a coordinate must be a finite number");
  EXPECT_EQ(error_of("a.obj", "v 0 0\n"), "a.obj:1: \"v\" has 2 numbers, and needs 3");
  EXPECT_EQ(error_of("a.obj", "vt x 0\n"),
            "a.obj:1: \"x\" is not a number: a texture coordinate must be a finite number");
  EXPECT_EQ(error_of("a.obj", "vt\n"), "a.obj:1: \"vt\" has no number, and needs 1 or more");
  EXPECT_EQ(error_of("a.obj", "vn 0 0 inf\n"),
            "a.obj:1: \"inf\" is not finite: a normal's component must be a finite number");
  EXPECT_EQ(error_of("a.obj", kTriangle + "f 1 2 4\n"),
            "a.obj:4: 4 is out of range: a vertex index is at most 3 here");
  EXPECT_EQ(error_of("a.obj", kTriangle + "f 0 1 2\n"),
            "a.obj:4: 0 is not a vertex index: indices count from 1");
  EXPECT_EQ(error_of("a.obj", kTriangle + "f -4 1 2\n"),
            "a.obj:4: -4 is out of range: a vertex index counts back over the 3 before it");
  EXPECT_EQ(error_of("a.obj", kTriangle + "vt 0 0\nf 1/1 2/2 3/1\n"),
            "a.obj:5: 2 is out of range: a texture coordinate's index is at most 1 here");
  EXPECT_EQ(error_of("a.obj", kTriangle + "f 1//1 2//1 3//1\n"),
            "a.obj:4: 1 is out of range: a normal's index is at most 0 here");
  EXPECT_EQ(error_of("a.obj", kTriangle + "f 1 2\n"), "a.obj:4: a face has 2 corners, and needs 3 or more");
  EXPECT_EQ(error_of("a.obj", kTriangle + "f 1 2 x\n"),
            "a.obj:4: \"x\" is not a whole number that a vertex index can be");
  EXPECT_EQ(error_of("a.obj", kTriangle + "f 1 2 3.5\n"),
            "a.obj:4: \"3.5\" is not a whole number that a vertex index can be");
  EXPECT_EQ(error_of("a.obj", kTriangle + "f 1 2 99999999999\n"),
            "a.obj:4: \"99999999999\" is not a whole number that a vertex index can be");
  // Joined lines keep counting.
  EXPECT_EQ(error_of("a.obj", "v 0 \\\n0 0\nv 0 0 x\n"),
            "a.obj:3: \"x\" is not a number: a coordinate must be a finite number");
}

TEST_F(LoadMesh, AbsurdlyLargeCoordinatesAreErrors) {
  EXPECT_EQ(error_of("a.obj", "v 0 0 0\nv 0 -1e30 0\nv 0 1 0\nf 1 2 3\n"),
            "a.obj: vertex 1 has a coordinate beyond 1000000000 mm: unit_mm is 1");
  // Reading a texture there would leave the range of its texels' indices.
  EXPECT_EQ(error_of("a.obj", kTriangle + "vt 0 0\nvt 0 1e308\nf 1/1 2/2 3/1\n"),
            "a.obj: triangle 0 has a texture coordinate beyond 1000000");
}

TEST_F(LoadMesh, TinyNumbersAreZero) {
  EXPECT_EQ(load("a.obj", "v 1e-999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").mesh.positions_mm[0], Vec3d(0, 0, 0));
}

TEST_F(LoadMesh, OffReadsPlainAndPrefixedFiles) {
  const LoadedMesh plain =
      load("a.off",
           "OFF\n# a comment\n4 2 5\n0.1 0 0\n1 0 0\n\n1 1 0 # corner\n0 1 0\n3 0 1 2 255 0 0\n4 0 1 2 3\n");
  EXPECT_EQ(plain.mesh.positions_mm[0].x(), 0.1);
  EXPECT_EQ(plain.mesh.triangles.size(), 3U);
  EXPECT_EQ(plain.file_face_of_triangle, (std::vector<int>{0, 1, 1}));

  const LoadedMesh full = load("b.off",
                               "STCNOFF 3 1 0\n0 0 0 0 0 2 9 9 9 9 0.25 0.5\n1 0 0 0 0 1 9 9 9 9 1 0\n0 1 0 "
                               "0 0 1 9 9 9 9 0 1\n3 0 1 2\n");
  EXPECT_EQ(full.mesh.corner_normals[0][0], Vec3d::UnitZ());
  EXPECT_EQ((*full.mesh.corner_uvs)[0][0], Vec2d(0.25, 0.5));
}

TEST_F(LoadMesh, OffErrorsNameTheLine) {
  EXPECT_EQ(error_of("a.off", "PLY\n"),
            "a.off:1: \"PLY\" is not the first word of an OFF file: [ST][C][N]OFF");
  EXPECT_EQ(error_of("a.off", "OFF BINARY\n"), "a.off:1: \"BINARY\": only the text form of OFF is read");
  EXPECT_EQ(error_of("a.off", "OFF\n3\n"), "a.off:2: the counts of vertices and faces are missing");
  EXPECT_EQ(error_of("a.off", "OFF\n-3 1 0\n"), "a.off:2: \"-3 1\": a count must not be negative");
  EXPECT_EQ(error_of("a.off", "OFF\n3 1 0\n0 0 0\n1 0 nan\n"),
            "a.off:4: \"nan\" is not finite: a coordinate must be a finite number");
  EXPECT_EQ(error_of("a.off", "OFF\n3 1 0\n0 0\n"), "a.off:3: a vertex has 2 numbers, and needs 3");
  const std::string vertices = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(error_of("a.off", vertices + "3 0 1 3\n"),
            "a.off:6: 3 is out of range: a vertex index is 0 to 2 here");
  EXPECT_EQ(error_of("a.off", vertices + "3 0 1 -1\n"),
            "a.off:6: -1 is out of range: a vertex index is 0 to 2 here");
  EXPECT_EQ(error_of("a.off", vertices + "2 0 1\n"), "a.off:6: a face has 2 corners, and needs 3 or more");
  EXPECT_EQ(error_of("a.off", vertices + "3 0 1\n"),
            "a.off:6: a face names 2 vertices, and says that it has 3");
  EXPECT_NE(error_of("a.off", vertices).find("the file ends where a face should follow"), std::string::npos);
}

const std::string kPlyHeader =
    "element vertex 3\nproperty double x\nproperty double y\nproperty double z\nproperty float s\nproperty "
    "float t\n"
    "element face 1\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n";

TEST_F(LoadMesh, PlyReadsText) {
  const LoadedMesh loaded = load("a.ply", "ply\nformat ascii 1.0\ncomment made by hand\n" + kPlyHeader +
                                              "0.1 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n7 3 0 1 2\n");
  EXPECT_EQ(loaded.mesh.positions_mm[0].x(), 0.1);
  EXPECT_EQ(loaded.mesh.triangles[0], (std::array<int, 3>{0, 1, 2}));
  EXPECT_EQ((*loaded.mesh.corner_uvs)[0][2], Vec2d(0, 1));
}

TEST_F(LoadMesh, PlyReadsNormalsPolygonsWedgeUvsAndUnknownElements) {
  const LoadedMesh loaded =
      load("a.ply",
           "ply\nformat ascii 1.0\nelement camera 1\nproperty float view\nproperty list uchar int junk\n"
           "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
           "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n"
           "element face 1\nproperty list uchar uint vertex_index\nproperty list uchar float "
           "texcoord\nend_header\n"
           "1.5 2 8 9\n0 0 0 1 0 0 255\n1 0 0 1 0 0 255\n1 1 0 1 0 0 255\n0 1 0 1 0 0 255\n"
           "4 0 1 2 3 8 0 0 0.5 0 0.5 0.5 0 0.5\n");
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(loaded.mesh.corner_normals[1][2], Vec3d::UnitX());
  EXPECT_EQ((*loaded.mesh.corner_uvs)[1][1], Vec2d(0.5, 0.5));
  EXPECT_EQ((*loaded.mesh.corner_uvs)[1][2], Vec2d(0, 0.5));
}

// The bytes of a value, in either order.
template <typename T>
std::string bytes_of(T value, bool big_endian) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string binary_ply(bool big_endian, double first_x, std::int32_t last_index) {
  std::string text =
      "ply\nformat binary_" + std::string(big_endian ? "big" : "little") + "_endian 1.0\n" + kPlyHeader;
  const std::array<std::array<double, 3>, 3> positions{{{first_x, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  for (const auto& position : positions) {
    for (const double x : position) text += bytes_of(x, big_endian);
    text += bytes_of(0.25F, big_endian) + bytes_of(0.75F, big_endian);
  }
  text += "\x07\x03";
  for (const std::int32_t index : {0, 1, last_index}) text += bytes_of(index, big_endian);
  return text;
}

TEST_F(LoadMesh, PlyReadsBinaryOfBothByteOrders) {
  for (const bool big_endian : {false, true}) {
    const LoadedMesh loaded = load("a.ply", binary_ply(big_endian, 0.1, 2));
    EXPECT_EQ(loaded.mesh.positions_mm[0], Vec3d(0.1, 0, 0));
    EXPECT_EQ(loaded.mesh.triangles[0], (std::array<int, 3>{0, 1, 2}));
    EXPECT_EQ((*loaded.mesh.corner_uvs)[0][1], Vec2d(0.25, 0.75));
  }
}

TEST_F(LoadMesh, PlyErrorsNameTheLineOrTheValue) {
  const std::string ascii = "ply\nformat ascii 1.0\n";
  const std::string vertices = "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n";  // lines 13 to 15
  EXPECT_EQ(error_of("a.ply", "hello\n"), "a.ply:1: the first line of a PLY file must be \"ply\"");
  EXPECT_EQ(error_of("a.ply", "ply\nformat text 1.0\n"),
            "a.ply:2: \"text\" is not ascii, binary_little_endian or binary_big_endian");
  EXPECT_EQ(error_of("a.ply", ascii + "element vertex 3\nproperty half x\n"),
            "a.ply:4: \"half\" is not a type of PLY");
  EXPECT_EQ(error_of("a.ply", ascii + "elements vertex 3\n"),
            "a.ply:3: \"elements\" is not a keyword of a PLY header");
  EXPECT_NE(error_of("a.ply", ascii + "element vertex 3\n").find("the file ends before \"end_header\""),
            std::string::npos);
  EXPECT_EQ(error_of("a.ply", ascii + "element vertex 1\nproperty float x\nend_header\n1\n"),
            "a.ply: the element \"vertex\" needs the properties x, y and z");
  EXPECT_EQ(error_of("a.ply", ascii + kPlyHeader + "0 0 0 0 0\n1 nan 0 1 0\n"),
            "a.ply:14: \"nan\" is not finite: a coordinate must be a finite number");
  EXPECT_EQ(error_of("a.ply", ascii + kPlyHeader + vertices + "7 3 0 1 3\n"),
            "a.ply:16: 3 is out of range: a vertex index is 0 to 2 here");
  EXPECT_EQ(error_of("a.ply", ascii + kPlyHeader + vertices + "7 2 0 1\n"),
            "a.ply:16: face 0 has 2 corners, and needs 3 or more");
  EXPECT_NE(error_of("a.ply", ascii + kPlyHeader + vertices + "7 3 0 1\n")
                .find("the file ends where a vertex index"),
            std::string::npos);
  EXPECT_EQ(error_of("a.ply", binary_ply(false, 0.0, 3)),
            "a.ply: 3 is out of range: a vertex index is 0 to 2 here");
  EXPECT_EQ(error_of("a.ply", binary_ply(false, HUGE_VAL, 2)),
            "a.ply: vertex 0: inf is not finite: a coordinate must be a finite number");
  const std::string whole = binary_ply(false, 0.0, 2);
  EXPECT_EQ(error_of("a.ply", whole.substr(0, whole.size() - 1)),
            "a.ply: the file ends where a vertex index should follow");
}

std::string base64(const std::string& bytes) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? alphabet[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

// One triangle (0,0,0), (1,0,0), (0,1,0) with normals +z and UVs (0.25,0), (1,0.25), (0,1), under `nodes`.
std::string gltf(const std::string& nodes, const std::string& scene_nodes, float first_x = 0.0F) {
  std::string bytes;
  for (const float x : {first_x, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) bytes += bytes_of(x, false);
  for (int i = 0; i < 3; ++i) bytes += bytes_of(0.F, false) + bytes_of(0.F, false) + bytes_of(1.F, false);
  for (const float x : {0.25F, 0.F, 1.F, 0.25F, 0.F, 1.F}) bytes += bytes_of(x, false);
  for (const std::uint16_t i : {0, 1, 2}) bytes += bytes_of(i, false);
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":)" + scene_nodes + R"(}],"nodes":)" +
         nodes +
         R"(,"meshes":[{"name":"m","primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"indices":3}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"},
{"bufferView":3,"componentType":5123,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36},
{"buffer":0,"byteOffset":72,"byteLength":24},{"buffer":0,"byteOffset":96,"byteLength":6}],
"buffers":[{"byteLength":102,"uri":"data:application/octet-stream;base64,)" +
         base64(bytes) + "\"}]}";
}

TEST_F(LoadMesh, GltfHasVUp) {
  const LoadedMesh loaded = load("a.gltf", gltf(R"([{"mesh":0}])", "[0]"));
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}}));
  EXPECT_EQ(loaded.mesh.positions_mm[1], Vec3d(1, 0, 0));
  // In glTF (0, 0) is the image's top left.
  EXPECT_EQ((*loaded.mesh.corner_uvs)[0][0], Vec2d(0.25, 1));
  EXPECT_EQ((*loaded.mesh.corner_uvs)[0][1], Vec2d(1, 0.75));
  EXPECT_EQ((*loaded.mesh.corner_uvs)[0][2], Vec2d(0, 0));
}

TEST_F(LoadMesh, GltfAppliesNodeTransformsAndMergesMeshes) {
  LoadOptions options;
  options.unit_mm = 10.0;
  const LoadedMesh loaded = load("a.gltf",
                                 gltf(R"([{"mesh":0},{"translation":[0,0,5],"children":[2]},
{"mesh":0,"scale":[2,2,2],"rotation":[0.70710678118654757,0,0,0.70710678118654757]}])",
                                      "[0,1]"),
                                 options);
  ASSERT_EQ(loaded.mesh.triangles.size(), 2U);
  EXPECT_EQ(loaded.mesh.positions_mm.size(), 6U);
  // Turned by 90 degrees about x, twice as large, and moved: y becomes z. Quaternions are floats: 1e-6.
  EXPECT_LT((loaded.mesh.corner(1, 0) - Vec3d(0, 0, 50)).norm(), 1e-5);
  EXPECT_LT((loaded.mesh.corner(1, 1) - Vec3d(20, 0, 50)).norm(), 1e-5);
  EXPECT_LT((loaded.mesh.corner(1, 2) - Vec3d(0, 0, 70)).norm(), 1e-5);
  EXPECT_LT((loaded.mesh.corner_normals[1][0] - Vec3d(0, -1, 0)).norm(), 1e-6);
}

TEST_F(LoadMesh, GltfMirroringKeepsTheOutsideOutside) {
  const LoadedMesh loaded = load("a.gltf", gltf(R"([{"mesh":0,"scale":[-1,1,1]}])", "[0]"));
  EXPECT_EQ(triangle_normal(loaded.mesh, 0), Vec3d::UnitZ());
  EXPECT_EQ(loaded.mesh.corner_normals[0][0], Vec3d::UnitZ());
  EXPECT_EQ((*loaded.mesh.corner_uvs)[0][1], Vec2d(0, 0));  // goes with its corner
}

TEST_F(LoadMesh, GltfErrors) {
  EXPECT_EQ(error_of("a.gltf", gltf(R"([{"mesh":0}])", "[0]", HUGE_VALF)),
            "a.gltf: vertex 0 of mesh \"m\" is (inf, 0, 0): coordinates must be finite");
  for (const char* name : {"a.gltf", "a.glb", "a.fbx"}) {
    EXPECT_EQ(error_of(name, "not a model").rfind(std::string(name) + ": ", 0), 0U);
  }
  EXPECT_EQ(error_of("a.glb", std::string("glTF\2\0\0\0\x20\1\0\0cut off", 19)),
            "a.glb: the file is damaged or cut off: it has 19 bytes, and its header says 288");
}

// The folder with the scanned head, if there is one.
std::optional<fs::path> scanned_head() {
  const char* const data = std::getenv("TRUESCATTER_DATA");
  const fs::path folder =
      data != nullptr ? fs::path(data) : fs::path(TRUESCATTER_SOURCE_DIR) / "../shared/data";
  if (fs::exists(folder / "lps" / "lps_head.obj")) return folder / "lps";
  return std::nullopt;
}

struct Bounds {
  Vec3d low = Vec3d::Constant(HUGE_VAL);
  Vec3d high = Vec3d::Constant(-HUGE_VAL);
};

Bounds bounds_of(const Mesh& mesh) {
  Bounds bounds;
  for (const Vec3d& p : mesh.positions_mm) {
    bounds.low = bounds.low.cwiseMin(p);
    bounds.high = bounds.high.cwiseMax(p);
  }
  return bounds;
}

TEST_F(LoadMesh, ScannedHeadAsObj) {
  const auto folder = scanned_head();
  if (!folder) GTEST_SKIP() << "no lps/lps_head.obj under TRUESCATTER_DATA or beside the checkout";
  LoadOptions options;
  options.unit_mm = 1000.0;
  const LoadedMesh loaded = load_mesh_in_file_order(*folder / "lps_head.obj", options);
  EXPECT_EQ(loaded.mesh.positions_mm.size(), 8844U);
  EXPECT_EQ(loaded.mesh.triangles.size(), 17684U);
  EXPECT_LT((bounds_of(loaded.mesh).high - Vec3d(215.313, 200.018, 130.425)).norm(), 1e-9);
  ASSERT_TRUE(loaded.mesh.has_uvs());
  for (std::size_t i = 0; i < loaded.vertex_of_file_vertex.size(); ++i) {
    ASSERT_EQ(loaded.vertex_of_file_vertex[i], static_cast<int>(i));
  }
  // v up: the crown's UVs lie above the nose's, and those above the neck's.
  const auto highest_v = [&loaded](const auto& score) {
    double best = -HUGE_VAL;
    double v = 0.0;
    for (std::size_t t = 0; t < loaded.mesh.triangles.size(); ++t) {
      for (int c = 0; c < 3; ++c) {
        if (score(loaded.mesh.corner(t, c)) <= best) continue;
        best = score(loaded.mesh.corner(t, c));
        v = (*loaded.mesh.corner_uvs)[t][static_cast<std::size_t>(c)].y();
      }
    }
    return v;
  };
  const double crown = highest_v([](const Vec3d& p) { return p.y(); });
  const double nose = highest_v([](const Vec3d& p) { return p.z(); });
  EXPECT_GT(crown, nose);
  EXPECT_LT(inspect_uvs(loaded.mesh).overlapping, loaded.mesh.triangles.size() / 20);
}

// A second opinion. OpenMesh keeps positions in float and drops what is not manifold; the head is, so the
// faces must agree one by one, and the positions to half a unit in the last place of a float.
void expect_openmesh_agrees(const fs::path& path, const Mesh& mesh) {
  OpenMesh::TriMesh_ArrayKernelT<> other;
  ASSERT_TRUE(OpenMesh::IO::read_mesh(other, path.string()));
  ASSERT_EQ(other.n_vertices(), mesh.positions_mm.size());
  ASSERT_EQ(other.n_faces(), mesh.triangles.size());
  for (const OpenMesh::VertexHandle vertex : other.vertices()) {
    const Vec3d& position = mesh.positions_mm[static_cast<std::size_t>(vertex.idx())];
    const auto& theirs = other.point(vertex);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(static_cast<float>(position[axis]), theirs[static_cast<std::size_t>(axis)]);
    }
  }
  for (const OpenMesh::FaceHandle face : other.faces()) {
    std::array<int, 3> theirs{};
    auto corner = theirs.begin();
    for (const OpenMesh::VertexHandle vertex : other.fv_range(face)) *corner++ = vertex.idx();
    std::rotate(theirs.begin(), std::min_element(theirs.begin(), theirs.end()), theirs.end());
    std::array<int, 3> ours = mesh.triangles[static_cast<std::size_t>(face.idx())];
    std::rotate(ours.begin(), std::min_element(ours.begin(), ours.end()), ours.end());
    ASSERT_EQ(ours, theirs);
  }
}

TEST_F(LoadMesh, AgreesWithOpenMeshOnCleanFiles) {
  const auto folder = scanned_head();
  if (!folder) GTEST_SKIP() << "no lps/lps_head.obj under TRUESCATTER_DATA or beside the checkout";
  const Mesh mesh = load_mesh(*folder / "lps_head.obj", {});
  expect_openmesh_agrees(*folder / "lps_head.obj", mesh);
  // The same surface written by OpenMesh as OFF, and as PLY of both kinds, and read back.
  OpenMesh::TriMesh_ArrayKernelT<> other;
  ASSERT_TRUE(OpenMesh::IO::read_mesh(other, (*folder / "lps_head.obj").string()));
  for (const auto& [name, flags] : {std::pair("a.off", OpenMesh::IO::Options::Default),
                                    std::pair("a.ply", OpenMesh::IO::Options::Default),
                                    std::pair("b.ply", OpenMesh::IO::Options::Binary)}) {
    const fs::path path = folder_ / name;
    ASSERT_TRUE(OpenMesh::IO::write_mesh(other, path.string(), flags, 9));
    expect_openmesh_agrees(path, load_mesh(path, {}));
  }
}

// Is the file as long as its header says? (A binary that was treated as text is not.)
bool is_whole_glb(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<unsigned char, 12> header{};
  for (unsigned char& byte : header) byte = static_cast<unsigned char>(file.get());
  const std::uintmax_t length =
      header[8] | header[9] << 8U | header[10] << 16U | static_cast<std::uintmax_t>(header[11]) << 24U;
  return length == fs::file_size(path);
}

TEST_F(LoadMesh, ScannedHeadAsGlbIsTheSameSurface) {
  const auto folder = scanned_head();
  if (!folder || !fs::exists(*folder / "LeePerrySmith.glb")) {
    GTEST_SKIP() << "no lps/LeePerrySmith.glb under TRUESCATTER_DATA or beside the checkout";
  }
  LoadOptions options;
  options.unit_mm = 50.35;
  options.flip_v = true;  // the file has v up, against its format's convention
  if (!is_whole_glb(*folder / "LeePerrySmith.glb")) {
    EXPECT_NE(error_of_path(*folder / "LeePerrySmith.glb", options), "no error");
    GTEST_SKIP() << "LeePerrySmith.glb is damaged: it is not as long as its header says";
  }
  const Mesh glb = load_mesh(*folder / "LeePerrySmith.glb", options);
  options = {};
  options.unit_mm = 1000.0;
  const Mesh obj = load_mesh(*folder / "lps_head.obj", options);
  // The OBJ has six decimals of a metre: half of 1e-3 mm per coordinate.
  const Bounds a = bounds_of(glb);
  const Bounds b = bounds_of(obj);
  EXPECT_LT((a.low - b.low).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT((a.high - b.high).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_EQ(glb.triangles.size(), obj.triangles.size());
  EXPECT_NEAR(surface_area_mm2(glb) / surface_area_mm2(obj), 1.0, 1e-5);
  const UvReport uv_a = inspect_uvs(glb);
  const UvReport uv_b = inspect_uvs(obj);
  EXPECT_NEAR(uv_a.mm_per_unit_median / uv_b.mm_per_unit_median, 1.0, 1e-2);
}

}  // namespace
}  // namespace truescatter
