// Scenes of several characters: copies of one mesh, with one UV map between them.
#include "scene/characters.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "support/image_difference.h"
#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;
using Given = std::map<std::string, SettingValue>;

// Small maps: nothing here depends on how fine they are.
Given texture_settings(Given more) {
  more.emplace("texture_size", 128.0);
  return more;
}

// The methods that work in texture space.
constexpr std::array<const char*, 2> kTextureMethods = {"texture-space", "texture-space-transmit"};

// Every word of every setting of such a method, one at a time.
std::vector<Given> all_texture_settings(const char* method) {
  std::vector<Given> all;
  for (const SettingSpec& setting : find_method(method).settings) {
    for (const std::string_view word : setting.choices)
      all.push_back(texture_settings({{std::string(setting.name), std::string(word)}}));
  }
  return all;
}

std::string described(const Given& given) {
  std::string text;
  for (const auto& [name, value] : given) {
    if (const auto* word = std::get_if<std::string>(&value)) text += name + " = " + *word + " ";
  }
  return text;
}

// The characters' numbers, from 1 on skin.
Image numbers_of(const Scene& scene) {
  return gpu::read_texture(Scene::context(), scene.frame().character, 1);
}

TEST(Characters, OutOfSightLeaveEachMethodsPictureAsItWasToTheBit) {
  const Mesh head = make_builtin("head", {{"edge_mm", 6.0}});
  const Light light = test::lamp({0.85, 0.35, 0.4});
  Camera camera = test::camera_at(600.0, 260.0, 96);
  const std::vector<LightField> lights = {{test::lamp(light.direction, true), {}}};
  const Scene alone(test::shade(head, light), camera, lights);
  // The one in view is the second: far from the first, at the place of the single one.
  const std::vector<CharacterPlace> places = {{Vec3d(3000.0, -2500.0, 0.0), 90.0}, {}};
  const Scene two(test::shade(place_characters(head, places), light), camera, lights);
  ASSERT_EQ(two.shading().character_starts.size(), 2U);
  ASSERT_EQ(test::largest_difference(alone.images().irradiance, two.images().irradiance), 0.0);
  const Profile& profile = builtin_profiles().front();
  for (const char* name : kTextureMethods) {
    for (const Given& given : all_texture_settings(name)) {
      const Method& method = find_method(name);
      const Image expected = alone.run(method, profile, given);
      EXPECT_GT(test::largest_difference(expected, alone.images().irradiance), 0.01);
      EXPECT_EQ(test::largest_difference(two.run(method, profile, given), expected), 0.0)
          << name << " " << described(given);
    }
  }
  // Light comes through, so that what is compared is there.
  const auto picture = [&](const char* name) { return alone.run(find_method(name), profile, texture_settings({})); };
  EXPECT_GT(test::largest_difference(picture(kTextureMethods[0]), picture(kTextureMethods[1])), 0.01);
  const Method& screen = find_method("pscbf");
  EXPECT_EQ(test::largest_difference(two.run(screen, profile), alone.run(screen, profile)), 0.0);
}

// Two squares side by side, both in view.
Scene two_squares(double first_light, double second_light) {
  const Mesh square = make_builtin("plane", {{"size_mm", 30.0}, {"edge_mm", 10.0}});
  const std::vector<CharacterPlace> places = {{Vec3d(-20.0, 0.0, 0.0)}, {Vec3d(20.0, 0.0, 0.0)}};
  ShadingMesh shading = test::shade(place_characters(square, places), test::lamp(Vec3d::UnitZ()));
  for (std::size_t t = 0; t < shading.triangles.size(); ++t) {
    for (Vec3d& value : shading.triangles[t].irradiance)
      value.setConstant(t < shading.character_starts[1] ? first_light : second_light);
  }
  return {std::move(shading), test::camera_at(400.0, 80.0, 80), {{test::lamp(Vec3d::UnitZ(), true), {}}}};
}

// Whether a square of even light keeps it: black gutters darken it from its edge, and the published taps sum
// to 1.001.
bool keeps_constant(const Given& given) {
  const auto is = [&](const char* name, const char* word) {
    const auto found = given.find(name);
    return found != given.end() && std::get<std::string>(found->second) == word;
  };
  return !is("gutter", "none") && !is("taps", "seven-published");
}

// Of a scene of two squares, one dark, the other lit by 1: neither gets anything of the other's.
void expect_no_leak(const Scene& scene, bool first_is_lit, const char* method, const Given& given) {
  const Image numbers = numbers_of(scene);
  const Image picture = scene.run(find_method(method), builtin_profiles().front(), given);
  int dark = 0;
  int lit = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      if (numbers.at(x, y, 0) == 0.0F) continue;
      if ((numbers.at(x, y, 0) == 1.0F) == first_is_lit) {
        ++lit;
        // The method's own limit on constant light.
        if (!keeps_constant(given)) continue;
        ASSERT_NEAR(picture.rgb(x, y).x(), 1.0, 1e-5) << method << described(given);
      } else {
        ++dark;
        ASSERT_EQ(picture.rgb(x, y), Vec3d::Zero()) << method << described(given) << x << " " << y;
      }
    }
  }
  EXPECT_GE(dark, 29 * 29);
  EXPECT_GE(lit, 29 * 29);
}

TEST(Characters, DoNotLeakThroughTheUvMapThatTheyShare) {
  for (const bool first_is_lit : {true, false}) {
    const Scene scene = two_squares(first_is_lit ? 1.0 : 0.0, first_is_lit ? 0.0 : 1.0);
    for (const char* method : kTextureMethods) {
      for (const Given& given : all_texture_settings(method))
        expect_no_leak(scene, first_is_lit, method, given);
    }
  }
}

TEST(Characters, HaveThePictureOfTheSingleOneWhereverTheyStand) {
  constexpr double kTexels = 128.0;
  const Mesh square = make_builtin("plane", {{"size_mm", 60.0}, {"edge_mm", 15.0}});
  const CharacterPlace away{Vec3d(-150.0, 40.0, 80.0), 35.0};
  const auto lit = [](const Mesh& mesh) {
    ShadingMesh shading = test::shade(mesh, test::lamp(Vec3d::UnitZ()));
    for (ShadingTriangle& triangle : shading.triangles) {
      for (std::size_t c = 0; c < 3; ++c)
        triangle.irradiance[c] = Vec3d(triangle.uvs[c].x() < 0.4 ? 1.0 : 0.0, triangle.uvs[c].y(), 0.5);
    }
    return shading;
  };
  const Camera camera = test::camera_at(400.0, 50.0, 96);  // all of the picture is skin
  Camera moved = camera;
  const Eigen::AngleAxisd turn(away.rotation_deg * kPi / 180.0, Vec3d::UnitY());
  moved.eye_mm = turn * camera.eye_mm + away.position_mm;
  moved.target_mm = turn * camera.target_mm + away.position_mm;
  const Scene alone(lit(square), camera);
  const std::vector<CharacterPlace> places = {{}, away};
  const Scene two(lit(place_characters(square, places)), moved);
  const Image numbers = numbers_of(two);
  for (const float number : numbers.data()) ASSERT_EQ(number, 2.0F);
  // Single precision holds the moved corners to 2^-24 of 400 mm (their coordinates with the eye's), 2.4e-5
  // mm, and interpolating and transforming them rounds about four times more: a point moves by 1e-4 mm.
  // Irradiance changes over a triangle of 15 mm by 1 at most: 7e-6. A texel is 60 / 128 mm; its stretch, the
  // difference of two such points, is off by 2e-4 / (60 / 128) = 4.3e-4 of itself, so is a level's standard
  // deviation, and d(G I) / d(ln s) = s^2 G'' I is at most 0.24 of a step in I (the largest value of t
  // exp(-t^2 / 2) / sqrt(2 pi)), along each axis.
  const double point_mm = 1e-4;
  const double tolerance = point_mm / 15.0 + 2.0 * 0.25 * 2.0 * point_mm / (60.0 / kTexels) + 1e-5;
  const Profile& profile = builtin_profiles().front();
  for (const char* stretch : {"raw", "off"}) {
    const Given given = {{"texture_size", kTexels}, {"stretch", std::string(stretch)}};
    const Method& method = find_method("texture-space");
    const Image expected = alone.run(method, profile, given);
    EXPECT_GT(test::largest_difference(expected, alone.images().irradiance), 0.02);
    EXPECT_LT(test::largest_difference(two.run(method, profile, given), expected), tolerance);
  }
}

// As in Cost.TextureSpaceChargesUvByItsFormat, but that each character pays for its own maps and levels (13
// passes after the first), and that a pixel is told by the character's number, a texture of 4 bytes, in place
// of the irradiance. The squares face the camera, so that the rectangle of a square's pixels holds nothing
// else.
TEST(Characters, EachPayForTheirOwnTexture) {
  const Scene scene = two_squares(1.0, 0.5);
  constexpr double kSize = 16.0;
  const Method& method = find_method("texture-space");
  const Settings settings(method.name, method.settings, {{"texture_size", kSize}});
  const SurfaceBuffers buffers(Scene::context(), scene.shading());
  EXPECT_EQ(buffers.character_count(), 2U);
  const PreparedMethod prepared =
      method.prepare({Scene::context(), scene.frame(), buffers, 400.0, builtin_profiles().front(), settings});
  Passes passes(Scene::context());
  const Passes::Counts counts = passes.count([&] { prepared.render(passes); });
  double skin = 0.0;
  for (const float v : scene.images().mask.data()) skin += v;
  const double all = 80.0 * 80.0;
  const double maps = 2.0 * (2.0 + 3.0 * 2.0 * 26.0) * kSize * kSize;
  EXPECT_EQ(counts.passes, 1 + 2 * 13);
  EXPECT_EQ(counts.texels_read, all + maps + 3.0 * 6.0 * skin);
  EXPECT_EQ(counts.bytes_read, 16.0 * (all + maps) + 3.0 * (4.0 + 8.0 + 4.0 * 16.0) * skin);
}

}  // namespace
}  // namespace truescatter
