// One broken file of each kind that people and their tools make: what is said of it, to the letter up to
// where it matters. All go through what the commands read files with.
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "core/file.h"
#include "core/image_io.h"
#include "experiment/fit_file.h"
#include "experiment/truth_files.h"
#include "profile/layered.h"
#include "profile/table_profile.h"
#include "scene/load_mesh.h"
#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

using namespace std::string_view_literals;
namespace fs = std::filesystem;

enum class Kind { mesh, irradiance, points, mask, table, layers, picture, fit };

struct Broken {
  const char* what;  // the case's name
  Kind kind;
  const char* file;
  std::string_view bytes;
  const char* message;  // what follows the file's name and begins the message
};

void PrintTo(const Broken& broken, std::ostream* stream) { *stream << broken.what; }

// Irradiance, points and mask belong to a square of two triangles.
void read_problem(const test::TempDir& folder, TruthFiles files) {
  const auto given = [&](fs::path& file, const char* name, const char* text) {
    if (file.empty()) file = folder.write(name, text);
  };
  given(files.mesh, "square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
  given(files.irradiance, "light.csv", "r,g,b\n1,1,1\n1,0,0\n0,1,0\n0,0,1\n");
  given(files.points, "points.csv", "face,b0,b1,b2\n0,0.5,0.25,0.25\n");
  read_truth_problem(files);
}

void read(Kind kind, const fs::path& file, const test::TempDir& folder) {
  switch (kind) {
    case Kind::mesh:
      load_mesh(file, {});
      return;
    case Kind::irradiance:
      return read_problem(folder, {{}, file, {}, {}});
    case Kind::points:
      return read_problem(folder, {{}, {}, file, {}});
    case Kind::mask:
      return read_problem(folder, {{}, {}, {}, file});
    case Kind::table:
      read_table_profile(file);
      return;
    case Kind::layers:
      read_layers(file);
      return;
    case Kind::picture:
      read_rgb(file);
      return;
    case Kind::fit:
      read_fit(file);
      return;
  }
}

class BrokenInput : public testing::TestWithParam<Broken> {};

TEST_P(BrokenInput, IsRefusedByNamePlaceAndRule) {
  const Broken& broken = GetParam();
  const test::TempDir folder;
  const fs::path file = folder.write(broken.file, std::string(broken.bytes));
  const auto error = test::error_of([&] { read(broken.kind, file, folder); });
  ASSERT_TRUE(error) << "it was read";
  EXPECT_EQ(error->kind(), ErrorKind::input);
  const std::string start = file.string() + broken.message;
  EXPECT_EQ(std::string(error->what()).substr(0, start.size()), start) << error->what();
}

const Broken kBroken[] = {
    // OBJ
    {"ObjOfNothing", Kind::mesh, "m.obj", "", ": the file has no triangle"},
    {"ObjWithoutFaces", Kind::mesh, "m.obj", "v 0 0 0\n", ": the file has no triangle"},
    {"ObjIndexTooLarge", Kind::mesh, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
     ":4: 4 is out of range"},
    {"ObjIndexZero", Kind::mesh, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
     ":4: 0 is not a vertex index: indices count from 1"},
    {"ObjIndexTooFarBack", Kind::mesh, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 -2 -1\n",
     ":4: -4 is out of range"},
    {"ObjIndexBeyondAnInteger", Kind::mesh, "m.obj",
     "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n",
     ":4: \"99999999999999999999\" is not a whole number that a vertex index can be"},
    {"ObjTwoCorners", Kind::mesh, "m.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n",
     ":3: a face has 2 corners, and needs 3"},
    {"ObjTwoNumbers", Kind::mesh, "m.obj", "v 0 0\n", ":1: \"v\" has 2 numbers, and needs 3"},
    {"ObjWord", Kind::mesh, "m.obj", "v 0 zero 0\n",
     ":1: \"zero\" is not a number: a coordinate must be a finite number"},
    {"ObjNotFinite", Kind::mesh, "m.obj", "v 0 0 0\nv nan 0 0\n",
     ":2: \"nan\" is not finite: a coordinate must be a finite number"},
    {"ObjTooFar", Kind::mesh, "m.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1 0\nf 1 2 3\n",
     ": vertex 1 has a coordinate beyond"},
    {"ObjGarbage", Kind::mesh, "m.obj", "\x89PNG\r\n\x1a\n\0\0\0\0IHDR"sv, ": the file has no triangle"},
    // PLY
    {"PlyOfNothing", Kind::mesh, "m.ply", "", ": the first line of a PLY file must be \"ply\""},
    {"PlyWithoutItsName", Kind::mesh, "m.ply", "format ascii 1.0\n",
     ":1: the first line of a PLY file must be \"ply\""},
    {"PlyUnknownFormat", Kind::mesh, "m.ply", "ply\nformat utf8 1.0\n", ":2: \"utf8\" is not ascii"},
    {"PlyHeaderCutOff", Kind::mesh, "m.ply", "ply\nformat ascii 1.0\nelement vertex 3\n",
     ":3: the file ends before \"end_header\""},
    {"PlyUnknownType", Kind::mesh, "m.ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty vec3 x\nend_header\n",
     ":4: \"vec3\" is not a type of PLY"},
    {"PlyNegativeCount", Kind::mesh, "m.ply", "ply\nformat ascii 1.0\nelement vertex -3\nend_header\n",
     ":3: \"-3\": a count must not be negative"},
    {"PlyCountWithoutData", Kind::mesh, "m.ply",
     "ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\nproperty float x\nproperty float y\n"
     "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n",
     ": the file ends where a coordinate should follow"},
    {"PlyBodyCutOff", Kind::mesh, "m.ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
     "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n",
     ":11: the file ends where a coordinate should follow"},
    {"PlyIndexOutOfRange", Kind::mesh, "m.ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
     "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
     ":13: 3 is out of range: a vertex index is 0 to 2 here"},
    {"PlyWithoutZ", Kind::mesh, "m.ply",
     "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
     ": the element \"vertex\" needs the properties x, y and z"},
    // OFF
    {"OffOfNothing", Kind::mesh, "m.off", "", ": the file ends where \"OFF\" should follow"},
    {"OffWithoutItsName", Kind::mesh, "m.off", "FOO\n3 1 0\n",
     ":1: \"FOO\" is not the first word of an OFF file"},
    {"OffBinary", Kind::mesh, "m.off", "OFF BINARY\n", ":1: \"BINARY\": only the text form of OFF is read"},
    {"OffCountsMissing", Kind::mesh, "m.off", "OFF\n3\n", ":2: the counts of vertices and faces are missing"},
    {"OffNegativeCount", Kind::mesh, "m.off", "OFF\n-3 1 0\n", ":2: \"-3 1\": a count must not be negative"},
    {"OffFewerVertices", Kind::mesh, "m.off", "OFF\n3 1 0\n0 0 0\n",
     ":3: the file ends where a vertex should follow"},
    {"OffIndexOutOfRange", Kind::mesh, "m.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
     ":6: 3 is out of range: a vertex index is 0 to 2 here"},
    {"OffFaceCutOff", Kind::mesh, "m.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n",
     ":6: a face names 2 vertices, and says that it has 3"},
    // Others by assimp
    {"GlbCutOff", Kind::mesh, "m.glb", "glTF\2\0\0\0\377\0\0\0"sv,
     ": the file is damaged or cut off: it has 12 bytes"},
    {"GltfNoJson", Kind::mesh, "m.gltf", "{", ": No suitable reader found"},
    {"UnknownExtension", Kind::mesh, "m.stl", "solid\n", ": \".stl\" is not the extension of a known format"},
    // CSV of `truth`
    {"IrradianceOfNothing", Kind::irradiance, "i.csv", "", ":1: \"\" where the header \"r,g,b\" is needed"},
    {"IrradianceHeader", Kind::irradiance, "i.csv", "red,green,blue\n1,1,1\n",
     ":1: \"red,green,blue\" where the header \"r,g,b\" is needed"},
    {"IrradianceRowMissing", Kind::irradiance, "i.csv", "r,g,b\n1,1,1\n1,1,1\n1,1,1\n", ": has 3 rows"},
    {"IrradianceRowTooMany", Kind::irradiance, "i.csv", "r,g,b\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n",
     ":6: this is row 5"},
    {"IrradianceCellMissing", Kind::irradiance, "i.csv", "r,g,b\n1,1\n", ":2"},
    {"IrradianceWord", Kind::irradiance, "i.csv", "r,g,b\n1,one,1\n",
     ":2:3: \"one\" is not a number: g must be a finite number"},
    {"IrradianceNotFinite", Kind::irradiance, "i.csv", "r,g,b\n1,inf,1\n",
     ":2:3: \"inf\" is not finite: g must be a finite number"},
    {"PointsHeader", Kind::points, "p.csv", "triangle,u,v\n0,0,0\n",
     ":1: \"triangle,u,v\" where the header \"face,b0,b1,b2\" is needed"},
    {"PointsFaceOutOfRange", Kind::points, "p.csv", "face,b0,b1,b2\n2,1,0,0\n",
     ":2:1: face 2 is out of range"},
    {"PointsFaceNegative", Kind::points, "p.csv", "face,b0,b1,b2\n-1,1,0,0\n",
     ":2:1: face -1 is out of range"},
    {"PointsFaceNoWholeNumber", Kind::points, "p.csv", "face,b0,b1,b2\n0.5,1,0,0\n",
     ":2:1: \"0.5\" is not a whole number that face can be"},
    {"PointsBeyondAFace", Kind::points, "p.csv", "face,b0,b1,b2\n0,1.5,-0.5,0\n",
     ":2:3: b0 is 1.5: it must be 0 to 1"},
    {"PointsSum", Kind::points, "p.csv", "face,b0,b1,b2\n0,0.5,0.25,0\n",
     ":2:3: b0, b1, b2 sum to 0.75: they must sum to 1"},
    {"MaskLabel", Kind::mask, "k.csv", "skin\n1\n2\n", ":3:1: 2 where 0 or 1 (skin) is needed"},
    {"MaskRowMissing", Kind::mask, "k.csv", "1\n", ": has 1 rows"},
    // Profiles
    {"TableHeader", Kind::table, "t.csv", "radius,r,g,b\n0,1,1,1\n1,0,0,0\n",
     ":1: \"radius,r,g,b\" where the header \"r_mm,r,g,b\" is needed"},
    {"TableOneRow", Kind::table, "t.csv", "r_mm,r,g,b\n0,1,1,1\n", ":2: the table has 1 of at least 2 rows"},
    {"TableDescends", Kind::table, "t.csv", "r_mm,r,g,b\n1,1,1,1\n0.5,1,1,1\n",
     ":3:1: 0.5 after 1: radii must ascend"},
    {"TableNegativeRadius", Kind::table, "t.csv", "r_mm,r,g,b\n-1,1,1,1\n",
     ":2:1: -1: a radius must not be negative"},
    {"TableNegativeValue", Kind::table, "t.csv", "r_mm,r,g,b\n0,1,-1,1\n",
     ":2:5: -1: R must not be negative"},
    {"TableDarkChannel", Kind::table, "t.csv", "r_mm,r,g,b\n0,1,1,0\n1,1,1,0\n",
     ": the channel b has no light"},
    {"LayersOfNothing", Kind::layers, "l.csv",
     "thickness_mm,sigma_a_r,sigma_a_g,sigma_a_b,sigma_s_prime_r,sigma_s_prime_g,sigma_s_prime_b,eta\n",
     ": there is no layer below the header"},
    {"LayersNegativeThickness", Kind::layers, "l.csv",
     "thickness_mm,sigma_a_r,sigma_a_g,sigma_a_b,sigma_s_prime_r,sigma_s_prime_g,sigma_s_prime_b,eta\n"
     "-1,0.1,0.1,0.1,1,1,1,1.4\n",
     ":2:1: -1: a thickness must not be negative"},
    {"LayersBelowTheLast", Kind::layers, "l.csv",
     "thickness_mm,sigma_a_r,sigma_a_g,sigma_a_b,sigma_s_prime_r,sigma_s_prime_g,sigma_s_prime_b,eta\n"
     "0,0.1,0.1,0.1,1,1,1,1.4\n1,0.1,0.1,0.1,1,1,1,1.4\n",
     ":3: the layer above has no end, and layers follow"},
    // FIT.json
    {"FitNoJson", Kind::fit, "f.json", "{\"variances\": [1,", ":1:18: this is not valid JSON: "},
    {"FitWithoutWeights", Kind::fit, "f.json", "{\"variances\": [1]}", ": the key \"weights\" is missing"},
    {"FitFewerWeights", Kind::fit, "f.json", "{\"variances\": [1, 2], \"weights\": [[1, 1, 1]]}",
     ": weights has 1 rows and variances 2"},
    {"FitDescends", Kind::fit, "f.json", "{\"variances\": [2, 1], \"weights\": [[1, 1, 1], [1, 1, 1]]}",
     ": variances[1] is 1, after 2: variances must ascend"},
    {"FitNegativeVariance", Kind::fit, "f.json", "{\"variances\": [-1], \"weights\": [[1, 1, 1]]}",
     ": variances[0] is -1: a variance in mm^2 must be above 0"},
    // Pictures
    {"PngOfNothing", Kind::picture, "p.png", "", ": cannot read this image: "},
    {"PngCutOff", Kind::picture, "p.png", "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\5\0\0\0\4\x8\2\0\0\0"sv,
     ": cannot read "},
    {"ExrGarbage", Kind::picture, "p.exr", "v/1\1\2\0\0\0chan"sv, ": cannot read this image: "},
    {"HdrTooLarge", Kind::picture, "p.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 40000 +X 40000\nabcd",
     ": the image is 40000 x 40000 with 3 channels; at most 2^30 values are read"},
    {"HdrWithoutPixels", Kind::picture, "p.hdr",
     "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4000 +X 4000\nabcd",
     ": says it is 4000 x 4000 with 3 channels, which a file of 55 bytes cannot hold"},
    {"NoKnownPicture", Kind::picture, "p.xyz", "?", ": cannot read this image: "},
};

INSTANTIATE_TEST_SUITE_P(Table, BrokenInput, testing::ValuesIn(kBroken),
                         [](const auto& row) { return std::string(row.param.what); });

}  // namespace
}  // namespace truescatter
