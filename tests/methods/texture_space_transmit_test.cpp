// What texture-space-transmit adds to texture-space, against the light that truly passes through the body.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "scene/characters.h"
#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;
using Given = std::map<std::string, SettingValue>;

constexpr double kSizeMm = 60.0;
constexpr double kViewMm = 24.0;
constexpr int kPx = 96;
constexpr std::array<double, 3> kStdDevsMm = {0.75, 1.41, 2.72};

// Channel i shows Gaussian i alone.
Profile one_gaussian_a_channel() {
  Profile profile;
  profile.name = "one-gaussian-a-channel";
  profile.r_max_mm = 10.0;
  for (std::size_t i = 0; i < kStdDevsMm.size(); ++i) {
    profile.terms.push_back(
        {Vec3d::Constant(kStdDevsMm[i] * kStdDevsMm[i]), Vec3d::Unit(static_cast<Eigen::Index>(i))});
  }
  return profile;
}

// The light that comes from behind, `tilt_deg` off the slab's normal.
Light from_behind(double tilt_deg) {
  const double tilt = tilt_deg * kPi / 180.0;
  return test::lamp(Vec3d(std::sin(tilt), 0.0, -std::cos(tilt)), true);
}

bool is_back(const ShadingMesh& shading, const ShadingTriangle& triangle, double thickness_mm) {
  double farthest = -std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < 3; ++c) farthest = std::max(farthest, shading.corner(triangle, c).z());
  return farthest < -0.49 * thickness_mm;
}

// A slab whose far side gets `back(x)`, the rest nothing.
ShadingMesh slab_lit_by(double thickness_mm, const std::function<double(double)>& back) {
  ShadingMesh shading =
      test::shade(make_builtin("slab", {{"size_mm", kSizeMm}, {"thickness_mm", thickness_mm}}),
                  test::lamp(Vec3d::UnitZ()));
  for (ShadingTriangle& triangle : shading.triangles) {
    const bool lit = is_back(shading, triangle, thickness_mm);
    for (std::size_t c = 0; c < 3; ++c)
      triangle.irradiance[c].setConstant(lit ? back(shading.corner(triangle, c).x()) : 0.0);
  }
  return shading;
}

ShadingMesh evenly_lit_slab(double thickness_mm) {
  return slab_lit_by(thickness_mm, [](double) { return 1.0; });
}

Scene seen(ShadingMesh shading, const std::vector<LightField>& lights) {
  return {std::move(shading), test::camera_at(300.0, kViewMm, kPx), lights};
}

// With maps of 256 texels a side, half a millimetre each on the slab: nothing here depends on them.
Image run(const Scene& scene, const std::string& method, Given given = {}) {
  given.try_emplace("texture_size", 256.0);
  return scene.run(find_method(method), one_gaussian_a_channel(), given);
}

Vec3d added(const Scene& scene, int x, int y, const Given& given = {}) {
  return run(scene, "texture-space-transmit", given).rgb(x, y) - run(scene, "texture-space").rgb(x, y);
}

// The thickness that a Gaussian's light tells of.
double thickness_mm(double light, std::size_t gaussian) {
  return kStdDevsMm[gaussian] * std::sqrt(-2.0 * std::log(light));
}

// What rounding does to a thickness: blurring exp(-0.2 t) costs 1e-5 of it, as the blur's manual has it, and
// GLSL's exp and log 3 to 5 units in the last place, 5e-7 each: 1.1e-5 / 0.2 mm. A fade's slope is at most
// exp(-1/2) / s. And what it is multiplied by is blurred too: 1e-5.
double rounding(std::size_t gaussian) { return 1.1e-5 / 0.2 * 0.607 / kStdDevsMm[gaussian] + 1e-5; }

// On a slab that is lit evenly from behind, at right angles, int G(sqrt(t^2 + rho^2)) dA = exp(-t^2 / 2 s^2)
// comes through, which is the truth; the way along the light is the thickness exactly, whatever the shadow
// map's texels.
TEST(TextureSpaceTransmit, AddsWhatPassesThroughASlab) {
  for (const double t : {0.5, 1.0, 2.0, 4.0}) {
    const Scene scene = seen(evenly_lit_slab(t), {{from_behind(0.0), {}}});
    const Vec3d light = added(scene, kPx / 2, kPx / 2);
    for (std::size_t i = 0; i < 3; ++i) {
      const double s = kStdDevsMm[i];
      const double expected = std::exp(-0.5 * t * t / (s * s));
      EXPECT_NEAR(light[static_cast<Eigen::Index>(i)], expected, rounding(i)) << t << " mm, " << s;
      if (expected < 0.01) continue;
      // The slope of t in the light is s^2 / t over the light.
      EXPECT_NEAR(thickness_mm(light[static_cast<Eigen::Index>(i)], i), t,
                  2.0 * rounding(i) * s * s / (t * expected));
    }
  }
}

// Light that comes askew has a longer way, t / cos(theta): corrected by the exit's cosine where normals
// oppose, as here, it is the thickness again. The entry is that of the middle of a shadow map's texel, which
// is up to half of one off: its depth by that times tan(theta), of which the correction leaves the cosine's
// share.
TEST(TextureSpaceTransmit, CorrectsTheWayByTheNormals) {
  constexpr double kThicknessMm = 1.0;
  for (const double tilt_deg : {20.0, 40.0}) {
    const double tilt = tilt_deg * kPi / 180.0;
    const Scene scene = seen(evenly_lit_slab(kThicknessMm), {{from_behind(tilt_deg), {}}});
    const double texel_mm = 1.01 * (kSizeMm * std::cos(tilt) + kThicknessMm * std::sin(tilt)) / 1024;
    const Vec3d corrected = added(scene, kPx / 2, kPx / 2);
    const Vec3d straight = added(scene, kPx / 2, kPx / 2, {{"normal_correction", std::string("off")}});
    for (std::size_t i = 0; i < 3; ++i) {
      const auto c = static_cast<Eigen::Index>(i);
      const auto fade = [&](double t) { return std::exp(-0.5 * t * t / (kStdDevsMm[i] * kStdDevsMm[i])); };
      const double depth_step = 0.5 * texel_mm * std::tan(tilt) * 0.607 / kStdDevsMm[i];
      EXPECT_NEAR(corrected[c], fade(kThicknessMm), std::cos(tilt) * depth_step + rounding(i)) << tilt_deg;
      EXPECT_NEAR(straight[c], fade(kThicknessMm / std::cos(tilt)), depth_step + rounding(i)) << tilt_deg;
    }
  }
}

// A point light's rays fan out; each is corrected by its own cosine. 10 mm off the axis at 150 mm the texel
// matters by tan(theta) = 0.067 of a half of 61 / 1024 mm; distances of 150 mm are floats to 8e-6 mm, and
// there are two.
TEST(TextureSpaceTransmit, FollowsTheRaysOfAPointLight) {
  constexpr double kThicknessMm = 1.0;
  Light light;
  light.kind = LightKind::point;
  light.position_mm = Vec3d(0.0, 0.0, -150.0);
  const Scene scene = seen(evenly_lit_slab(kThicknessMm), {{light, {}}});
  for (const int x : {kPx / 2, kPx / 2 + 40}) {
    const Vec3d through = added(scene, x, kPx / 2);
    for (std::size_t i = 0; i < 3; ++i) {
      const double expected = std::exp(-0.5 * kThicknessMm * kThicknessMm / (kStdDevsMm[i] * kStdDevsMm[i]));
      EXPECT_NEAR(through[static_cast<Eigen::Index>(i)], expected,
                  (0.067 * 0.5 * 61.0 / 1024 + 4e-5) * 0.607 / kStdDevsMm[i] + rounding(i))
          << x;
    }
  }
}

// With a blend over b standard deviations light counts by d / (b s), d the distance of entry and exit in
// texture space; the slab's charts have one scale, and the light goes straight through. The entry is up to
// half a texel of the shadow map off along either axis.
TEST(TextureSpaceTransmit, BlendsByTheDistanceInTextureSpace) {
  constexpr double kThicknessMm = 0.5;
  constexpr double kStdDevs = 100.0;
  const Scene scene = seen(evenly_lit_slab(kThicknessMm), {{from_behind(0.0), {}}});
  const ShadingMesh& shading = scene.shading();
  // The middle of either side, and mm per unit of uv.
  Vec2d front = Vec2d::Zero();
  Vec2d back = Vec2d::Zero();
  double mm_per_uv_unit = 0.0;
  for (const ShadingTriangle& triangle : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d& p = shading.corner(triangle, c);
      if (p.head<2>().norm() > 1e-9) continue;
      (p.z() > 0.0 ? front : back) = triangle.uvs[c];
      const std::size_t next = (c + 1) % 3;
      mm_per_uv_unit =
          (shading.corner(triangle, next) - p).norm() / (triangle.uvs[next] - triangle.uvs[c]).norm();
    }
  }
  ASSERT_GT(mm_per_uv_unit, 0.0);
  const double distance_mm = (front - back).norm() * mm_per_uv_unit;
  // The pixel beside the middle: both are an eighth of a millimetre off, alike but for the sign of x.
  const Vec3d light = added(scene, kPx / 2, kPx / 2, {{"blend_std_devs", kStdDevs}});
  const double off_mm = std::sqrt(2.0) * 0.5 * 1.01 * kSizeMm / 1024 + 2.0 * 0.125;
  for (std::size_t i = 0; i < 3; ++i) {
    const double s = kStdDevsMm[i];
    const double expected = std::min(1.0, distance_mm / (kStdDevs * s));
    EXPECT_NEAR(light[static_cast<Eigen::Index>(i)] / std::exp(-0.5 * kThicknessMm * kThicknessMm / (s * s)),
                expected, off_mm / (kStdDevs * s) + 2.0 * rounding(i));
  }
  EXPECT_LT(distance_mm / (kStdDevs * kStdDevsMm[2]), 0.5);  // so that it is the blend that is seen
}

// With transmitters on the right half alone, points there are lit from behind as before, 9 mm from its edge:
// the thickness is blurred by the two narrower Gaussians, whose taps reach 3 (0.75 + 1.19) = 5.8 mm and a
// texel each. On the left nothing is added.
TEST(TextureSpaceTransmit, KeepsToItsTransmitters) {
  const std::vector<LightField> lights = {{from_behind(0.0), {}}};
  ShadingMesh masked = evenly_lit_slab(1.0);
  for (ShadingTriangle& triangle : masked.triangles) {
    double middle = 0.0;
    for (std::size_t c = 0; c < 3; ++c) middle += masked.corner(triangle, c).x();
    triangle.transmits = middle > 0.0;
  }
  const Image all = run(seen(evenly_lit_slab(1.0), lights), "texture-space-transmit");
  const Scene scene = seen(std::move(masked), lights);
  const Image half = run(scene, "texture-space-transmit");
  const Image none = run(scene, "texture-space");
  EXPECT_GT(all.at(12, 48, 2), 0.9F);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(half.at(12, 48, c), none.at(12, 48, c));
    EXPECT_EQ(half.at(84, 48, c), all.at(84, 48, c));
  }
}

void expect_equal(const Image& a, const Image& b) {
  for (std::size_t i = 0; i < a.data().size(); ++i) ASSERT_EQ(a.data()[i], b.data()[i]);
}

// What faces its light, what light from nowhere falls on, and what is opaque: all that is left is
// texture-space.
TEST(TextureSpaceTransmit, IsTextureSpaceWhereNoLightComesThrough) {
  const auto even = [] { return evenly_lit_slab(1.0); };
  const Scene facing = seen(even(), {{test::lamp(Vec3d::UnitZ(), true), {}}});
  expect_equal(run(facing, "texture-space-transmit"), run(facing, "texture-space"));
  const Scene unknown = seen(even(), {});
  expect_equal(run(unknown, "texture-space-transmit"), run(unknown, "texture-space"));
  ShadingMesh opaque = even();
  for (ShadingTriangle& triangle : opaque.triangles) triangle.transmits = false;
  const Scene masked = seen(std::move(opaque), {{from_behind(0.0), {}}});
  expect_equal(run(masked, "texture-space-transmit"), run(masked, "texture-space"));
  const Scene lit = seen(even(), {{from_behind(0.0), {}}});
  expect_equal(run(lit, "texture-space-transmit", {{"transmitting_gaussians", 0.0}}),
               run(lit, "texture-space"));
}

// Behind 40 mm of body of a sphere, 14 of the widest standard deviations, nothing comes through.
TEST(TextureSpaceTransmit, AddsNothingToAThickBody) {
  const Mesh sphere = make_builtin("sphere", {{"radius_mm", 30.0}});
  const Light light = test::lamp(Vec3d(0.1, 0.1, -1.0), true);
  const Scene scene(test::shade(sphere, light), test::camera_at(300.0, kViewMm, kPx), {{light, {}}});
  expect_equal(run(scene, "texture-space-transmit"), run(scene, "texture-space"));
}

// Every light has a map, an irradiance and thicknesses of its own, so what two add is the sum of what each
// adds: to floats, at most four roundings of values below 2 a level, three levels, on either side.
TEST(TextureSpaceTransmit, LightsAddUp) {
  const auto rising = [](double x) { return 0.5 + x / 80.0; };
  const auto falling = [](double x) { return 0.3 - x / 120.0; };
  const Light one = from_behind(10.0);
  const Light other = from_behind(-35.0);
  const ShadingMesh both = slab_lit_by(1.0, [&](double x) { return rising(x) + falling(x); });
  const auto field = [](const ShadingMesh& shading) {
    CornerIrradiance irradiance;
    for (const ShadingTriangle& triangle : shading.triangles) irradiance.push_back(triangle.irradiance);
    return irradiance;
  };
  const CornerIrradiance by_one = field(slab_lit_by(1.0, rising));
  const CornerIrradiance by_other = field(slab_lit_by(1.0, falling));
  const Scene together = seen(both, {{one, by_one}, {other, by_other}});
  const Scene with_one = seen(slab_lit_by(1.0, rising), {{one, {}}});
  const Scene with_other = seen(slab_lit_by(1.0, falling), {{other, {}}});
  // The other as a light that is not followed: it is there, and nothing of it comes through.
  const Scene followed = seen(both, {{one, by_one}});
  constexpr double kRounding = 2.0 * 3.0 * 4.0 * 1.2e-7;
  for (const int x : {12, 48, 80}) {
    const Vec3d first = added(with_one, x, 48);
    const Vec3d second = added(with_other, x, 48);
    EXPECT_GT(first.minCoeff(), 0.1);
    EXPECT_LE((added(together, x, 48) - first - second).cwiseAbs().maxCoeff(), kRounding);
    EXPECT_LE((added(followed, x, 48) - first).cwiseAbs().maxCoeff(), kRounding);
  }
}

// Two slabs 0.5 mm thick with one UV map, the first 1 mm behind the second and 30 mm to its right, so that it
// stands in the light of the second's right half. In that half no light enters the second, and none comes out
// of it, though the light meets the first there, at texture coordinates where the second is lit on its left
// half. Both let their own light through whole, and the shadow's edge is that of the convolution, half of it
// in the middle.
TEST(TextureSpaceTransmit, LightThatEntersACharacterComesOutOfThatOneAlone) {
  constexpr double kThicknessMm = 0.5;
  const Mesh slab = make_builtin("slab", {{"size_mm", kSizeMm}, {"thickness_mm", kThicknessMm}});
  const std::vector<CharacterPlace> places = {{Vec3d(30.0, 0.0, -1.0)}, {}};
  ShadingMesh shading = test::shade(place_characters(slab, places), test::lamp(Vec3d::UnitZ()));
  for (std::size_t t = 0; t < shading.triangles.size(); ++t) {
    ShadingTriangle& triangle = shading.triangles[t];
    double middle = 0.0;
    for (std::size_t c = 0; c < 3; ++c) middle += shading.corner(triangle, c).x();
    const bool shadowed = t >= shading.character_starts[1] && middle > 0.0;
    const bool lit = triangle.normals[0].z() < -0.5 && !shadowed;
    for (Vec3d& value : triangle.irradiance) value.setConstant(lit ? 1.0 : 0.0);
  }
  constexpr int kWidePx = 130;  // of a millimetre
  const Scene scene(std::move(shading), test::camera_at(300.0, kWidePx, kWidePx), {{from_behind(0.0), {}}});
  const Image with = run(scene, "texture-space-transmit");
  const Image without = run(scene, "texture-space");
  const auto column = [](double x_mm) { return static_cast<int>(std::floor(x_mm)) + kWidePx / 2; };
  const auto through = [&](double x_mm) {
    return Vec3d(with.rgb(column(x_mm), kWidePx / 2) - without.rgb(column(x_mm), kWidePx / 2));
  };
  // Taps reach 3 (0.75 + 1.19 + 2.33) = 12.8 mm, and a texel of half a millimetre in each of three levels.
  for (double x_mm = 16.0; x_mm < 29.0; x_mm += 1.0) EXPECT_EQ(through(x_mm), Vec3d::Zero()) << x_mm;
  for (std::size_t i = 0; i < 3; ++i) {
    const double s = kStdDevsMm[i];
    const double fade = std::exp(-0.5 * kThicknessMm * kThicknessMm / (s * s));
    const auto c = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(through(-15.0)[c], fade, rounding(i)) << "the second, " << s;
    EXPECT_NEAR(through(41.0)[c], fade, rounding(i)) << "the first, " << s;
  }
  // The edge lies within half a texel of either map of x = 0 (0.25 and 0.03 mm), where a Gaussian's integral
  // rises by 1 / (s sqrt(2 pi)); of seven taps by up to twice that.
  const double s = kStdDevsMm[2];
  const double fade = std::exp(-0.5 * kThicknessMm * kThicknessMm / (s * s));
  EXPECT_NEAR(0.5 * (through(-0.5) + through(0.5)).z(), 0.5 * fade, 2.0 * 0.28 / (s * std::sqrt(2.0 * kPi)));
}

// Each character's levels of each light are named apart while they are there, unblurred first; a light that
// falls on one character is in that one's textures alone.
TEST(TextureSpaceTransmit, NamesTheLevelsOfEachCharacterAndLight) {
  const Mesh slab = make_builtin("slab", {{"size_mm", kSizeMm}, {"thickness_mm", 1.0}});
  const std::vector<CharacterPlace> places = {{Vec3d(-40.0, 0.0, 0.0)}, {Vec3d(40.0, 0.0, 0.0)}};
  ShadingMesh shading = test::shade(place_characters(slab, places), test::lamp(Vec3d::UnitZ()));
  constexpr std::array<double, 2> kLight = {1.0, 0.5};  // of the light that is a character's
  std::array<CornerIrradiance, 2> fields;
  for (CornerIrradiance& field : fields) field.resize(shading.triangles.size());
  for (std::size_t t = 0; t < shading.triangles.size(); ++t) {
    const std::size_t own = t < shading.character_starts[1] ? 0 : 1;
    for (std::size_t c = 0; c < 3; ++c) {
      shading.triangles[t].irradiance[c].setConstant(kLight[own]);
      fields[own][t][c].setConstant(kLight[own]);
      fields[1 - own][t][c].setZero();
    }
  }
  const std::vector<LightField> lights = {{from_behind(0.0), fields[0]}, {from_behind(20.0), fields[1]}};
  const Camera camera = test::camera_at(300.0, 160.0, 64);
  const SurfaceBuffers buffers(Scene::context(), shading, lights);
  const Frame frame = render_frame(Scene::context(), buffers, shading, camera);
  const Method& method = find_method("texture-space-transmit");
  const Settings settings(method.name, method.settings, {{"texture_size", 64.0}});
  const Profile profile = one_gaussian_a_channel();
  const PreparedMethod prepared =
      method.prepare({Scene::context(), frame, buffers, 300.0, profile, settings});
  Passes passes(Scene::context());
  std::map<std::string, Image> named;
  passes.record([&] { prepared.render(passes); },
                [&](const NamedTexture& texture) { named[texture.name] = texture.image; });
  // Its levels with the unblurred one, its stretch, the light's shadow map and entries, and the thickness,
  // which is read anew for each Gaussian that transmits: all three.
  EXPECT_EQ(named.size(), 2U * 2U * (1U + kStdDevsMm.size() + 1U + 2U + kStdDevsMm.size()));
  for (const int character : {1, 2}) {
    for (const int light : {1, 2}) {
      const std::string of = "character-" + std::to_string(character) + "-light-" + std::to_string(light);
      for (const std::string map : {"-stretch-0", "-shadow-map", "-entry", "-thickness", "-thickness-2"})
        EXPECT_TRUE(named.contains(of + map)) << of << map;
      const double expected = character == light ? kLight[static_cast<std::size_t>(light - 1)] : 0.0;
      for (std::size_t level = 0; level <= kStdDevsMm.size(); ++level) {
        const std::string name = of + "-level-" + std::to_string(level);
        ASSERT_TRUE(named.contains(name)) << name;
        // Even light, filled gutters: all of the map, to the method's limit on constant light.
        for (const float value : named.at(name).data()) ASSERT_NEAR(value, expected, 1e-5) << name;
      }
    }
  }
}

// On a small ball lit askew from behind every setting shows: its chart is stretched, and has a seam.
TEST(TextureSpaceTransmit, EverySettingCounts) {
  const Mesh ball = make_builtin("sphere", {{"radius_mm", 3.0}, {"edge_mm", 0.5}});
  const Light light = test::lamp(Vec3d(0.5, 0.2, -1.0), true);
  const Scene scene(test::shade(ball, light), test::camera_at(300.0, 8.0, kPx), {{light, {}}});
  const Image standard = run(scene, "texture-space-transmit");
  const std::vector<Given> others = {{{"shadow_map_size", 64.0}},
                                     {{"transmitting_gaussians", 2.0}},
                                     {{"thickness", std::string("same-level")}},
                                     {{"thickness", std::string("unblurred")}},
                                     {{"normal_correction", std::string("off")}},
                                     {{"blend_std_devs", 0.6}},
                                     {{"decay_per_mm", 0.5}},
                                     {{"texture_size", 128.0}},
                                     {{"stretch", std::string("off")}},
                                     {{"stretch", std::string("blurred")}},
                                     {{"taps", std::string("dense")}},
                                     {{"first_gaussian", std::string("irradiance")}},
                                     {{"gutter", std::string("none")}},
                                     {{"passes", std::string("direct")}},
                                     {{"reading", std::string("bicubic")}}};
  for (const Given& given : others) {
    const Image image = run(scene, "texture-space-transmit", given);
    double change = 0.0;
    for (std::size_t i = 0; i < image.data().size(); ++i) {
      ASSERT_TRUE(std::isfinite(image.data()[i])) << given.begin()->first;
      change = std::max(change, std::abs(static_cast<double>(image.data()[i]) - standard.data()[i]));
    }
    EXPECT_GT(change, 1e-5) << given.begin()->first;
  }
}

}  // namespace
}  // namespace truescatter
