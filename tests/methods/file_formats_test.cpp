// One surface from two files gives one picture: the built-in head as OBJ in metres, with one vertex for each
// position, and as GLB in 64ths of a metre, split along its UV seams, with v down as glTF has it.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>
#include <string>
#include <tuple>

#include "scene/load_mesh.h"
#include "support/render.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

using test::Scene;

constexpr float kUvSteps = 1048576.0F;  // 2^20

// What both files say. Positions are single precision, in metres: times 64 they still are. UVs are multiples
// of 2^-20, so that 1 - v is exact. Both files give the same real numbers, and times their units, 1000 mm and
// 15.625 mm, these round to the same doubles.
struct Contents {
  std::vector<std::array<float, 3>> positions_m;  // in the order of their first mention
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<std::array<float, 2>, 3>> uvs;
};

Contents contents_of(const Mesh& mesh) {
  Contents contents;
  std::map<int, int> number;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    auto& triangle = contents.triangles.emplace_back();
    auto& uvs = contents.uvs.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [entry, fresh] = number.try_emplace(mesh.triangles[t][c], static_cast<int>(number.size()));
      triangle[c] = entry->second;
      if (fresh) {
        const Vec3f p = (mesh.corner(t, static_cast<int>(c)) / 1000.0).cast<float>();
        contents.positions_m.push_back({p.x(), p.y(), p.z()});
      }
      const Vec2f uv = (*mesh.corner_uvs)[t][c].cast<float>();
      uvs[c] = {std::round(uv.x() * kUvSteps) / kUvSteps, std::round(uv.y() * kUvSteps) / kUvSteps};
    }
  }
  return contents;
}

std::string obj_of(const Contents& contents) {
  std::string text;
  for (const auto& p : contents.positions_m) {
    text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", static_cast<double>(p[0]), static_cast<double>(p[1]),
                        static_cast<double>(p[2]));
  }
  int last_uv = 0;
  for (std::size_t t = 0; t < contents.triangles.size(); ++t) {
    std::string face = "f";
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& uv = contents.uvs[t][c];
      text += fmt::format("vt {:.17g} {:.17g}\n", static_cast<double>(uv[0]), static_cast<double>(uv[1]));
      face += fmt::format(" {}/{}", contents.triangles[t][c] + 1, ++last_uv);
    }
    text += face + "\n";
  }
  return text;
}

template <typename Number>
void append(std::string& bytes, Number number) {
  std::array<char, sizeof(Number)> raw{};
  std::memcpy(raw.data(), &number, sizeof(Number));
  bytes.append(raw.data(), raw.size());
}

void append_chunk(std::string& glb, const char* type, std::string bytes, char padding) {
  bytes.resize((bytes.size() + 3) / 4 * 4, padding);
  append(glb, static_cast<std::uint32_t>(bytes.size()));
  glb += std::string(type, 4) + bytes;
}

std::string glb_of(const Contents& contents, std::size_t& vertices) {
  std::map<std::tuple<int, float, float>, std::uint32_t> number;
  std::string positions;
  std::string uvs;
  std::string indices;
  std::array<float, 3> low{1e9F, 1e9F, 1e9F};
  std::array<float, 3> high{-1e9F, -1e9F, -1e9F};
  for (std::size_t t = 0; t < contents.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int p = contents.triangles[t][c];
      const auto& uv = contents.uvs[t][c];
      const auto [entry, fresh] =
          number.try_emplace({p, uv[0], uv[1]}, static_cast<std::uint32_t>(number.size()));
      append(indices, entry->second);
      if (!fresh) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float value = 64.0F * contents.positions_m[static_cast<std::size_t>(p)][axis];
        append(positions, value);
        low[axis] = std::min(low[axis], value);
        high[axis] = std::max(high[axis], value);
      }
      append(uvs, uv[0]);
      append(uvs, 1.0F - uv[1]);
    }
  }
  vertices = number.size();
  const std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],)"
      R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2}}]}}],)"
      R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{0},"type":"VEC3",)"
      R"("min":[{1},{2},{3}],"max":[{4},{5},{6}]}},)"
      R"({{"bufferView":1,"componentType":5126,"count":{0},"type":"VEC2"}},)"
      R"({{"bufferView":2,"componentType":5125,"count":{7},"type":"SCALAR"}}],)"
      R"("bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{8}}},)"
      R"({{"buffer":0,"byteOffset":{8},"byteLength":{9}}},)"
      R"({{"buffer":0,"byteOffset":{10},"byteLength":{11}}}],"buffers":[{{"byteLength":{12}}}]}})",
      vertices, low[0], low[1], low[2], high[0], high[1], high[2], 3 * contents.triangles.size(),
      positions.size(), uvs.size(), positions.size() + uvs.size(), indices.size(),
      positions.size() + uvs.size() + indices.size());
  std::string chunks;
  append_chunk(chunks, "JSON", json, ' ');
  append_chunk(chunks, "BIN\0", positions + uvs + indices, '\0');
  std::string glb = "glTF";
  append(glb, std::uint32_t{2});
  append(glb, static_cast<std::uint32_t>(12 + chunks.size()));
  return glb + chunks;
}

// Skin but for a band of v, so that a v turned round would show.
SkinMask band() {
  Image image(4, 16, 1, 1.0F);
  for (int x = 0; x < 4; ++x) {
    for (int y = 9; y < 12; ++y) image.at(x, y, 0) = 0.0F;
  }
  return SkinMask(image);
}

Scene picture_of(const Mesh& mesh) {
  Camera camera = test::camera_at(600.0, 230.0, 192);
  camera.eye_mm.x() = 250.0;
  const Lighting lighting(mesh, {test::lamp({0.85, 0.35, 0.4}, true)});
  return {make_shading_mesh(mesh, lighting, band(), {0.05, 1.0}), camera};
}

int differing(const Image& a, const Image& b) {
  EXPECT_EQ(a.data().size(), b.data().size());
  int count = 0;
  for (std::size_t i = 0; i < a.data().size(); ++i) count += a.data()[i] == b.data()[i] ? 0 : 1;
  return count;
}

TEST(FileFormats, AnObjAndAGlbOfOneSurfaceGiveOnePicture) {
  const Contents contents = contents_of(make_builtin("head", {{"edge_mm", 5.0}}));
  std::size_t glb_vertices = 0;
  const test::TempDir folder;
  const std::filesystem::path obj = folder.write("head.obj", obj_of(contents));
  const std::filesystem::path glb = folder.write("head.glb", glb_of(contents, glb_vertices));
  EXPECT_GT(glb_vertices, contents.positions_m.size() + 100);  // it is split
  const Mesh from_obj = load_mesh(obj, {.unit_mm = 1000.0});
  const Mesh from_glb = load_mesh(glb, {.unit_mm = 15.625});
  ASSERT_EQ(from_obj.positions_mm, from_glb.positions_mm);
  ASSERT_EQ(from_obj.triangles, from_glb.triangles);

  // The files hold the same numbers (see Contents), so nothing may differ: the tolerance is 0.
  const Scene a = picture_of(from_obj);
  const Scene b = picture_of(from_glb);
  const int skin = differing(a.images().mask, Image(192, 192, 1));
  EXPECT_GT(skin, 5000);
  EXPECT_LT(skin, differing(a.images().position, Image(192, 192, 3)) / 3 - 500);  // the band is in view
  EXPECT_EQ(differing(a.images().mask, b.images().mask), 0);
  EXPECT_EQ(differing(a.images().irradiance, b.images().irradiance), 0);
  EXPECT_EQ(differing(a.images().normal, b.images().normal), 0);
  const Profile& profile = builtin_profiles().front();
  for (const char* method : {"none", "texture-space"}) {
    std::map<std::string, SettingValue> given;
    if (find_method(method).needs_uvs) given["texture_size"] = 512.0;
    const Image picture = a.run(find_method(method), profile, given);
    EXPECT_GT(differing(picture, Image(192, 192, 3)), 5000) << method;
    EXPECT_EQ(differing(picture, b.run(find_method(method), profile, given)), 0) << method;
  }

  // The comparison sees a v that is turned round, and a unit that is a tenth of a percent off.
  EXPECT_GT(differing(a.images().mask,
                      picture_of(load_mesh(glb, {.unit_mm = 15.625, .flip_v = true})).images().mask),
            500);
  EXPECT_GT(
      differing(a.images().irradiance, picture_of(load_mesh(glb, {.unit_mm = 15.64})).images().irradiance),
      500);
}

}  // namespace
}  // namespace truescatter
