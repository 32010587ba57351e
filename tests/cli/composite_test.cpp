#include <cmath>
#include <map>
#include <set>

#include "cli/cli_fixture.h"
#include "core/image_io.h"

namespace truescatter::test {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

// A sphere of 8 mm that does not fill its 40 x 40 pixels.
const std::string kLitBall = kBallScene + R"(width_px = 40
height_px = 40
[[profile]]
name = "spike-and-base"
[truth]
geodesic = "off"
[timing]
warm_up = 0
repeats = 1
[[method]]
name = "none"
[[method]]
name = "pscbf"
)";

// Narkowicz's curve, and clipping.
double tone(const std::string& curve, double x) {
  x = std::max(x, 0.0);
  return std::min(1.0, curve == "filmic" ? x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) : x);
}

class CliComposite : public Cli {
 protected:
  Image layer(const std::string& file, const std::string& name) const {
    return read_exr_layer(folder_.path() / "out/maps" / file, name);
  }
  Json visible_of(const std::string& label) const {
    const Json results = json("out/results.json");
    for (const Json& run : results.at("runs")) {
      if (run.at("label") == label) return run.at("metrics").at("visible");
    }
    throw std::runtime_error("no such run: " + label);
  }
};

// Single precision of the shader's ten operations, and of the exitance that the file holds.
TEST_F(CliComposite, WithoutSpecularLightShowsTheExitanceThroughTheToneCurve) {
  for (const std::string curve : {"linear", "filmic"}) {
    const ProgramResult result =
        run(kLitBall + "[composite]\nspecular = false\nexposure = 0.8\ntone = \"" + curve + "\"\n");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const double exposure = 0.8 / json("out/results.json")["scene"]["largest_irradiance"].get<double>();
    for (const std::string what : {"truth", "none", "pscbf"}) {
      const std::string file = "front.spike-and-base." + what + ".exr";
      const Image exitance = layer(file, "");
      const Image shown = layer(file, "composite");
      const Image mask = layer(file, "mask");
      int compared = 0;
      for (std::size_t i = 0; i < shown.data().size(); ++i) {
        if (mask.data()[i / 3] == 0.0F) {
          ASSERT_EQ(shown.data()[i], 0.0F);  // the background
        } else {
          ASSERT_NEAR(shown.data()[i], tone(curve, exposure * exitance.data()[i]), 1e-6) << what;
          ++compared;
        }
      }
      EXPECT_GT(compared, 1000);
    }
    EXPECT_TRUE(exists("out/maps/front.spike-and-base.pscbf.composite.png"));
    EXPECT_TRUE(exists("out/maps/front.spike-and-base.pscbf.visible.png"));
  }
}

TEST_F(CliComposite, AnAlbedoColoursWhatScatters) {
  ASSERT_EQ(run(kLitBall + "[composite]\nspecular = false\ntone = \"linear\"\nalbedo = [0.8, 0.5, 0.25]\n")
                .exit_code,
            0);
  const double exposure = 1.0 / json("out/results.json")["scene"]["largest_irradiance"].get<double>();
  const std::string file = "front.spike-and-base.truth.exr";
  const Image exitance = layer(file, "");
  const Image shown = layer(file, "composite");
  const Image mask = layer(file, "mask");
  constexpr std::array<double, 3> kAlbedo = {0.8, 0.5, 0.25};
  for (std::size_t i = 0; i < shown.data().size(); ++i) {
    if (mask.data()[i / 3] != 0.0F) {
      ASSERT_NEAR(shown.data()[i], kAlbedo[i % 3] * exposure * exitance.data()[i], 1e-6);
    }
  }
}

TEST_F(CliComposite, OfTheTruthAgainstItselfDiffersInNothing) {
  const std::string experiment = kLitBall + "[composite]\nregions = \"gloss.png\"\n";
  Image gloss(4, 4, 4, 0.5F);
  gloss.at(1, 1, 0) = 0.05F;
  write_png(folder_.path() / "gloss.png", gloss);
  ASSERT_EQ(run(experiment).exit_code, 0);
  fs::copy_file(folder_.path() / "out/maps/front.spike-and-base.truth.exr", folder_.path() / "truth.exr");
  const ProgramResult again = run(experiment + "[[method]]\nname = \"itself\"\nimage = \"truth.exr\"\n");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Json same = visible_of("itself");
  for (const char* key : {"mean", "p95", "above_005", "above_01"}) EXPECT_EQ(same.at(key), 0.0) << key;
  const Json none = visible_of("none");
  EXPECT_GT(none.at("mean"), visible_of("pscbf").at("mean"));
  EXPECT_GT(none.at("p95"), none.at("mean"));
  EXPECT_GE(none.at("above_005"), none.at("above_01"));
}

// It is no part of any convolution's error, nor of what is timed: all else of a run stays as it is without
// it.
TEST_F(CliComposite, ChangesNothingElse) {
  ASSERT_EQ(run(kLitBall).exit_code, 0);
  Json plain = json("out/results.json");
  const std::string png = text("out/maps/front.spike-and-base.pscbf.png");
  ASSERT_EQ(run(kLitBall + "[composite]\n").exit_code, 0);
  Json with = json("out/results.json");
  ASSERT_EQ(with.at("runs").size(), plain.at("runs").size());
  for (std::size_t i = 0; i < plain["runs"].size(); ++i) {
    Json& run = with["runs"][i];
    EXPECT_EQ(run["metrics"].erase("visible"), 1U);
    EXPECT_EQ(run["metrics"], plain["runs"][i]["metrics"]);
    EXPECT_EQ(run["own_target"], plain["runs"][i]["own_target"]);
    EXPECT_EQ(run["cost"]["passes"], plain["runs"][i]["cost"]["passes"]);
    EXPECT_EQ(run["cost"]["fetches_per_pixel"], plain["runs"][i]["cost"]["fetches_per_pixel"]);
  }
  const Image shown = layer("front.spike-and-base.none.exr", "composite");
  for (const float value : shown.data()) ASSERT_TRUE(value >= 0.0F && value <= 1.0F);
}

// A highlight under the lamp, and nothing where the lamp does not shine: specular light on and off.
TEST_F(CliComposite, SpecularLightIsWhereTheLampIsMirrored) {
  const std::string linear = kLitBall + "[composite]\ntone = \"linear\"\nexposure = 0.1\nroughness = 0.2\n";
  ASSERT_EQ(run(linear).exit_code, 0);
  const Image with = layer("front.spike-and-base.none.exr", "composite");
  ASSERT_EQ(run(linear + "specular = false\n").exit_code, 0);
  const Image without = layer("front.spike-and-base.none.exr", "composite");
  const Image irradiance = layer("front.spike-and-base.truth.exr", "irradiance");
  double most = 0.0;
  std::array<int, 2> at{};
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      const Vec3d highlight = with.rgb(x, y) - without.rgb(x, y);
      ASSERT_GE(highlight.minCoeff(), 0.0);
      if (irradiance.rgb(x, y).maxCoeff() == 0.0) {
        ASSERT_LT(highlight.maxCoeff(), 1e-3);
      }
      ASSERT_NEAR(highlight.x(), highlight.z(), 1e-6);  // oil has no colour
      if (highlight.x() > most) {
        most = highlight.x();
        at = {x, y};
      }
    }
  }
  // From (0.8, 0.4, 0.5) and seen from +z, the mirror's normal is that of L + V: (0.46, 0.23, 0.86) of 8 mm,
  // at 2.08 px a mm (40 px are 2 * 100 tan 5.5 degrees = 19.3 mm at the target, a little less at the ball's
  // front).
  const Vec3d mirror = (Vec3d(0.8, 0.4, 0.5).normalized() + Vec3d::UnitZ()).normalized();
  EXPECT_NEAR(at[0], 19.5 + 8.0 * 2.2 * mirror.x(), 2.5);
  EXPECT_NEAR(at[1], 19.5 - 8.0 * 2.2 * mirror.y(), 2.5);
}

TEST_F(CliComposite, OfEveryKindOfLightIsFinite) {
  const std::string lights =
      "[[light]]\ntype = \"point\"\nposition_mm = [30.0, 30.0, 40.0]\n[[light]]\ntype = \"environment\"\nmap "
      "= "
      "\"builtin:sunset\"\nocclusion_rays = 64\n[[light]]\ntype = \"environment\"\nmap = "
      "\"builtin:uniform\"\nocclusion "
      "= false\n";
  const ProgramResult result = run(kLitBall + lights + "[composite]\nbeckmann = \"power\"\n");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(visible_of("pscbf").at("mean"), 0.1);
}

// Looking straight on, the ball's middle is a plane across the view: d' is the ball's bound 2 r_max over mm
// per pixel, and K, mm per pixel, mm per pixel.
TEST_F(CliComposite, BuffersAreAllThatAPictureIsMadeOf) {
  const std::string odd =
      with(with(kLitBall, "width_px = 40", "width_px = 41"), "height_px = 40", "height_px = 41");
  const std::string sky =
      "[[light]]\ntype = \"environment\"\nmap = \"builtin:uniform\"\nocclusion_rays = 64\n";
  const ProgramResult result = run(odd + sky + "[composite]\n", {"--buffers"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  std::vector<std::string> names;
  for (const Json& buffer : results["views"][0]["files"]["buffers"]) {
    names.push_back(buffer["name"]);
    EXPECT_TRUE(exists("out/" + buffer["exr"].get<std::string>())) << names.back();
    EXPECT_TRUE(exists("out/" + buffer["png"].get<std::string>())) << names.back();
  }
  EXPECT_EQ(names, (std::vector<std::string>{"irradiance", "depth", "face-normal", "normal", "light-1",
                                             "occlusion-2", "gloss", "specular", "albedo"}));
  const fs::path passes = folder_.path() / "out/passes";
  // The picture is what its buffers say.
  const double exposure = 1.0 / results["scene"]["largest_irradiance"].get<double>();
  const Image specular = read_exr_layer(passes / "front.view.specular.exr", "");
  const Image exitance = layer("front.spike-and-base.pscbf.exr", "");
  const Image shown = layer("front.spike-and-base.pscbf.exr", "composite");
  for (std::size_t i = 0; i < shown.data().size(); ++i)
    ASSERT_NEAR(shown.data()[i], tone("filmic", exposure * (exitance.data()[i] + specular.data()[i])), 2e-6);
  // A convex body hides nothing of the sky from itself: 64 rays, of which a facet's edge may stop one or two.
  const Image occlusion = read_exr_layer(passes / "front.view.occlusion-2.exr", "r");
  EXPECT_GT(occlusion.at(20, 20, 0), 0.95F);
  const double mm_per_px = (100.0 - 8.0) * 2.0 * std::tan(5.5 * kPi / 180.0) / 41.0;
  const double r_max_mm = results["profiles"][0]["r_max_mm"];
  for (const char* axis : {"x", "y"}) {
    EXPECT_NEAR(read_exr_layer(passes / "front.spike-and-base.pscbf.extent.exr", axis).at(20, 20, 0),
                2.0 * r_max_mm / mm_per_px, 0.02 * 2.0 * r_max_mm / mm_per_px);
    EXPECT_NEAR(read_exr_layer(passes / "front.spike-and-base.pscbf.scale.exr", axis).at(20, 20, 0),
                mm_per_px, 0.02 * mm_per_px);
  }
}

// What every pixel of a view's buffer has, by its channels' names.
class CliBuffers : public CliComposite {
 protected:
  Image buffer(const std::string& view, const std::string& name, const std::string& channel) const {
    return read_exr_layer(folder_.path() / "out/passes" / (view + ".view." + name + ".exr"), channel);
  }
};

// The square fills the frame, and u runs along x: red is below a tenth on its left half. Values of eight
// bits; where texels meet, between the two.
TEST_F(CliBuffers, GlossOfAMapIsAsTheWalkthroughHasIt) {
  Image map(64, 64, 4);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      map.at(x, y, 0) = x < 32 ? 0.09F : 0.5F;
      map.at(x, y, 3) = 0.25F;
    }
  }
  write_png(folder_.path() / "gloss.png", map);
  ASSERT_EQ(run(kTiny + "[composite]\nregions = \"gloss.png\"\n", {"--buffers"}).exit_code, 0);
  const Image intensity = buffer("front", "gloss", "i");
  const Image roughness = buffer("front", "gloss", "m");
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 48; ++x) {
      if (x < 22) {
        EXPECT_EQ(intensity.at(x, y, 0), 0.0F);
      }
      if (x > 25) {
        EXPECT_NEAR(intensity.at(x, y, 0), 0.16 * 128.0 / 255.0 + 0.18, 1e-6);
      }
      EXPECT_NEAR(roughness.at(x, y, 0), 0.09 * 64.0 / 255.0 + 0.23, 1e-6);
    }
  }
}

// A convex body hides nothing of the sky from itself, whatever relief its normal map pretends: the map tilts
// the lobe. Of 256 rays a facet's edge may stop a few.
TEST_F(CliBuffers, ANormalMapTakesNothingOfAnEnvironmentAway) {
  Image map(32, 32, 3);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x)
      map.set_rgb(x, y, 0.5 * (Vec3d(x % 8 < 4 ? 0.6 : -0.6, 0.0, 0.8) + Vec3d::Ones()));
  }
  write_exr(folder_.path() / "map.exr", {{"", &map}});
  const std::string sky =
      "[[light]]\ntype = \"environment\"\nmap = \"builtin:sunset\"\nocclusion_rays = 256\n";
  const std::string ball = with(with(kLitBall, "[[light]]\ndirection = [0.8, 0.4, 0.5]\n", sky),
                                "[scene.parameters]", "normal_map = \"map.exr\"\n[scene.parameters]");
  const ProgramResult result =
      run(ball + "[composite]\n[shading]\nnormal_map_edge_mm = 2.0\n", {"--buffers"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Image seen = buffer("front", "gloss", "i");
  double tilted = 0.0;
  for (const char* channel : {"r", "g", "b"}) {
    const Image share = buffer("front", "occlusion-1", channel);
    for (std::size_t i = 0; i < share.data().size(); ++i) {
      if (seen.data()[i] > 0.0F) {
        ASSERT_GT(share.data()[i], 0.9F);
      }
    }
  }
  const Image mapped = buffer("front", "mapped-normal", "x");
  const Image smooth = buffer("front", "normal", "x");
  for (std::size_t i = 0; i < mapped.data().size(); ++i)
    tilted = std::max(tilted, std::abs(double(mapped.data()[i]) - smooth.data()[i]));
  EXPECT_GT(tilted, 0.4);
}

// What the mask leaves out shows its irradiance, and reflects nothing.
TEST_F(CliBuffers, WhatIsNotSkinShowsItsIrradiance) {
  Image mask(16, 16, 1, 1.0F);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 8; ++x) mask.at(x, y, 0) = 0.0F;
  }
  write_png(folder_.path() / "skin.png", mask);
  const std::string masked =
      with(kTiny, "[scene.parameters]", "skin_mask = \"skin.png\"\n[scene.parameters]");
  const ProgramResult result = run(
      masked + "[composite]\ntone = \"linear\"\nexposure = 0.9\nalbedo = [0.5, 0.5, 0.5]\n", {"--buffers"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string file = "front.spike-and-base.none.exr";
  const Image skin = layer(file, "mask");
  const Image shown = layer(file, "composite");
  const Image irradiance = layer("front.spike-and-base.truth.exr", "irradiance");
  const Image specular = read_exr_layer(folder_.path() / "out/passes/front.view.specular.exr", "");
  const double exposure = 0.9 / json("out/results.json")["scene"]["largest_irradiance"].get<double>();
  std::array<int, 2> count{};
  for (std::size_t i = 0; i < shown.data().size(); ++i) {
    const bool is_skin = skin.data()[i / 3] != 0.0F;
    ++count[is_skin ? 1 : 0];
    const double scattered = (is_skin ? 0.5 : 1.0) * irradiance.data()[i];  // "none" scatters nothing
    ASSERT_NEAR(shown.data()[i], std::min(1.0, exposure * (scattered + specular.data()[i])), 2e-6);
    if (!is_skin) {
      ASSERT_EQ(specular.data()[i], 0.0F);
    }
  }
  EXPECT_GT(count[0], 2000);
  EXPECT_GT(count[1], 2000);
}

// An albedo of a half: before the scattering it is in the irradiance and after it in the picture, so that on
// one irradiance all three show the same.
TEST_F(CliBuffers, AnAlbedoComesInWhereverItIsApplied) {
  const Image half(4, 4, 3, 0.5F);
  write_exr(folder_.path() / "half.exr", {{"", &half}});
  for (const auto& [where, after] :
       std::map<std::string, double>{{"before", 0.0}, {"mix", 0.5}, {"after", 1.0}}) {
    const std::string textured =
        with(kTiny, "[scene.parameters]",
             "albedo = \"half.exr\"\ntexturing = \"" + where + "\"\n[scene.parameters]");
    const std::string coarse =
        textured + "[shading]\nfloor_mm = 2.0\n" + (after < 1.0 ? "albedo_edge_mm = 2.0\n" : "");
    const ProgramResult result =
        run(coarse + "[composite]\nspecular = false\ntone = \"linear\"\n", {"--buffers"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const double exposure = 1.0 / json("out/results.json")["scene"]["largest_irradiance"].get<double>();
    const Image exitance = layer("front.spike-and-base.truth.exr", "");
    const Image shown = layer("front.spike-and-base.truth.exr", "composite");
    EXPECT_NEAR(buffer("front", "albedo", "g").at(20, 20, 0), std::pow(0.5, after), 1e-6) << where;
    EXPECT_NEAR(shown.at(20, 20, 1), exposure * exitance.at(20, 20, 1) * std::pow(0.5, after), 1e-6) << where;
    EXPECT_FALSE(exists("out/passes/front.view.gloss.exr"));
  }
}

// Seen from behind, through the irradiance of its front, the square has no highlight.
TEST_F(CliBuffers, TheInsideOfAnOpenSurfaceDoesNotShine) {
  const std::string behind = with(kTiny, "eye_mm = [0.0, 0.0, 100.0]", "eye_mm = [0.0, 0.0, -100.0]");
  ASSERT_EQ(run(behind + "[composite]\n", {"--buffers"}).exit_code, 0);
  const Image specular = read_exr_layer(folder_.path() / "out/passes/front.view.specular.exr", "");
  for (const float value : specular.data()) ASSERT_EQ(value, 0.0F);
}

// The head has its gloss where it is its nose, cheek and neck, and so has its copy beside it.
TEST_F(CliBuffers, BuiltInRegionsGoWithEachCharacter) {
  const auto view = [](const std::string& name, const std::string& x_mm) {
    return "[[view]]\nname = \"" + name + "\"\neye_mm = [" + x_mm + ", -10.0, 600.0]\ntarget_mm = [" + x_mm +
           ", -10.0, 0.0]\nfov_deg = 20.0\nwidth_px = 64\nheight_px = 64\n";
  };
  const std::string heads = R"(
[scene]
mesh = "builtin:head"
parameters.edge_mm = 6.0
[[scene.character]]
position_mm = [0.0, 0.0, 0.0]
[[scene.character]]
position_mm = [400.0, 0.0, 0.0]
[[light]]
direction = [0.3, 0.4, 0.8]
)" + view("one", "0.0") + view("other", "400.0") +
                            R"(
[[profile]]
name = "spike-and-base"
[truth]
geodesic = "off"
[shading]
floor_mm = 4.0
[timing]
warm_up = 0
repeats = 1
[[method]]
name = "none"
[[method]]
name = "blur2d"
[composite]
regions = "builtin:head"
)";
  const ProgramResult result = run(heads, {"--buffers"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Image intensity = buffer("one", "gloss", "i");
  const Image other = buffer("other", "gloss", "i");
  const Image roughness = buffer("one", "gloss", "m");
  std::set<double> values;
  // A corner is drawn at a 256th of a pixel, 0.013 mm here, in each view; where the surface lies 60 degrees
  // aslant, two views see points 0.05 mm apart. From region to region, over 6 mm, the intensity changes by at
  // most 0.16, and 1.5 times as steeply in the middle: 2e-3.
  for (std::size_t i = 0; i < intensity.data().size(); ++i) {
    if (intensity.data()[i] == 0.0F) continue;
    EXPECT_NEAR(intensity.data()[i], other.data()[i], 2e-3);
    EXPECT_GE(intensity.data()[i], 0.18F);
    EXPECT_LE(intensity.data()[i], 0.34F);
    EXPECT_GE(roughness.data()[i], 0.23F);
    EXPECT_LE(roughness.data()[i], 0.32F);
    values.insert(std::round(100.0 * intensity.data()[i]));
  }
  EXPECT_GE(values.size(), 8U);
  // 600 mm away a pixel is 3.3 mm: the nose's ridge is above the middle's lips.
  float most = 0.0F;
  for (int y = 20; y < 36; ++y) most = std::max(most, intensity.at(32, y, 0));
  EXPECT_NEAR(most, 0.34F, 1e-3F);
}

TEST_F(CliComposite, AThresholdHoldsWhatIsSeen) {
  const std::string judged =
      kLitBall + "[composite]\n[[threshold]]\nmethod = \"none\"\nmetric = \"visible_p95\"\n";
  const ProgramResult exceeded = run(judged + "maximum = 0.0001\n");
  EXPECT_EQ(exceeded.exit_code, 1);
  EXPECT_TRUE(contains(exceeded.err + exceeded.out, "visible_p95 of none in view front")) << exceeded.err;
  EXPECT_EQ(run(judged + "maximum = 1.0\n").exit_code, 0);
}

TEST_F(CliComposite, CompareNamesWhatIsSeenAnew) {
  ASSERT_EQ(run(kLitBall + "[composite]\n").exit_code, 0);
  fs::rename(folder_.path() / "out", folder_.path() / "before");
  ASSERT_EQ(run(kLitBall + "[composite]\nexposure = 0.25\n").exit_code, 0);
  const ProgramResult compared = truescatter({"compare", "before", "out"});
  EXPECT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_TRUE(contains(compared.out, "  visible_p95 ")) << compared.out;
  EXPECT_FALSE(contains(compared.out, "  rmse ")) << compared.out;
}

TEST_F(CliComposite, ASweepHasWhatIsSeenAtEachValue) {
  const std::string swept =
      "[composite]\n[sweep]\nkey = \"scene.parameters.radius_mm\"\nvalues = [8.0, 6.0]\n";
  ASSERT_EQ(run(kLitBall + swept).exit_code, 0);
  const Json results = json("out/results.json");
  for (const Json& curve : results.at("sweep").at("curves")) {
    for (const Json& point : curve.at("points")) {
      EXPECT_GT(point.at("visible_mean").get<double>(), 0.0);
      EXPECT_GE(point.at("visible_p95"), point.at("visible_mean"));
    }
  }
}

class CliCompositeErrors : public CliErrors {};

TEST_F(CliCompositeErrors, NameTheKey) {
  Image rgb(4, 4, 3, 0.5F);
  write_png(folder_.path() / "rgb.png", rgb);
  const Image bright(4, 4, 4, 1.5F);
  write_exr(folder_.path() / "bright.exr", {{"", &bright}});
  const std::vector<std::pair<std::string, std::string>> table = {
      {"tone = \"aces\"", "'composite.tone'"},
      {"roughness = 0.05", "'composite.roughness'"},
      {"intensity = -1", "'composite.intensity'"},
      {"albedo = [1, 1, -1]", "'composite.albedo' must not be negative"},
      {"beckmann = \"linear\"", "'composite.beckmann'"},
      {"pixels_per_degree = 0", "'composite.pixels_per_degree'"},
      {"colour = 1", "colour"},
      {"regions = \"rgb.png\"\nroughness = 0.3", "'composite.roughness' is for skin without regions"},
      {"regions = \"bright.exr\"",
       "'composite.regions' must be from 0 to 1, but bright.exr holds a value beyond"},
      {"[sweep]\nkey = \"composite.exposure\"\nvalues = [1.0, 2.0]", "a sweep's pictures are composed alike"},
      {"regions = \"rgb.png\"",
       "'composite.regions' needs intensity in red and roughness in alpha, but rgb.png has 3"},
      {"regions = \"none.png\"", "none.png"},
      {"regions = \"builtin:head\"", "there are built-in regions of \"builtin:head\" alone"}};
  for (const auto& [key, message] : table)
    expect_refused(run(kLitBall + "[composite]\n" + key + "\n"), {"e.toml:", message});
  expect_refused(
      run(kLitBall + "[[threshold]]\nmethod = \"none\"\nmetric = \"visible_mean\"\nmaximum = 1.0\n"),
      {"e.toml:", "'threshold.metric' is \"visible_mean\", which there is with [composite] alone"});
}

}  // namespace
}  // namespace truescatter::test
