// Properties of every method that there is, so that a new one is tested without anyone remembering.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/render.h"

namespace truescatter {
namespace {

using test::Scene;

std::string test_name(const testing::TestParamInfo<std::size_t>& info) {
  std::string name(all_methods()[info.param].name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

// Small maps in texture space: what is tested here holds at any size, and takes 16 times as long at 1024.
constexpr int kTexels = 256;

class EveryMethod : public testing::TestWithParam<std::size_t> {
 protected:
  const Method& method() const { return all_methods()[GetParam()]; }
  Image run(const Scene& scene, const Profile& profile) const {
    const bool has_maps =
        std::any_of(method().settings.begin(), method().settings.end(),
                    [](const SettingSpec& setting) { return setting.name == "texture_size"; });
    std::map<std::string, SettingValue> given;
    if (has_maps) given.emplace("texture_size", static_cast<double>(kTexels));
    return scene.run(method(), profile, given);
  }
};

INSTANTIATE_TEST_SUITE_P(Registry, EveryMethod, testing::Range<std::size_t>(0, all_methods().size()),
                         test_name);

// Its light is all that the mesh has, and methods may follow it.
Scene lit_scene(const Mesh& mesh, const Light& light, const Camera& camera) {
  return {test::shade(mesh, light), camera, {{light, {}}}};
}

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

// What is left of constant light: all of it, or, where the method's own target is raw, what lies within r_max
// on a plane, 1 - exp(-r_max^2 / 2 v) of each Gaussian.
struct PlaneLight {
  Vec3d kept = Vec3d::Ones();
  double tolerance = 0.0;  // NumericLimits::raw_... times what they refer to; 0 for a normalised target
};

// What NumericLimits::raw_perspective is to be multiplied by.
double perspective(const FrameImages& images, double r_max_mm, int margin) {
  double largest = 0.0;
  for (int y = margin; y < images.mask.height() - margin; ++y) {
    for (int x = margin; x < images.mask.width() - margin; ++x) {
      if (images.mask.at(x, y, 0) == 0.0F) continue;
      const Vec3d at = images.position.rgb(x, y);
      const double cosine = std::abs(images.face_normal.rgb(x, y).z());
      const double sine2 = 1.0 - cosine * cosine;
      largest = std::max(
          largest, std::pow(r_max_mm / (at.norm() * cosine), 2) +
                       0.5 * sine2 * std::sqrt(sine2) / cosine * at.head<2>().norm() / std::abs(at.z()));
    }
  }
  return largest;
}

PlaneLight plane_light(const Method& method, const Profile& profile, const FrameImages& images, int margin,
                       double longest_footprint_mm) {
  const OwnTarget target = method.own_target(profile, Settings(method.name, method.settings, {}));
  PlaneLight light;
  if (target.normalised) return light;
  light.kept = profile.delta_weight;
  const double r = target.r_max_mm.value_or(std::numeric_limits<double>::infinity());
  Vec3d rim = Vec3d::Zero();
  for (const GaussianTerm& term : profile.terms) {
    for (int c = 0; c < 3; ++c) {
      const double v = term.variance_mm2[c];
      light.kept[c] -= term.weight[c] * std::expm1(-0.5 * r * r / v);
      const double density = std::exp(-0.5 * r * r / v) / (2.0 * kPi * v);
      if (density > 0.0)
        rim[c] += term.weight[c] * density * r * std::min(longest_footprint_mm, 0.5 * std::sqrt(v));
    }
  }
  light.tolerance =
      method.limits.raw_rim * rim.maxCoeff() + method.limits.raw_perspective * perspective(images, r, margin);
  return light;
}

Image times(Image image, const Vec3d& factor) {
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) image.set_rgb(x, y, image.rgb(x, y).cwiseProduct(factor));
  }
  return image;
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
    const Scene scene = lit_scene(plane, test::lamp(normal), test::camera_at(600.0, 40.0, 128));
    for (const Profile& profile : builtin_profiles()) {
      const Image result = run(scene, profile);
      // A pixel's edge of 40 / 128 mm in the plane that faces the camera.
      const PlaneLight light =
          plane_light(method(), profile, scene.images(), 40, 40.0 / 128 / std::cos(tilt_deg * kPi / 180.0));
      EXPECT_LE(
          largest_difference(result, times(scene.images().irradiance, light.kept), scene.images().mask, 40),
          method().limits.rounding + light.tolerance)
          << profile.name << " at " << tilt_deg << " degrees";
    }
  }
}

// Irradiance's largest change from a pixel to the next, both skin.
double largest_step(const FrameImages& images, int margin) {
  double step = 0.0;
  for (int y = margin; y + 1 < images.mask.height() - margin; ++y) {
    for (int x = margin; x + 1 < images.mask.width() - margin; ++x) {
      for (const auto& [nx, ny] : {std::pair(x + 1, y), std::pair(x, y + 1)}) {
        if (images.mask.at(x, y, 0) == 0.0F || images.mask.at(nx, ny, 0) == 0.0F) continue;
        const Vec3d change = images.irradiance.rgb(nx, ny) - images.irradiance.rgb(x, y);
        step = std::max(step, change.cwiseAbs().maxCoeff());
      }
    }
  }
  return step;
}

// The largest edge of a texel on the mesh's surface.
double largest_texel_mm(const Mesh& mesh, int texture_size) {
  double largest = 0.0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3;
      const auto at = [&](std::size_t k) {
        return mesh.positions_mm[static_cast<std::size_t>(mesh.triangles[t][k])];
      };
      const double uv = ((*mesh.corner_uvs)[t][next] - (*mesh.corner_uvs)[t][c]).norm();
      largest = std::max(largest, (at(next) - at(c)).norm() / (uv * texture_size));
    }
  }
  return largest;
}

TEST_P(EveryMethod, IsTheIdentityAsWidthsGoToZero) {
  // A cosine of light over a sphere, widths a thousandth of the skin's: 0.003 mm against pixels of 0.3 mm.
  const Mesh sphere = make_builtin("sphere");
  const Scene scene = lit_scene(sphere, test::lamp(Vec3d(0.5, 0.3, 1.0)), test::camera_at(400.0, 40.0, 128));
  constexpr int kMargin = 14;  // away from the silhouette's background
  constexpr double kMmPerPx = 40.0 / 128;
  const double step = largest_step(scene.images(), kMargin - 1);
  // Along the surface irradiance changes by no more per mm than from pixel to pixel, where it is
  // foreshortened.
  const double texel_change = largest_texel_mm(sphere, kTexels) * step / kMmPerPx;
  const NumericLimits& limits = method().limits;
  for (const Profile& profile : builtin_profiles()) {
    const Profile narrow = scaled(profile, 1e-3);
    double widths_px = 0.0;
    for (const GaussianLevel& level : gaussian_levels(narrow)) widths_px += level.std_dev_mm() / kMmPerPx;
    const Image result = run(scene, narrow);
    // Every Gaussian is narrower than a pixel's edge, so that this does not matter.
    const PlaneLight light = plane_light(method(), narrow, scene.images(), kMargin, kMmPerPx);
    EXPECT_LE(largest_difference(result, times(scene.images().irradiance, light.kept), scene.images().mask,
                                 kMargin),
              limits.rounding + light.tolerance + limits.identity_per_px * widths_px * step +
                  limits.identity_per_texel * texel_change)
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
  const Scene scene = lit_scene(mesh, test::lamp(Vec3d(0.9, 0.2, 0.5)), camera);
  const Scene other = lit_scene(mirrored(mesh), test::lamp(Vec3d(-0.9, 0.2, 0.5)), camera);
  for (const Profile& profile : builtin_profiles()) {
    const Image result = run(scene, profile);
    const Image reflected = run(other, profile);
    int compared = 0;
    double worst = 0.0;
    for (int y = 0; y < 96; ++y) {
      for (int x = 0; x < 96; ++x) {
        const int mx = 95 - x;
        if (scene.images().mask.at(x, y, 0) == 0.0F || other.images().mask.at(mx, y, 0) == 0.0F) continue;
        ++compared;
        worst = std::max(worst, (result.rgb(x, y) - reflected.rgb(mx, y)).cwiseAbs().maxCoeff());
      }
    }
    ASSERT_GT(compared, 2000);
    // The frames themselves are the mirror of each other to the rasteriser's rounding of irradiance.
    constexpr double kFrame = 1e-6;
    EXPECT_LE(worst, method().limits.rounding + kFrame) << profile.name;
  }
}

// What is not skin gives no light: with it dark or five times as bright, skin is the same to the last bit. A
// method whose source has no mask says so, and must differ.
TEST_P(EveryMethod, TakesNoLightFromWhatIsNotSkin) {
  const auto with_other_light = [](double light) {
    ShadingMesh shading = test::shade(make_builtin("plane"), test::lamp(Vec3d(0.3, 0.2, 1.0)));
    for (ShadingTriangle& triangle : shading.triangles) {
      const double middle_x = (shading.corner(triangle, 0).x() + shading.corner(triangle, 1).x() +
                               shading.corner(triangle, 2).x()) /
                              3.0;
      if (middle_x > 0.0) continue;
      triangle.skin = false;
      triangle.component = -1;
      triangle.irradiance.fill(Vec3d::Constant(light));
    }
    return shading;
  };
  const Camera camera = test::camera_at(300.0, 20.0, 48);
  const Scene dark(with_other_light(0.0), camera);
  const Scene bright(with_other_light(5.0), camera);
  for (const Profile& profile : builtin_profiles()) {
    const double difference =
        largest_difference(run(dark, profile), run(bright, profile), dark.images().mask, 0);
    if (method().masks_its_taps) {
      EXPECT_EQ(difference, 0.0) << profile.name;
    } else {
      EXPECT_GT(difference, 0.1) << profile.name;
    }
  }
}

// A strip of skin as wide as a pixel, aslant, under light of 1: no division by the little that is there makes
// more of it than there is, or none.
TEST_P(EveryMethod, KeepsFeaturesOfOnePixelWithinTheirLight) {
  constexpr double kPixel_mm = 40.0 / 128.0;
  Mesh strip = make_builtin("plane", {{"size_mm", 30.0}, {"edge_mm", 3.0}});
  const Eigen::AngleAxisd turn(0.2, Vec3d::UnitZ());
  for (Vec3d& p : strip.positions_mm) p = turn * Vec3d(p.x() * kPixel_mm / 30.0, p.y(), p.z());
  const Scene scene = lit_scene(strip, test::lamp(Vec3d::UnitZ()), test::camera_at(600.0, 40.0, 128));
  int pixels = 0;
  for (const Profile& profile : builtin_profiles()) {
    const Image result = run(scene, profile);
    for (int y = 0; y < result.height(); ++y) {
      for (int x = 0; x < result.width(); ++x) {
        if (scene.images().mask.at(x, y, 0) == 0.0F) continue;
        ++pixels;
        for (int c = 0; c < 3; ++c) {
          ASSERT_GE(result.at(x, y, c), -method().limits.rounding) << profile.name;
          ASSERT_LE(result.at(x, y, c), 1.0 + method().limits.rounding) << profile.name;
        }
      }
    }
  }
  EXPECT_GT(pixels, 3 * 60);
}

TEST_P(EveryMethod, GivesNumbersAtGrazingAnglesAndOnAnEmptyFrame) {
  Mesh plane = make_builtin("plane");
  const Eigen::AngleAxisd turn(89.9 * kPi / 180.0, Vec3d::UnitX());
  for (Vec3d& p : plane.positions_mm) p = turn * p;
  for (auto& corner : plane.corner_normals) {
    for (Vec3d& n : corner) n = turn * n;
  }
  const Light light = test::lamp(Vec3d(0.0, 0.2, 1.0));
  const Scene grazing = lit_scene(plane, light, test::camera_at(300.0, 20.0, 64));
  Camera away = test::camera_at(300.0, 20.0, 16);
  away.target_mm = Vec3d(0.0, 0.0, 600.0);
  const Scene empty = lit_scene(plane, light, away);
  for (const Scene* scene : {&grazing, &empty}) {
    for (const Profile& profile : builtin_profiles()) {
      const Image result = run(*scene, profile);
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
  const SurfaceBuffers buffers(Scene::context(), shading, {{test::lamp(Vec3d::UnitZ()), {}}});
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
