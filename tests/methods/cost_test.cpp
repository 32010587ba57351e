// Passes, fetches and bytes counted by hand from the shaders' texts. Every texture holds 16 bytes a texel
// (four floats) but the frame's uv, which holds 8 (two floats).
#include <gtest/gtest.h>

#include <cmath>

#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;

// One term with three variances, so three levels for a method that blurs all channels alike.
const Profile& spike_and_base() { return builtin_profiles().front(); }

// A square that faces the camera, 400 mm away, seen with background around it.
Scene square(double size_mm, double height_mm, int px) {
  const Mesh plane = make_builtin("plane", {{"size_mm", size_mm}, {"edge_mm", size_mm / 4.0}});
  return {test::shade(plane, test::lamp(Vec3d::UnitZ())), test::camera_at(400.0, height_mm, px)};
}

struct Pixels {
  double all = 0.0;
  double skin = 0.0;
};

Pixels pixels_of(const Scene& scene) {
  Pixels pixels;
  for (const float v : scene.images().mask.data()) {
    pixels.all += 1.0;
    pixels.skin += v > 0.0F ? 1.0 : 0.0;
  }
  return pixels;
}

Passes::Counts counts_of(const Scene& scene, std::string_view name, const Profile& profile,
                         const std::map<std::string, SettingValue>& given = {},
                         const std::vector<LightField>& lights = {}) {
  const Method& method = find_method(name);
  const Settings settings(method.name, method.settings, given);
  const SurfaceBuffers buffers(Scene::context(), scene.shading(), lights);
  const PreparedMethod prepared =
      method.prepare({Scene::context(), scene.frame(), buffers, 400.0, profile, settings});
  Passes passes(Scene::context());
  return passes.count([&] { prepared.render(passes); });
}

TEST(Cost, NoneReadsNothing) {
  const Scene scene = square(60.0, 80.0, 32);
  const Passes::Counts counts = counts_of(scene, "none", spike_and_base());
  EXPECT_EQ(counts.passes, 0);
  EXPECT_EQ(counts.texels_read, 0.0);
  EXPECT_EQ(counts.bytes_read, 0.0);
}

// At a thousandth of the profile's widths every tap rounds to the pixel itself, so none is dropped. Reads:
//   first.frag        irradiance                                             1          off the skin  1
//   pscbf.frag, 2 x   source, position, normal; per tap source, position     3 + 2 N                  1
//   accumulate.frag   irradiance, level                                      2                        1
// With one term: 1 + 2 (3 + 2 N) + 2 = 9 + 4 N on skin, 4 off it, in 4 passes.
TEST(Cost, PscbfOfTapsThatAllCount) {
  const Scene scene = square(60.0, 80.0, 32);
  const Pixels pixels = pixels_of(scene);
  ASSERT_GT(pixels.skin, 0.0);
  ASSERT_LT(pixels.skin, pixels.all);
  for (const double taps : {13.0, 7.0}) {
    const Passes::Counts counts = counts_of(scene, "pscbf", scaled(spike_and_base(), 1e-3), {{"taps", taps}});
    const double expected = (9.0 + 4.0 * taps) * pixels.skin + 4.0 * (pixels.all - pixels.skin);
    EXPECT_EQ(counts.passes, 4);
    EXPECT_EQ(counts.texels_read, expected);
    EXPECT_EQ(counts.bytes_read, 16.0 * expected);
  }
}

// One skin pixel, of 2.5 mm, alone. r_max = 4.5 mm is a reach of 1.8 px; the 13 medians lie at 0, +-0.19,
// +-0.40,
// +-0.62, +-0.87, +-1.20, +-1.77 standard deviations of sqrt(2.3) mm = 0.607 px: 0, 0.12, 0.24, 0.37, 0.53,
// 0.73, 1.07 px. So three on either side fall on the next pixel, where the source says "no skin" and the
// position is not read: 3 + 13 + 7 = 23 reads an axis, 1 + 2 * 23 + 2 = 49 on the pixel.
TEST(Cost, PscbfReadsNoPositionOffTheSkin) {
  const Scene scene = square(1.0, 82.5, 33);
  const Pixels pixels = pixels_of(scene);
  ASSERT_EQ(pixels.skin, 1.0);
  const Passes::Counts counts = counts_of(scene, "pscbf", spike_and_base());
  EXPECT_EQ(counts.texels_read, 49.0 + 4.0 * (pixels.all - 1.0));
  EXPECT_EQ(counts.bytes_read, 16.0 * counts.texels_read);
}

// The square's chart is the whole UV square, so every texel is covered. Reads:
//   uv_irradiance, uv_stretch   none
//   fill_gutter, each map       per texel source                                        1
//   first.frag                  irradiance                                              1
//   texture_space.frag, 2 x     per texel source, stretch, six bilinear taps of four    26
//                               without the stretch map                                 25
//   gather.frag                 irradiance, uv (8 bytes), bilinear level                1 + 1 + 4
//                               off the skin                                            1
// With three levels: 4 + 1 + 3 * 3 = 14 passes, 12 without the stretch map.
TEST(Cost, TextureSpaceChargesUvByItsFormat) {
  const Scene scene = square(60.0, 80.0, 32);
  const Pixels pixels = pixels_of(scene);
  ASSERT_GT(pixels.skin, 0.0);
  constexpr double kSize = 16.0;
  for (const bool stretch : {true, false}) {
    const Passes::Counts counts =
        counts_of(scene, "texture-space", spike_and_base(),
                  {{"texture_size", kSize}, {"stretch", std::string(stretch ? "raw" : "off")}});
    const double blurs = 2.0 * (stretch ? 26.0 : 25.0) * kSize * kSize;
    const double fills = (stretch ? 2.0 : 1.0) * kSize * kSize;
    const double background = pixels.all - pixels.skin;
    EXPECT_EQ(counts.passes, stretch ? 14 : 12);
    EXPECT_EQ(counts.texels_read, pixels.all + fills + 3.0 * (blurs + 6.0 * pixels.skin + background));
    EXPECT_EQ(counts.bytes_read,
              16.0 * (pixels.all + fills) +
                  3.0 * (16.0 * blurs + (16.0 + 8.0 + 4.0 * 16.0) * pixels.skin + 16.0 * background));
  }
}

// The same square, lit from the front: no texel has a thickness, so its shadow map is not read for one, and
// no level at an entry. Reads beyond texture-space's, which are above:
//   entry.frag                        irradiance, position, uv (8 bytes), shadow map, stretch   4 + 4
//   thickness.frag, each level        irradiance, uv, bilinear level                            1 + 1 + 4
//   texture_space_transmit.frag, each entry, thickness (4 bytes); off the skin the entry alone  2
//                                     off the skin one each
// and passes: shadow_map.frag, entry.frag, and two for each of three levels. From behind, every texel reads
// the shadow map and, bilinearly, the normal: 5; and every pixel its three levels: 4 each.
TEST(Cost, TextureSpaceTransmitReadsItsMaps) {
  const Scene scene = square(60.0, 80.0, 32);
  const Pixels pixels = pixels_of(scene);
  constexpr double kSize = 16.0;
  const double background = pixels.all - pixels.skin;
  const std::map<std::string, SettingValue> given = {{"texture_size", kSize}};
  const Passes::Counts plain = counts_of(scene, "texture-space", spike_and_base(), given);
  const auto counts_lit = [&](const Vec3d& direction) {
    return counts_of(scene, "texture-space-transmit", spike_and_base(), given,
                     {{test::lamp(direction, true), {}}});
  };
  const Passes::Counts front = counts_lit(Vec3d::UnitZ());
  EXPECT_EQ(front.passes, plain.passes + 8);
  EXPECT_EQ(front.texels_read - plain.texels_read,
            (8.0 + 3.0 * (6.0 + 2.0)) * pixels.skin + (1.0 + 3.0 * 2.0) * background);
  EXPECT_EQ(front.bytes_read - plain.bytes_read,
            (16.0 * 7.0 + 8.0 + 3.0 * (5.0 * 16.0 + 8.0 + 16.0 + 4.0)) * pixels.skin +
                16.0 * (1.0 + 3.0 * 2.0) * background);
  const Passes::Counts behind = counts_lit(-Vec3d::UnitZ());
  EXPECT_EQ(behind.passes, front.passes);
  EXPECT_EQ(behind.texels_read - front.texels_read, 5.0 * kSize * kSize + 3.0 * 4.0 * pixels.skin);
}

}  // namespace
}  // namespace truescatter
