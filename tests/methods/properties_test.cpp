// Properties of every method that there is, so that a new one is tested without anyone remembering.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;

std::string test_name(const testing::TestParamInfo<std::size_t>& info) {
  std::string name(all_methods()[info.param].name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class EveryMethod : public testing::TestWithParam<std::size_t> {
 protected:
  const Method& method() const { return all_methods()[GetParam()]; }
};

INSTANTIATE_TEST_SUITE_P(Registry, EveryMethod, testing::Range<std::size_t>(0, all_methods().size()),
                         test_name);

double largest_difference(const Image& a, const Image& b, const Image& mask, int margin) {
  double worst = 0.0;
  for (int y = margin; y < a.height() - margin; ++y) {
    for (int x = margin; x < a.width() - margin; ++x) {
      if (mask.at(x, y, 0) != 0.0F)
        worst = std::max(worst, (a.rgb(x, y) - b.rgb(x, y)).cwiseAbs().maxCoeff());
    }
  }
  return worst;
}

TEST_P(EveryMethod, KeepsConstantLightConstant) {
  // A plane lit evenly and larger than the frame; also tilted. What a method loses beyond the frame (blur2d,
  // by design) stays within its 4 standard deviations: the widest is 2.72 mm = 8.7 px, so 35 px.
  for (const double tilt_deg : {0.0, 50.0}) {
    Mesh plane = make_builtin("plane", {{"size_mm", 160.0}, {"edge_mm", 8.0}});
    const Eigen::AngleAxisd turn(tilt_deg * kPi / 180.0, Vec3d(1.0, 0.4, 0.0).normalized());
    for (Vec3d& p : plane.positions_mm) p = turn * p;
    for (auto& corner : plane.corner_normals) {
      for (Vec3d& n : corner) n = turn * n;
    }
    const Vec3d normal = turn * Vec3d::UnitZ();
    const Scene scene(test::shade(plane, test::lamp(normal)), test::camera_at(600.0, 40.0, 128));
    for (const Profile& profile : builtin_profiles()) {
      const Image result = scene.run(method(), profile);
      // The manuals' limit: float rounding of normalised sums, 1e-5 at most (texture space's bilinear alpha).
      EXPECT_LE(largest_difference(result, scene.images().irradiance, scene.images().mask, 40), 1e-5)
          << profile.name << " at " << tilt_deg << " degrees";
    }
  }
}

TEST_P(EveryMethod, IsTheIdentityAsWidthsGoToZero) {
  // A cosine of light over a sphere, widths a thousandth of the skin's: 0.003 mm against pixels of 0.3 mm.
  const Scene scene(test::shade(make_builtin("sphere"), test::lamp(Vec3d(0.5, 0.3, 1.0))),
                    test::camera_at(400.0, 40.0, 128));
  // screen-gaussian: 0.76 s_px per axis and level (6 levels of at most 0.009 px) times the largest step
  // between pixels. Irradiance falls by at most 1/25 per mm along the sphere; where the frame ends, at 20 mm
  // from the axis, the surface turns by 53 degrees, so a pixel of 0.3 mm spans 0.5 mm and a step of 0.021
  // (0.04 on the diagonal). 12 * 0.76 * 0.009 * 0.04 = 3.3e-3; the levels' steps shrink, so this is generous.
  // texture-space: half a texel's diagonal, 0.7 * (about 0.2 mm per texel of a 1024 atlas) / 25 mm = 6e-3,
  // and irradiance is read at the texel's centre on the facet.
  const double limit = method().needs_uvs ? 6e-3 : 3.3e-3;
  for (const Profile& profile : builtin_profiles()) {
    const Image result = scene.run(method(), scaled(profile, 1e-3));
    // Away from the silhouette's background, which the frame does not show: the frame is inside the disc.
    EXPECT_LE(largest_difference(result, scene.images().irradiance, scene.images().mask, 14), limit)
        << profile.name;
  }
}

Mesh mirrored(Mesh mesh) {
  for (Vec3d& p : mesh.positions_mm) p.x() = -p.x();
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    for (Vec3d& n : mesh.corner_normals[t]) n.x() = -n.x();
    std::swap(mesh.corner_normals[t][1], mesh.corner_normals[t][2]);
    if (mesh.has_uvs()) std::swap((*mesh.corner_uvs)[t][1], (*mesh.corner_uvs)[t][2]);
  }
  return mesh;
}

TEST_P(EveryMethod, MapsAMirroredFrameToTheMirroredResult) {
  const Mesh mesh = make_builtin("tube");
  const Camera camera = test::camera_at(300.0, 50.0, 96);
  const Scene scene(test::shade(mesh, test::lamp(Vec3d(0.9, 0.2, 0.5))), camera);
  const Scene other(test::shade(mirrored(mesh), test::lamp(Vec3d(-0.9, 0.2, 0.5))), camera);
  for (const Profile& profile : builtin_profiles()) {
    const Image result = scene.run(method(), profile);
    const Image reflected = other.run(method(), profile);
    int compared = 0;
    int different = 0;
    for (int y = 0; y < 96; ++y) {
      for (int x = 0; x < 96; ++x) {
        const int mx = 95 - x;
        if (scene.images().mask.at(x, y, 0) == 0.0F || other.images().mask.at(mx, y, 0) == 0.0F) continue;
        ++compared;
        // Float rounding of what a method computes: 1e-5. Texture space reads its map at a uv that differs by
        // rounding too: 1e-6 of the map times 1024 texels times a step of 0.05 between texels.
        if ((result.rgb(x, y) - reflected.rgb(mx, y)).cwiseAbs().maxCoeff() > 1e-4) ++different;
      }
    }
    ASSERT_GT(compared, 2000);
    // A pixel whose centre falls on an edge, or a tap that rounds to one of two pixels, may go either way: a
    // share of about the coordinates' rounding (1e-5 px) times the number of taps, so next to none.
    EXPECT_LE(different, compared / 500) << profile.name;
  }
}

TEST_P(EveryMethod, GivesNumbersAtGrazingAnglesAndOnAnEmptyFrame) {
  Mesh plane = make_builtin("plane");
  const Eigen::AngleAxisd turn(89.9 * kPi / 180.0, Vec3d::UnitX());
  for (Vec3d& p : plane.positions_mm) p = turn * p;
  for (auto& corner : plane.corner_normals) {
    for (Vec3d& n : corner) n = turn * n;
  }
  const Scene grazing(test::shade(plane, test::lamp(Vec3d(0.0, 0.2, 1.0))), test::camera_at(300.0, 20.0, 64));
  Camera away = test::camera_at(300.0, 20.0, 16);
  away.target_mm = Vec3d(0.0, 0.0, 600.0);
  const Scene empty(test::shade(plane, test::lamp(Vec3d(0.0, 0.2, 1.0))), away);
  for (const Scene* scene : {&grazing, &empty}) {
    for (const Profile& profile : builtin_profiles()) {
      const Image result = scene->run(method(), profile);
      for (const float v : result.data()) ASSERT_TRUE(std::isfinite(v)) << profile.name;
    }
  }
}

TEST_P(EveryMethod, CountsItsPassesAndReads) {
  const Scene scene(test::shade(make_builtin("sphere"), test::lamp(Vec3d::UnitZ())),
                    test::camera_at(400.0, 60.0, 32));
  const Settings settings(method().name, method().settings, {});
  const Profile& profile = builtin_profiles().front();
  const Mesh mesh = make_builtin("sphere");
  const ShadingMesh shading = test::shade(mesh, test::lamp(Vec3d::UnitZ()));
  const SurfaceBuffers buffers(Scene::context(), shading);
  const PreparedMethod prepared =
      method().prepare({Scene::context(), scene.frame(), buffers, 400.0, profile, settings});
  Passes passes(Scene::context());
  prepared.render(passes);
  const Image before = gpu::read_texture(Scene::context(), *prepared.output, 3);
  const Passes::Counts counts = passes.count([&] { prepared.render(passes); });
  const Image after = gpu::read_texture(Scene::context(), *prepared.output, 3);
  EXPECT_EQ(counts.passes == 0, method().name == "none");
  EXPECT_EQ(counts.texels_read > 0.0, counts.passes > 0);
  // No format has texels of more than 16 bytes, or of less than one; what each is counted as: cost_test.cpp.
  EXPECT_LE(counts.bytes_read, 16.0 * counts.texels_read);
  EXPECT_GE(counts.bytes_read, counts.texels_read);
  // Counting does not change the picture.
  EXPECT_EQ(largest_difference(before, after, scene.images().mask, 0), 0.0);
}

}  // namespace
}  // namespace truescatter
