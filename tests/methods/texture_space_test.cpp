// Texture-space diffusion on charts where the answer is known.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

#include "support/render.h"
#include "support/sampling.h"
#include "truth/geodesic_fast.h"
#include "truth/geodesic_surface.h"

namespace truescatter {
namespace {

using test::Scene;
using Given = std::map<std::string, SettingValue>;

constexpr double kSizeMm = 60.0;
constexpr std::size_t kLevels = 6;
const std::array<double, kLevels> kVariancesMm2 = {0.0064, 0.0484, 0.187, 0.567, 1.99, 7.41};

Image run(const Scene& scene, const Profile& profile, const Given& given) {
  return scene.run(find_method("texture-space"), profile, given);
}

// The six variances of the skin's profile; channel c shows level `first` + c alone. The levels before it are
// there, for they are blurred on the way, with a weight that nobody sees.
Profile three_levels(std::size_t first) {
  Profile profile;
  profile.name = "levels";
  profile.r_max_mm = 10.0;
  for (std::size_t i = 0; i < first + 3; ++i) {
    Vec3d weight = Vec3d::Constant(1e-12);
    if (i >= first) weight = Vec3d::Unit(static_cast<Eigen::Index>(i - first));
    profile.terms.push_back({Vec3d::Constant(kVariancesMm2[i]), weight});
  }
  return profile;
}

// The plane whose chart is the whole UV square, or where v runs over 1 / `anisotropy` of it only, lit by
// |x| / 30 mm (axis 0) or |y| / 30 mm. Its triangles have edges along both kinks.
Scene lit_by_a_kink(Eigen::Index axis, double anisotropy, double view_mm) {
  Mesh plane = make_builtin("plane", {{"size_mm", kSizeMm}, {"edge_mm", 5.0}});
  for (auto& corners : *plane.corner_uvs) {
    for (Vec2d& uv : corners) uv.y() = 0.5 + (uv.y() - 0.5) / anisotropy;
  }
  ShadingMesh shading = test::shade(plane, test::lamp(Vec3d::UnitZ()));
  for (ShadingTriangle& triangle : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      triangle.irradiance[c].setConstant(std::abs(shading.corner(triangle, c)[axis]) / (0.5 * kSizeMm));
    }
  }
  return {std::move(shading), test::camera_at(1000.0, view_mm, 768)};
}

// The variance along `axis` that a blur adds, per channel: with I = |x| and any kernel k of mean 0 and
// variance v, int (k * I - I) dx = v / 2 int I'' = v. Taken along the middle row, or column, of pixels.
Vec3d added_variance_mm2(const Scene& scene, const Image& blurred, Eigen::Index axis, double view_mm) {
  const int px = blurred.width();
  Vec3d sum = Vec3d::Zero();
  for (int i = 0; i < px; ++i) {
    const int x = axis == 0 ? i : px / 2;
    const int y = axis == 0 ? px / 2 : i;
    sum += blurred.rgb(x, y) - scene.images().irradiance.rgb(x, y);
  }
  return sum * view_mm / px * (0.5 * kSizeMm);
}

// What the sum over pixels, p apart, makes of the integral of a function that is linear between knots: each
// knot errs by (f (1 - f) - 1/6) / 2 p^2 times its change of slope, f its place between two pixels: p^2 / 8
// at most, with changes of slope that sum to 2 before the blur and 2 after it (a kernel keeps them). And
// the pictures are floats: 768 pixels of values up to 1 whose sum is off by 1e-7 each, in units of 30 mm.
double summing_error_mm2(double view_mm) {
  const double pixel_mm = view_mm / 768;
  return 4.0 * pixel_mm * pixel_mm / 8.0 + 1e-7 * view_mm * 0.5 * kSizeMm;
}

// Texels of width h, whose centres straddle the kink, see |x| as its linear interpolation, which has a
// quarter of h^2 more in the integral above. A discrete kernel keeps that.
double interpolated_kink_mm2(double texel_mm) { return 0.25 * texel_mm * texel_mm; }

TEST(TextureSpace, DenseTapsReproduceEveryVarianceIncrementally) {
  // The discrete Gaussian has the variance asked for at any width, so what is left are the summing and the
  // cut at 5 s + 2 texels, where of the variance erfc(5 / sqrt 2) + 10 phi(5) = 1.6e-5 remains.
  constexpr int kTexels = 512;
  constexpr double kTexelMm = kSizeMm / kTexels;
  for (const std::size_t first : {std::size_t{0}, std::size_t{3}}) {
    const double view_mm = first == 0 ? 5.0 : 28.0;
    for (const Eigen::Index axis : {0, 1}) {
      const Scene scene = lit_by_a_kink(axis, 1.0, view_mm);
      const Image blurred =
          run(scene, three_levels(first),
              {{"taps", std::string("dense")}, {"texture_size", static_cast<double>(kTexels)}});
      const Vec3d added = added_variance_mm2(scene, blurred, axis, view_mm);
      for (Eigen::Index c = 0; c < 3; ++c) {
        const double expected = kVariancesMm2[first + static_cast<std::size_t>(c)];
        const double measured = added[c] - interpolated_kink_mm2(kTexelMm);
        const double tolerance = 2e-5 * expected + summing_error_mm2(view_mm);
        EXPECT_NEAR(measured, expected, tolerance) << "level " << first + static_cast<std::size_t>(c);
        EXPECT_LT(tolerance, 0.01 * expected);  // so that it is the 1 % that is tested
      }
    }
  }
}

// What the seven taps add to the variance, in texels^2: the taps themselves, and reading between two texels,
// which spreads a tap by f (1 - f) for the fraction f of its offset.
double variance_of_seven_px2(double std_dev_px) {
  const std::array<double, 4> weights = {0.383, 0.242, 0.061, 0.006};
  double variance = 0.0;
  for (std::size_t k = 1; k < weights.size(); ++k) {
    const double offset = static_cast<double>(k) * std_dev_px;
    const double f = offset - std::floor(offset);
    variance += 2.0 * weights[k] * (offset * offset + f * (1.0 - f));
  }
  return variance / 1.001;
}

TEST(TextureSpace, SevenTapsHaveTheirOwnVarianceAtEveryLevel) {
  constexpr double kTexelMm = kSizeMm / 1024;
  for (const std::size_t first : {std::size_t{0}, std::size_t{3}}) {
    const double view_mm = first == 0 ? 5.0 : 28.0;
    const Scene scene = lit_by_a_kink(0, 1.0, view_mm);
    const Vec3d added = added_variance_mm2(scene, run(scene, three_levels(first), {}), 0, view_mm);
    double expected = 0.0;
    double previous = 0.0;
    for (std::size_t i = 0; i < first + 3; ++i) {
      const double step_px = std::sqrt(kVariancesMm2[i] - previous) / kTexelMm;
      expected += variance_of_seven_px2(step_px) * kTexelMm * kTexelMm;
      previous = kVariancesMm2[i];
      if (i < first) continue;
      const double measured = added[static_cast<Eigen::Index>(i - first)] - interpolated_kink_mm2(kTexelMm);
      // The rasteriser takes a texture coordinate's fraction to 8 bits: a tap lands within 2^-9 texels of
      // where it should, on either side alike.
      const double fraction = 4.0 * step_px * std::exp2(-9.0) * kTexelMm * kTexelMm;
      EXPECT_NEAR(measured, expected, fraction * static_cast<double>(i + 1) + summing_error_mm2(view_mm));
      // 2 (0.242 + 4 0.061 + 9 0.006) / 1.001 = 1.0789, plus a quarter of a texel^2 for each level at most
      // (only 0.618 of the weight is not in the middle): 1 % of the fourth variance and below for the
      // others.
      const double reading = 0.25 * 0.618 * static_cast<double>(i + 1) * kTexelMm * kTexelMm;
      if (i >= 3) {
        EXPECT_GE(measured, 1.0789 * previous - summing_error_mm2(view_mm) - 0.001 * previous);
        EXPECT_LE(measured, 1.0790 * previous + reading + summing_error_mm2(view_mm) + 0.001 * previous);
        EXPECT_LT(reading, 0.01 * previous);
      }
    }
  }
}

TEST(TextureSpace, CorrectsAnisotropicStretchOrNot) {
  // Along u a texel is 60 mm / N wide, along v `a` times that. With the mean instead, 60 sqrt(a) / N, the
  // widths are off by 1 / sqrt(a) along u and sqrt(a) along v: the variances by 1 / a and a. A blurred map of
  // what is the same everywhere is the raw one.
  constexpr int kTexels = 256;
  constexpr double kViewMm = 30.0;
  Profile profile = three_levels(0);
  profile.terms = {{Vec3d::Constant(1.5), Vec3d::Ones()}};
  for (const double a : {1.0, 2.0, 4.0, 8.0, 16.0}) {
    for (const Eigen::Index axis : {0, 1}) {
      const Scene scene = lit_by_a_kink(axis, a, kViewMm);
      const double texel_mm = kSizeMm / kTexels * (axis == 0 ? 1.0 : a);
      const auto measured = [&](const char* stretch) {
        const Image blurred = run(scene, profile,
                                  {{"taps", std::string("dense")},
                                   {"stretch", std::string(stretch)},
                                   {"texture_size", static_cast<double>(kTexels)}});
        return added_variance_mm2(scene, blurred, axis, kViewMm).x() - interpolated_kink_mm2(texel_mm);
      };
      // Beyond the summing: the chart's scale out of float derivatives of positions up to 30 mm, of which a
      // step of 0.03 mm keeps 30 2^-24 / 0.03 = 6e-5, twice in a variance.
      const double tolerance = 2e-4 * 1.5 + summing_error_mm2(kViewMm);
      EXPECT_NEAR(measured("raw"), 1.5, tolerance) << a;
      EXPECT_NEAR(measured("blurred"), 1.5, tolerance) << a;
      // Off, along v, the blur reaches 5 sqrt(1.5 a) = 24 mm at a = 16, beyond the view's 15 mm: there only
      // the row through the view's middle up to a = 2 is asked.
      const double off = axis == 0 ? 1.5 / a : 1.5 * a;
      if (off <= 3.0) {
        EXPECT_NEAR(measured("off"), off, tolerance * std::max(1.0, off)) << a;
      }
    }
  }
}

TEST(TextureSpace, TheIrradianceAsFirstGaussianLacksItsVariance) {
  constexpr double kViewMm = 5.0;
  const Scene scene = lit_by_a_kink(0, 1.0, kViewMm);
  const Image blurred = run(scene, three_levels(0),
                            {{"taps", std::string("dense")}, {"first_gaussian", std::string("irradiance")}});
  const Vec3d added =
      added_variance_mm2(scene, blurred, 0, kViewMm).array() - interpolated_kink_mm2(kSizeMm / 1024);
  const double tolerance = 2e-5 * kVariancesMm2[2] + summing_error_mm2(kViewMm);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(added[static_cast<Eigen::Index>(i)], kVariancesMm2[i] - kVariancesMm2[0], tolerance);
}

TEST(TextureSpace, PublishedWeightsBrightenEveryLevelTwice) {
  const Mesh plane = make_builtin("plane", {{"size_mm", kSizeMm}});
  const Scene scene(test::shade(plane, test::lamp(Vec3d::UnitZ())), test::camera_at(1000.0, 30.0, 32));
  const Image bright = run(scene, three_levels(3), {{"taps", std::string("seven-published")}});
  // Two axes each; float rounding as in the manual.
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(bright.at(16, 16, i), std::pow(1.001, 2.0 * (4 + i)), 1e-5) << "level " << 4 + i;
}

// The common properties are asked of the default settings; these two of the others.
TEST(TextureSpace, EverySettingKeepsConstantLightAndMeetsTheEmptyFrame) {
  Camera away = test::camera_at(300.0, 30.0, 16);
  away.target_mm = Vec3d(0.0, 0.0, 600.0);
  ShadingMesh even = test::shade(make_builtin("tube"), test::lamp(Vec3d::UnitZ()));
  for (ShadingTriangle& t : even.triangles) t.irradiance.fill(Vec3d(0.3, 0.6, 0.9));
  const Scene scene(even, test::camera_at(300.0, 30.0, 64));
  const Scene empty(even, away);
  const Profile& profile = builtin_profiles().back();
  // The skin's profile keeps energy to a thousandth: it is its sum that is compared.
  const Vec3d expected = profile.total_weight().cwiseProduct(Vec3d(0.3, 0.6, 0.9));
  for (const std::string stretch : {"raw", "blurred", "off"}) {
    for (const std::string taps : {"seven", "dense"}) {
      for (const std::string first : {"blurred", "irradiance"}) {
        for (const std::string gutter : {"nearest", "coverage"}) {
          const Given given = {{"stretch", stretch},
                               {"taps", taps},
                               {"first_gaussian", first},
                               {"gutter", gutter},
                               {"texture_size", 256.0}};
          const Image image = run(scene, profile, given);
          double worst = 0.0;
          for (int y = 0; y < 64; ++y) {
            for (int x = 0; x < 64; ++x) {
              if (scene.images().mask.at(x, y, 0) > 0.0F)
                worst = std::max(worst, (image.rgb(x, y) - expected).cwiseAbs().maxCoeff());
            }
          }
          EXPECT_LE(worst, find_method("texture-space").limits.rounding)
              << stretch << " " << taps << " " << first << " " << gutter;
          const Image nothing = run(empty, profile, given);
          for (const float v : nothing.data()) ASSERT_EQ(v, 0.0F);
        }
      }
    }
  }
}

// The tube's side as an unrolled prism, with irradiance linear on its triangles: a wave around and along.
ShadingMesh lit_tube(const Mesh& mesh) {
  ShadingMesh shading = test::shade(mesh, test::lamp(Vec3d::UnitZ()));
  for (ShadingTriangle& triangle : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d& p = shading.corner(triangle, c);
      triangle.irradiance[c].setConstant(0.5 + 0.25 * std::cos(3.0 * std::atan2(p.x(), p.z())) +
                                         0.25 * std::cos(0.5 * p.y()));
    }
  }
  return shading;
}

// The largest difference of texture space, with dense taps and `texels` a side, from the geodesic truth, on
// the back of a tube: away from its seam, at the front, and its caps.
double tube_error(const Scene& scene, const Profile& profile, const std::vector<double>& truth,
                  const std::vector<std::pair<int, int>>& pixels, int texels) {
  const Image blurred =
      run(scene, profile, {{"taps", std::string("dense")}, {"texture_size", static_cast<double>(texels)}});
  double worst = 0.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto [x, y] = pixels[i];
    worst = std::max(worst, std::abs(static_cast<double>(blurred.at(x, y, 0)) - truth[i]));
  }
  return worst;
}

TEST(TextureSpace, EqualsTheTruthOnADevelopableChartToATexel) {
  const Mesh mesh = make_builtin("tube", {{"radius_mm", 10.0}, {"length_mm", 60.0}, {"edge_mm", 2.0}});
  Camera camera = test::camera_at(400.0, 30.0, 96);
  camera.eye_mm.z() = -400.0;  // the seam lies at the front
  const Scene scene(lit_tube(mesh), camera);
  constexpr double kStdDevMm = 1.5;
  constexpr double kTruth = 1e-5;
  Profile profile;
  profile.r_max_mm = 10.0;
  profile.terms = {{Vec3d::Constant(kStdDevMm * kStdDevMm), Vec3d::Ones()}};

  std::vector<GeodesicPiece> pieces;
  for (const ShadingTriangle& t : scene.shading().triangles)
    pieces.push_back({t.base, t.base_barycentric, t.irradiance, t.component});
  const GeodesicSurface surface(IntrinsicMesh(mesh.positions_mm, mesh.triangles), pieces);
  std::vector<std::pair<int, int>> pixels;
  std::vector<GeodesicTarget> targets;
  for (int y = 8; y < 96; y += 10) {
    for (int x = 20; x < 76; x += 5) {
      const PixelSurface& at = scene.images().surface_at(x, y);
      ASSERT_GE(at.triangle, 0);
      const ShadingTriangle& t = scene.shading().triangles[static_cast<std::size_t>(at.triangle)];
      Vec3d b = Vec3d::Zero();
      for (std::size_t c = 0; c < 3; ++c)
        b += at.barycentric[static_cast<Eigen::Index>(c)] * t.base_barycentric[c];
      pixels.emplace_back(x, y);
      targets.push_back({{t.base, b}, t.component});
    }
  }
  const std::vector<TruthLayer> layers = {{kStdDevMm}};
  const TruthValues values = GeodesicFastEngine(surface, kTruth).convolve(targets, layers);
  std::vector<double> truth;
  for (const Vec4d& v : values.front()) truth.push_back(v[0] / v[3]);

  // The bound. In the chart, at h mm a texel, the method is (1) I at texel centres; (2) a sum over them with
  // the discrete Gaussian; (3) linear interpolation at the pixel.
  //   (1) and (2): for a linear I both are exact. A wave exp(i k x) becomes exp(-(s/h)^2 (1 - cos kh)), which
  // is exp(-(ks)^2 / 2) but for (ks)^2 (kh)^2 / 24 exp(-(ks)^2 / 2), at most (kh)^2 / 24 2/e; the linear
  // pieces of I, edges of 2 mm, turn by up to 2 times its steepest slope L at their ends, and a kink seen at
  // texel centres only is off by L h / 4 within h of it, which the Gaussian dilutes: 2 kinks in 2 mm, so on
  // average an error of (h^2 / 8) times the kinks' turn per mm, |I''|. (3): h^2 / 8 |(G * I)''|.
  // Each along both axes, where |I''| is at most 0.25 (0.3^2 + 0.5^2) in sum: k is 0.3 and 0.5 per mm.
  //   h^2 0.25 (0.3^2 + 0.5^2) (1/24 2/e + 1/8 + 1/8), of which the first is at most 0.031.
  // The truth's share: 1e-5 of light and of mass. Floats: as the method's limit, 1e-5.
  const double scale = [&] {  // texels of the unit square per mm of the side
    const auto& uv = (*mesh.corner_uvs)[targets.front().point.face];
    const std::size_t t = targets.front().point.face;
    const Vec2d uv_edge = uv[1] - uv[0];
    return uv_edge.norm() / (mesh.corner(t, 1) - mesh.corner(t, 0)).norm();
  }();
  constexpr double kCurvature = 0.25 * (0.09 + 0.25);
  double last = 1.0;
  for (const int texels : {64, 128, 256, 512}) {
    const double h = 1.0 / (scale * texels);
    const double error = tube_error(scene, profile, truth, pixels, texels);
    EXPECT_LE(error, h * h * kCurvature * (0.031 + 0.25) + 2.0 * kTruth + 1e-5)
        << texels << " texels of " << h;
    EXPECT_LT(error, last);
    last = error;
  }
}

// A chart that ends at a straight edge inside the map, and on which irradiance rises with a slope g towards
// it, as the plane's does towards x = 30 mm when u covers half of the map.
TEST(TextureSpace, GuttersDoWhatTheManualSays) {
  Mesh plane = make_builtin("plane", {{"size_mm", kSizeMm}, {"edge_mm", 5.0}});
  for (auto& corners : *plane.corner_uvs) {
    for (Vec2d& uv : corners) uv = Vec2d(0.25, 0.25) + 0.5 * uv;
  }
  ShadingMesh shading = test::shade(plane, test::lamp(Vec3d::UnitZ()));
  for (ShadingTriangle& triangle : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c)
      triangle.irradiance[c].setConstant(0.5 + shading.corner(triangle, c).x() / kSizeMm);
  }
  const Camera camera = test::camera_at(1000.0, 64.0, 256);  // a quarter of a millimetre a pixel
  const Scene scene(std::move(shading), camera);
  constexpr int kLast = 247;  // the last pixel on the plane: its centre is at 29.875 mm
  ASSERT_GT(scene.images().mask.at(kLast, 128, 0), 0.0F);
  ASSERT_EQ(scene.images().mask.at(kLast + 1, 128, 0), 0.0F);
  Profile profile;
  profile.r_max_mm = 10.0;
  constexpr double kStdDevMm = 2.0;
  profile.terms = {{Vec3d::Constant(kStdDevMm * kStdDevMm), Vec3d::Ones()}};
  constexpr double kSlope = 1.0 / kSizeMm;
  const double light = scene.images().irradiance.at(kLast, 128, 0);
  const auto lost = [&](const char* gutter) {
    const Image blurred =
        run(scene, profile, {{"taps", std::string("dense")}, {"gutter", std::string(gutter)}});
    return light - static_cast<double>(blurred.at(kLast, 128, 0));
  };
  // At a distance d = 0.125 mm from the edge, with X normal: E[(X - d)+] g with the nearest texel, so
  // s phi(d/s) - d Q(d/s); with coverage -E[X | X < d] g = s phi(d/s) / Phi(d/s). Texels are 0.117 mm wide:
  // the chart's last centre lies half of that, at most one, inside, which moves d: 0.117 mm g/2, and the
  // reading's texel likewise.
  const double z = 0.125 / kStdDevMm;
  const double phi = std::exp(-0.5 * z * z) / std::sqrt(2.0 * kPi);
  const double below = 0.5 * std::erfc(-z / std::sqrt(2.0));
  const double texel = 0.117 * kSlope;
  EXPECT_NEAR(lost("nearest"), kSlope * (kStdDevMm * phi - 0.125 * (1.0 - below)), texel);
  EXPECT_NEAR(lost("coverage"), kSlope * kStdDevMm * phi / below, texel);
  // Black beyond: the share Q(d/s) of the light is missing, and what the slope does. A texel more or less of
  // black is phi(0) 0.117 / s of the light.
  EXPECT_NEAR(lost("none"), light * (1.0 - below) + kSlope * kStdDevMm * phi,
              texel + 1.5 * 0.399 * 0.117 / kStdDevMm);
}

// A level's map, read bilinearly at the pixel's place in it, row 0 at the top.
Vec3d read_bilinearly(const Image& map, const Vec2d& uv) {
  const Vec2d place(uv.x() * map.width() - 0.5, (1.0 - uv.y()) * map.height() - 0.5);
  const int x = static_cast<int>(std::floor(place.x()));
  const int y = static_cast<int>(std::floor(place.y()));
  const Vec2d f = place - Vec2d(x, y);
  return (1.0 - f.y()) * ((1.0 - f.x()) * map.rgb(x, y) + f.x() * map.rgb(x + 1, y)) +
         f.y() * ((1.0 - f.x()) * map.rgb(x, y + 1) + f.x() * map.rgb(x + 1, y + 1));
}

// Each level is named while it is there: the picture that the profile makes of one level alone is that
// level's map, read where the pixel lies. On a square of even stretch the stretch map stays what it is,
// however blurred.
TEST(TextureSpace, NamesEveryLevelAsItIs) {
  constexpr double kViewMm = 28.0;
  constexpr int kTexels = 256;
  const Scene scene = lit_by_a_kink(0, 1.0, kViewMm);
  const Profile profile = three_levels(0);
  const Method& method = find_method("texture-space");
  for (const bool blurs_stretch : {false, true}) {
    const Settings settings(method.name, method.settings,
                            {{"texture_size", static_cast<double>(kTexels)},
                             {"stretch", std::string(blurs_stretch ? "blurred" : "raw")}});
    const SurfaceBuffers buffers(Scene::context(), scene.shading());
    const PreparedMethod prepared =
        method.prepare({Scene::context(), scene.frame(), buffers, 1000.0, profile, settings});
    Passes passes(Scene::context());
    prepared.render(passes);
    const Image unrecorded = gpu::read_texture(Scene::context(), *prepared.output, 3);
    std::map<std::string, Image> named;
    passes.record([&] { prepared.render(passes); },
                  [&](const NamedTexture& texture) { named[texture.name] = texture.image; });
    const Image picture = gpu::read_texture(Scene::context(), *prepared.output, 3);
    for (std::size_t i = 0; i < picture.data().size(); ++i)
      ASSERT_EQ(picture.data()[i], unrecorded.data()[i]);
    ASSERT_EQ(named.size(), blurs_stretch ? 8U : 5U);
    for (const auto& [name, image] : named) {
      ASSERT_EQ(image.width(), kTexels) << name;
      if (!name.starts_with("stretch")) continue;
      // A texel is 60 / 256 mm on a square of 60 mm; positions are interpolated to 2^-23 of 30 mm, twice.
      for (const float value : image.data())
        ASSERT_NEAR(value, kTexels / kSizeMm, 2.0 * 30.0 * std::exp2(-22.0) * std::pow(kTexels / kSizeMm, 2))
            << name;
    }
    const double pixel_mm = kViewMm / picture.width();
    for (int x = 100; x < picture.width(); x += 7) {
      const int y = 301;
      const Vec2d uv(0.5 + ((x + 0.5) * pixel_mm - 0.5 * kViewMm) / kSizeMm,
                     0.5 + (0.5 * kViewMm - (y + 0.5) * pixel_mm) / kSizeMm);
      for (int c = 0; c < 3; ++c) {
        // The rasteriser takes the fraction of a texture coordinate to 8 bits, in steps of up to 1 / 128 from
        // texel to texel (60 mm / 256 over 30 mm), and the weights of 1e-12 do not show.
        const std::string level = fmt::format("level-{}", c + 1);
        ASSERT_NEAR(picture.at(x, y, c), read_bilinearly(named.at(level), uv)[c],
                    std::exp2(-8.0) * 2.0 * kSizeMm / kTexels / 30.0 + 1e-5)
            << level << " at " << x;
      }
    }
    // Blurred further from one to the next: the kink's value grows.
    const auto at_the_kink = [&](int level) {
      return named.at(fmt::format("level-{}", level)).at(128, 100, 0);
    };
    for (int level = 1; level <= 3; ++level) EXPECT_GT(at_the_kink(level), at_the_kink(level - 1));
  }
}

}  // namespace
}  // namespace truescatter
