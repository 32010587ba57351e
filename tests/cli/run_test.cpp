#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/cli_fixture.h"
#include "core/image_io.h"
#include "core/vec.h"
#include "metrics/color_map.h"

namespace truescatter::test {
namespace {

using Json = nlohmann::json;

class CliRun : public Cli {};

void expect_keys(const Json& object, const std::vector<std::string>& keys, const std::string& what) {
  for (const std::string& key : keys) EXPECT_TRUE(object.contains(key)) << what << " lacks " << key;
}

// A map that leans by 30 degrees along v against a lamp at atan 0.5 = 26.57 degrees: cos(3.43) everywhere, so
// scattering changes nothing. The skin in view is refined to the edge that is asked for.
TEST_F(CliRun, ANormalMapEntersThroughTheIrradiance) {
  Image map(4, 4, 3);
  for (int i = 0; i < 16; ++i) map.set_rgb(i % 4, i / 4, {0.5, 0.75, 0.5 + 0.25 * std::sqrt(3.0)});
  write_exr(folder_.path() / "map.exr", {{"", &map}});
  const std::string mapped =
      with(with(kTiny, "[scene.parameters]", "normal_map = \"map.exr\"\n[scene.parameters]"), "[[view]]",
           "[shading]\nnormal_map_edge_mm = 1.0\n[[view]]");
  const ProgramResult result = run(mapped);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  const Json& scene = results.at("scene");
  EXPECT_NEAR(scene.at("largest_irradiance").get<double>(), std::cos(kPi / 6.0 - std::atan(0.5)), 1e-6);
  EXPECT_LT(scene.at("irradiance_residual").at("p99").get<double>(), 1e-6);
  EXPECT_EQ(scene.at("normal_map").at("edge_mm"), 1.0);
  // 17.5 x 17.5 mm are seen; a triangle with edges of 1 mm has sqrt(3) / 4 mm^2 at most.
  EXPECT_GT(scene.at("shading_triangles").get<double>(), 17.5 * 17.5 / (std::sqrt(3.0) / 4.0));
  EXPECT_LT(results.at("runs").at(0).at("metrics").at("max").get<double>(), 1e-4);
  const std::string resolved = text("out/experiment.resolved.toml");
  EXPECT_TRUE(contains(resolved, "map.exr\"\nnormal_map_strength = 1\nnormal_map_green = \"up\"\n"))
      << resolved;
  EXPECT_TRUE(contains(resolved, "normal_map_edge_mm = 1\n")) << resolved;
}

// A map that is 1 / pi everywhere gives a square that sees half of it the irradiance 1, with occlusion or
// without; 1 but for the projection's midpoint rule over pixels of 1/32 of a half turn.
TEST_F(CliRun, AnEnvironmentGivesIrradiance) {
  const Image map(64, 32, 3, static_cast<float>(1.0 / kPi));
  write_exr(folder_.path() / "sky.exr", {{"", &map}});
  for (const std::string extra : {"", "occlusion = false\n"}) {
    const ProgramResult result =
        run(with(kTiny, "direction = [0.0, 0.5, 1.0]",
                 "type = \"environment\"\nmap = \"sky.exr\"\ncolor = [0.5, 1.0, 0.25]\n" + extra));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Json results = json("out/results.json");
    EXPECT_NEAR(results.at("scene").at("largest_irradiance").get<double>(), 1.0, 5e-3);
    EXPECT_LT(results.at("scene").at("irradiance_residual").at("p99").get<double>(), 1e-9);
    EXPECT_LT(results.at("runs").at(0).at("metrics").at("max").get<double>(), 2e-4);
    const std::string resolved = text("out/experiment.resolved.toml");
    EXPECT_TRUE(contains(resolved, "sky.exr\"\nrotation_deg = 0\nocclusion = ")) << resolved;
  }
}

TEST_F(CliRun, TellsTheMemoryThatItTook) {
  const ProgramResult dry = run(kTiny, {"--dry-run", "--memory-limit", "2"});
  ASSERT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_TRUE(contains(dry.out, "memory view front: about ")) << dry.out;
  ASSERT_EQ(run(kTiny, {"--memory-limit", "2"}).exit_code, 0);
  const Json results = json("out/results.json");
  const Json& memory = results.at("provenance").at("memory");
  EXPECT_EQ(memory.at("limit_bytes"), std::uint64_t{1} << 31U);
  EXPECT_GT(memory.at("peak_bytes"), 0);
  EXPECT_GT(results.at("views").at(0).at("memory_estimate_bytes"), 0);
}

// Three squares in a row, two of them in view: each is a surface of its own, whose light is even, so that
// nothing but a leak from one to the other, or to where there is none, could make an error.
TEST_F(CliRun, ASceneHoldsSeveralCharacters) {
  const std::string crowd =
      with(with(kTiny, "[[light]]",
                "[[scene.character]]\nposition_mm = [-6, 0, 0]\n"
                "[[scene.character]]\nposition_mm = [14.5, 0, -1]\n"
                "[[scene.character]]\nposition_mm = [300, 0, 0]\nrotation_deg = 90\n[[light]]"),
           "[timing]", "[[method]]\nname = \"texture-space\"\n[timing]");
  const ProgramResult dry = run(crowd, {"--dry-run"});
  ASSERT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_TRUE(contains(dry.out, "characters 3\n")) << dry.out;
  const ProgramResult result = run(crowd);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  EXPECT_EQ(results.at("scene").at("characters"), 3);
  EXPECT_EQ(results.at("scene").at("skin_components"), 3);
  EXPECT_EQ(results.at("scene").at("triangles").get<int>() % 3, 0);
  const Json& run = results.at("runs").back();
  EXPECT_EQ(run.at("method"), "texture-space");
  // One Gaussian of three variances: 13 passes for each of the two characters in view, after the first.
  EXPECT_EQ(run.at("cost").at("passes"), 1 + 2 * 13);
  EXPECT_LT(run.at("metrics").at("max").get<double>(), 2e-4);
  EXPECT_LT(run.at("own_target").at("metrics").at("max").get<double>(), 2e-4);
}

// Left half red of 188 of 255, about 0.5 in linear light, right half white: it shows in the pictures of the
// results, and in nothing else.
TEST_F(CliRun, AnAlbedoShowsInPicturesOnly) {
  Image albedo(64, 64, 3, 1.0F);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 32; ++x) albedo.set_rgb(x, y, Vec3d(188.0, 0.0, 0.0) / 255.0);
  }
  write_png(folder_.path() / "a.png", albedo);
  ASSERT_EQ(run(kTiny).exit_code, 0);
  const Json white = json("out/results.json");
  const Image white_light = read_exr_layer(folder_.path() / "out/maps/front.spike-and-base.pscbf.exr", "");
  const Image white_irradiance = read_image(folder_.path() / "out/maps/front.irradiance.png");
  const ProgramResult result =
      run(with(kTiny, "[scene.parameters]", "albedo = \"a.png\"\n[scene.parameters]"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json coloured = json("out/results.json");
  EXPECT_EQ(coloured.at("scene").at("albedo"), "a.png");
  for (std::size_t i = 0; i < white.at("runs").size(); ++i) {
    EXPECT_EQ(coloured.at("runs").at(i).at("metrics"), white.at("runs").at(i).at("metrics"));
  }
  const Image light = read_exr_layer(folder_.path() / "out/maps/front.spike-and-base.pscbf.exr", "");
  EXPECT_TRUE(std::equal(light.data().begin(), light.data().end(), white_light.data().begin()));
  const Image irradiance = read_image(folder_.path() / "out/maps/front.irradiance.png");
  EXPECT_TRUE(std::ranges::equal(irradiance.data(), white_irradiance.data()));
  for (const char* name : {"truth", "none", "pscbf"}) {
    const Image picture =
        read_image(folder_.path() / ("out/maps/front.spike-and-base." + std::string(name) + ".png"));
    // The square is evenly lit and exposed to white, so its picture is the albedo's own code, up to one step
    // of rounding; u runs to the right.
    EXPECT_NEAR(picture.at(10, 24, 0), 188.0 / 255.0, 1.01 / 255.0) << name;
    EXPECT_EQ(picture.at(10, 24, 1), 0.0F) << name;
    EXPECT_NEAR(picture.at(38, 24, 1), 1.0, 1.01 / 255.0) << name;
  }
}

// Half red of 188 of 255, about 0.5 in linear light, as above. Where the albedo comes before the scattering
// the truth blurs its edge; where it comes after, nothing does. Away from the edge the picture is the same.
TEST_F(CliRun, TexturingBeforeAfterAndSplit) {
  Image albedo(128, 128, 3, 1.0F);
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 64; ++x) albedo.set_rgb(x, y, Vec3d(188.0, 0.0, 0.0) / 255.0);
  }
  write_png(folder_.path() / "a.png", albedo);
  const double half = srgb_decode(188.0 / 255.0);
  const std::map<std::string, double> exponents = {{"after", 0.0}, {"mix", 0.5}, {"before", 1.0}};
  for (const auto& [where, before] : exponents) {
    const ProgramResult result =
        run(with(with(with(kTiny, "size_mm = 20.0", "size_mm = 40.0"), "[scene.parameters]",
                      "albedo = \"a.png\"\ntexturing = \"" + where + "\"\n[scene.parameters]"),
                 "[[view]]", "[shading]\nfloor_mm = 0.5\n[[view]]"));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Json results = json("out/results.json");
    const Json& texturing = results.at("scene").at("texturing");
    EXPECT_EQ(texturing.at("where"), where);
    EXPECT_EQ(texturing.at("exponent_before"), before);
    EXPECT_EQ(texturing.contains("edge_mm"), before > 0.0);
    // The square has one irradiance, E; what scatters is E a^m. Pixels are 17.5 / 48 = 0.365 mm wide, the
    // edge lies between 23 and 24, red is blurred by s = sqrt(2.3) = 1.517 mm but for the spike, 0.15. Pixel
    // 1 is 5.4 s away from the edge, and farther from the square's border, where a texture begins again:
    // nothing of either is seen there. Truths are good to 1e-4.
    const Image truth = read_exr_layer(folder_.path() / "out/maps/front.spike-and-base.truth.exr", "");
    const Image light = read_exr_layer(folder_.path() / "out/maps/front.spike-and-base.none.exr", "");
    const double right = light.at(46, 24, 0);
    EXPECT_NEAR(light.at(1, 24, 0), right * std::pow(half, before), 1e-5 * right);
    EXPECT_NEAR(truth.at(1, 24, 0), right * std::pow(half, before), 2e-4 * right);
    // From pixel 23 to 24 the truth rises by (0.15 + 0.85 erf(0.182 / s sqrt 2)) = 0.231 of the step if that
    // is sharp, and less if not. It is a ramp of a texel, 0.31 mm, interpolated over edges of 0.5 mm: within
    // 0.66 mm of the middle. Its blur's slope is that of a Gaussian at most 0.84 mm off: 0.226 per mm,
    // and 0.85 * 0.365 * 0.226 = 0.070.
    const double step = 1.0 - std::pow(half, before);
    const double across = static_cast<double>(truth.at(24, 24, 0) - truth.at(23, 24, 0)) / right;
    EXPECT_LE(across, 0.231 * step + 2e-4) << where;
    EXPECT_GE(across, 0.07 * step - 2e-4) << where;
    // All of the albedo is in what is shown, wherever it came in.
    const Image picture = read_image(folder_.path() / "out/maps/front.spike-and-base.truth.png");
    EXPECT_NEAR(picture.at(1, 24, 0), 188.0 / 255.0, 1.5 / 255.0) << where;
    EXPECT_NEAR(picture.at(46, 24, 0), 1.0, 1.5 / 255.0) << where;
    // Errors with the rest of it are no larger, for it is at most 1; with nothing left they are the same.
    for (const Json& run : results.at("runs")) {
      const double plain = run.at("metrics").at("channels").at("r").at("rmse").get<double>();
      const double textured =
          run.at("textured").at("metrics").at("channels").at("r").at("rmse").get<double>();
      EXPECT_LE(textured, plain);
      if (before == 1.0) {
        EXPECT_EQ(textured, plain);
      }
    }
    // Pixel 21, 0.91 mm from the edge and off the ramp, lacks 0.85 Phi(-0.91 / s) = 0.233 of the step without
    // scattering; the ramp's spread, a variance of 0.66^2 / 3 on 2.3 at most, adds to it if anything.
    const double none = results.at("runs").at(0).at("metrics").at("channels").at("r").at("max").get<double>();
    if (before == 0.0) {
      EXPECT_LT(none, 2e-4);
    } else {
      EXPECT_GT(none, 0.23 * step * right);
    }
  }
}

// A profile that multiplies light multiplies the error of its Gaussians too.
TEST_F(CliRun, WeightsAboveOneMultiplyTheUncertainty) {
  const ProgramResult result =
      run(with(kTiny, "\"spike-and-base\"",
               "\"bright\"\n[[profile.gaussian]]\nvariance_mm2 = 1\nweight = [-3, 2, 1]"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json truth = json("out/results.json").at("truths").at(0);
  const Json& certificate = truth.at("certificate");
  const double of_a_layer =
      certificate.at("max_error").get<double>() + certificate.at("tail_bound").get<double>();
  EXPECT_GT(of_a_layer, 0.0);
  EXPECT_DOUBLE_EQ(truth.at("uncertainty").get<double>(), 3.0 * of_a_layer);
}

// The contract of README, Commands.
TEST_F(CliRun, WritesEveryFileWithTheDocumentedKeys) {
  const ProgramResult result = run(kTiny);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.out, "report.html"));
  for (const char* name :
       {"out/report.html", "out/results.json", "out/results.csv", "out/experiment.resolved.toml"}) {
    EXPECT_TRUE(exists(name)) << name;
  }
  // A bare NaN or Infinity is no JSON, so parsing would fail; quoted ones must not be there either.
  const std::string text_of_json = text("out/results.json");
  EXPECT_FALSE(contains(text_of_json, "\"nan\""));
  EXPECT_FALSE(contains(text_of_json, "\"NaN\""));
  const Json results = Json::parse(text_of_json);
  expect_keys(results, {"schema", "provenance", "truths", "runs"}, "results");
  expect_keys(results.at("provenance"), {"version", "commit", "compiler", "gl_renderer", "machine"},
              "provenance");
  ASSERT_FALSE(results.at("truths").empty());
  for (const Json& truth : results.at("truths")) {
    expect_keys(truth, {"metric", "normalised", "seconds", "points", "uncertainty", "certificate"}, "truth");
    expect_keys(truth.at("certificate"), {"audited", "max_error", "tolerance"}, "certificate");
    EXPECT_GE(truth.at("certificate").at("audited"), 256);
    EXPECT_LE(truth.at("certificate").at("max_error"), truth.at("certificate").at("tolerance"));
    EXPECT_EQ(truth.at("points"), 48 * 48);  // the square is 20 mm, the frame 17.5 mm: all is skin
  }
  ASSERT_EQ(results.at("runs").size(), 2U);
  const std::vector<std::string> errors = {"bias", "mae", "rmse", "rel_rmse", "p50", "p95", "p99", "max"};
  for (const Json& run : results.at("runs")) {
    expect_keys(run, {"scene", "view", "method", "settings", "truth", "metrics", "own_target", "cost"},
                "run");
    expect_keys(run.at("cost"), {"frame_ms", "setup_ms", "passes", "fetches_per_pixel", "bytes_per_pixel"},
                "cost");
    expect_keys(run.at("cost").at("frame_ms"), {"median", "min", "max", "repeats"}, "frame_ms");
    expect_keys(run.at("own_target"), {"truth", "metrics"}, "own_target");
    expect_keys(run.at("metrics"), errors, "metrics");
    expect_keys(run.at("metrics"), {"flip", "halo", "channels"}, "metrics");
    for (const char* channel : {"r", "g", "b"}) {
      expect_keys(run.at("metrics").at("channels").at(channel), errors, channel);
      expect_keys(run.at("metrics").at("channels").at(channel), {"halo"}, channel);
    }
    const Json& halo = run.at("metrics").at("halo");
    expect_keys(halo, {"peak", "width_mm", "energy", "contrast", "outer", "inner"}, "halo");
    expect_keys(halo.at("outer"), {"near"}, "halo.outer");
    expect_keys(halo.at("inner"), {"near", "far"}, "halo.inner");
    // The square fills the frame: there is no silhouette, and the reason is said.
    EXPECT_TRUE(halo.at("peak").is_null());
    EXPECT_TRUE(halo.at("peak_reason").is_string());
    for (const auto& [what, file] : run.at("files").items()) {
      EXPECT_TRUE(exists("out/" + file.get<std::string>())) << what << " " << file;
    }
  }
  for (const Json& truth : results.at("truths")) {
    if (!truth.contains("files")) continue;
    for (const auto& [what, file] : truth.at("files").items())
      EXPECT_TRUE(exists("out/" + file.get<std::string>())) << what;
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path() / "out")) {
    EXPECT_FALSE(contains(entry.path().filename().string(), ".part")) << entry.path();
  }
}

// The page cuts the colour bar out of an error map: it lies where results.json says. 8-bit files round by
// half a step, 1/510.
TEST_F(CliRun, TheMapsColourBarsLieWhereTheResultsSay) {
  ASSERT_EQ(run(kTiny).exit_code, 0);
  const Json results = json("out/results.json");
  const Json& bar = results.at("views").at(0).at("color_bar");
  const Image map = read_image(folder_.path() / "out" /
                               results.at("runs").at(0).at("files").at("magnitude").get<std::string>());
  const int width = bar.at("width_px");
  ASSERT_GT(width, 0);
  for (int y = 0; y < bar.at("height_px").get<int>(); ++y) {
    for (int x = 0; x < width; ++x) {
      const Vec3d color = map.rgb(bar.at("left_px").get<int>() + x, bar.at("top_px").get<int>() + y);
      EXPECT_LT((color - magnitude_color((x + 0.5) / width)).cwiseAbs().maxCoeff(), 1.01 / 510.0)
          << x << " " << y;
    }
  }
}

// A flat square under a distant light is lit evenly. Light is only lost within 3 standard deviations of its
// border, which normalisation gives back, so the truth equals the irradiance and no scattering is exact: what
// is left is the truth's tolerance, 1e-4 of the largest irradiance.
TEST_F(CliRun, NoScatteringIsExactUnderEvenLight) {
  ASSERT_EQ(run(kTiny).exit_code, 0);
  const Json results = json("out/results.json");
  const double bound = 1e-4 * results.at("scene").at("largest_irradiance").get<double>();
  for (const Json& run : results.at("runs")) {
    if (run.at("method") == "none") {
      EXPECT_LE(run.at("metrics").at("max").get<double>(), bound);
    }
  }
}

TEST_F(CliRun, TheCsvHasARowForEachRun) {
  ASSERT_EQ(run(kTiny).exit_code, 0);
  const std::string csv = text("out/results.csv");
  std::vector<std::string> lines;
  std::istringstream stream(csv);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 3U) << csv;
  EXPECT_EQ(lines[0].rfind("view,profile,method,label,skipped,bias,", 0), 0U) << lines[0];
  EXPECT_EQ(lines[1].rfind("front,spike-and-base,none,none,,", 0), 0U) << lines[1];
  EXPECT_EQ(lines[2].rfind("front,spike-and-base,pscbf,pscbf,,", 0), 0U) << lines[2];
  for (const std::string& line : lines) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(lines[0].begin(), lines[0].end(), ','))
        << line;
  }
  EXPECT_FALSE(contains(csv, "nan"));
}

// The maps hold what the JSON says: the picture and the truth, compared again from their files.
TEST_F(CliRun, ComparingItsMapsGivesItsMetrics) {
  ASSERT_EQ(run(kTiny).exit_code, 0);
  const Json results = json("out/results.json");
  for (const Json& run : results.at("runs")) {
    const std::string picture = "out/" + run.at("files").at("exr").get<std::string>();
    const ProgramResult compared =
        truescatter({"compare", picture, "out/maps/front.spike-and-base.truth.exr", "--json"});
    ASSERT_EQ(compared.exit_code, 0) << compared.err;
    const Json stats = Json::parse(compared.out);
    for (const char* key : {"pixels", "bias", "mae", "rmse", "p50", "p99", "max"}) {
      EXPECT_EQ(stats.at(key), run.at("metrics").at(key)) << key;
    }
  }
}

// A dipole whose light stays within a millimetre, so that all of the square has mass enough.
const std::string kOfADipole = with(kTiny, "name = \"spike-and-base\"\n",
                                    "name = \"spike-and-base\"\n[profile.of]\nmodel = \"classical-dipole\"\n"
                                    "sigma_a = 2.0\nsigma_s_prime = 1.0\n");

TEST_F(CliRun, ComparingItsMapsGivesTheErrorsAgainstTheProfileItself) {
  const ProgramResult result = run(kOfADipole);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  const std::string itself = "out/maps/front.spike-and-base.truth.profile.exr";
  const auto expect_metrics = [&](const std::string& picture, const std::string& truth, const Json& metrics) {
    const Json stats = Json::parse(truescatter({"compare", picture, truth, "--json"}).out);
    for (const char* key : {"pixels", "bias", "mae", "rmse", "p50", "p99", "max"})
      EXPECT_EQ(stats.at(key), metrics.at(key)) << picture << " " << key;
  };
  const std::string fit = "out/maps/front.spike-and-base.truth.exr";
  expect_metrics(fit, itself, results.at("fit_errors").at(0).at("metrics"));
  EXPECT_TRUE(exists("out/" + results.at("fit_errors").at(0).at("files").at("signed").get<std::string>()));
  for (const Json& run : results.at("runs")) {
    const std::string picture = "out/" + run.at("files").at("exr").get<std::string>();
    const Json& error = run.at("profile_error");
    expect_metrics(picture, itself, error.at("metrics"));
    expect_metrics(picture, fit, error.at("convolution").at("metrics"));
    EXPECT_TRUE(contains(text("out/results.csv"), error.at("metrics").at("rmse").dump())) << run.at("label");
  }
}

TEST_F(CliRun, ADryRunListsTheTruthOfTheProfileItself) {
  const ProgramResult result = run(kOfADipole, {"--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(
      contains(result.out,
               "  truth front/spike-and-base/profile-itself-normalised: classical dipole of sigma_a 2, "
               "sigma_s' 1 1/mm, eta 1.3, "))
      << result.out;
  EXPECT_TRUE(contains(result.out, " at most; fit error, profile error\n")) << result.out;
}

// Gaussians fitted by the run, and the same from the file that `fit` writes: the same sums, so the same runs;
// and more of them come nearer to the profile.
TEST_F(CliRun, FitsProfilesOrTakesAFile) {
  const std::string medium = "sigma_a = 2.0\nsigma_s_prime = 1.0\n";
  const auto fitted = [&](const std::string& name, int gaussians) {
    return "name = \"" + name + "\"\n[profile.fit]\ngaussians = " + std::to_string(gaussians) +
           "\n[profile.of]\nmodel = \"classical-dipole\"\n" + medium;
  };
  ASSERT_EQ(truescatter({"fit", "--profile", "dipole", "--sigma-a", "2", "--sigma-s-prime", "1", "--eta",
                         "1.3", "--gaussians", "3", "--out", "three.json"})
                .exit_code,
            0);
  const std::string profiles = fitted("one", 1) + "[[profile]]\n" + fitted("three", 3) +
                               "[[profile]]\nname = \"file\"\n[profile.fit]\nfile = \"three.json\"\n";
  const ProgramResult result = run(with(kTiny, "name = \"spike-and-base\"\n", profiles));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  const Json& sums = results.at("profiles");
  ASSERT_EQ(sums.size(), 3U);
  EXPECT_EQ(sums[0].at("gaussians").size(), 1U);
  EXPECT_EQ(sums[1].at("gaussians"), sums[2].at("gaussians"));
  EXPECT_EQ(sums[1].at("fit").at("variances").size(), 3U);
  EXPECT_EQ(sums[1].at("fit").at("asked").at("norm"), "r");
  EXPECT_FALSE(sums[2].contains("fit"));
  ASSERT_EQ(results.at("fit_errors").size(), 2U);
  EXPECT_LT(results.at("fit_errors")[1].at("metrics").at("rmse").get<double>(),
            results.at("fit_errors")[0].at("metrics").at("rmse").get<double>());
  const auto rmse = [&](const std::string& profile) {
    for (const Json& r : results.at("runs"))
      if (r.at("profile") == profile) return r.at("metrics").at("rmse").get<double>();
    return -1.0;
  };
  EXPECT_EQ(rmse("three"), rmse("file"));
}

// Everything that a run says but times, memory (more jobs need more) and provenance.
Json without_times(Json results) {
  results.erase("provenance");
  for (Json& view : results.at("views")) view.erase("memory_estimate_bytes");
  for (Json& truth : results.at("truths")) {
    truth.erase("seconds");
    truth.erase("cached");
  }
  for (Json& run : results.at("runs")) {
    if (!run.contains("cost")) continue;
    run.at("cost").erase("frame_ms");
    run.at("cost").erase("setup_ms");
  }
  return results;
}

// A scene with a shadow edge, a silhouette and every method, so that there is something to differ.
const std::string kCards =
    with(with(with(kTiny, "builtin:plane", "builtin:cards"), "fov_deg = 10.0", "fov_deg = 16.0"),
         "[0.0, 0.5, 1.0]", "[0.7, 0.0, 1.0]");

TEST_F(CliRun, TheNumberOfJobsChangesNoDigit) {
  ASSERT_EQ(run(kCards, {"--jobs", "1", "--no-cache"}).exit_code, 0);
  const Json one = json("out/results.json");
  std::filesystem::rename(folder_.path() / "out", folder_.path() / "one");
  ASSERT_EQ(run(kCards, {"--jobs", "2", "--no-cache"}).exit_code, 0);
  const Json two = json("out/results.json");
  EXPECT_EQ(one.at("provenance").at("machine").at("jobs"), 1);
  EXPECT_EQ(without_times(one).dump(1), without_times(two).dump(1));
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "one" / "maps")) {
    const std::string name = "/maps/" + entry.path().filename().string();
    if (entry.path().extension() != ".png") continue;
    EXPECT_EQ(text("one" + name), text("out" + name)) << name;
  }
}

TEST_F(CliRun, TheResolvedExperimentRepeatsTheRun) {
  const ProgramResult first = run(kCards, {"--set", "truth.seed=5", "--set", "shading.tolerance=0.05"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const ProgramResult second =
      truescatter({"run", "out/experiment.resolved.toml", "--out", "again", "--no-cache"});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(without_times(json("out/results.json")).dump(1),
            without_times(json("again/results.json")).dump(1));
  EXPECT_EQ(text("out/experiment.resolved.toml"), text("again/experiment.resolved.toml"));
  // `compare` says the same of the two folders: nothing but time has changed.
  const Json changes = Json::parse(truescatter({"compare", "out", "again", "--json"}).out);
  EXPECT_EQ(changes.at("experiment"), Json::object());
  EXPECT_EQ(changes.at("runs").size(), 2U);
  for (const Json& run : changes.at("runs")) {
    for (const auto& [name, metric] : run.at("metrics").items()) {
      if (name == "frame_ms") continue;
      EXPECT_EQ(metric.at("old"), metric.at("new")) << name;
    }
  }
}

TEST_F(CliRun, WithoutOutItWritesToRuns) {
  folder_.write("e.toml", kTiny);
  const ProgramResult result = truescatter({"run", "e.toml"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(exists("runs/tiny/results.json"));
  EXPECT_EQ(result.out, "runs/tiny/report.html\n");
}

TEST_F(CliRun, ADryRunListsWhatWouldRunAndWritesNothing) {
  const std::string experiment = with(kTiny, "[timing]", R"([[method]]
name = "pscbf"
label = "coarse"
settings.taps = 5
[[method]]
name = "texture-space"
[[threshold]]
method = "coarse"
maximum = 0.5
[timing])");
  const ProgramResult result = run(experiment, {"--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  // The estimate's figures are those of the machine's libraries and jobs.
  std::string listed = result.out;
  const std::size_t memory = listed.find("memory view front: about ");
  ASSERT_NE(memory, std::string::npos) << result.out;
  listed.erase(memory, listed.find('\n', memory) + 1 - memory);
  listed = std::regex_replace(listed, std::regex("about [0-9.]+ (s|min|h)"), "about so long");
  EXPECT_EQ(listed, R"(tiny: 1 view x 1 profile x 4 methods = 4 runs
scene builtin:plane (charts = 1, edge_mm = 5, length_mm = 0, size_mm = 20, uv_stretch = 1)
method none: No scattering
method pscbf: Pseudo-separable cross bilateral filter (placement = median, r_max_mm = 0, sampling = taps, sharing = red, taps = 13, targets = 32-bit)
method coarse: Pseudo-separable cross bilateral filter (placement = median, r_max_mm = 0, sampling = taps, sharing = red, taps = 5, targets = 32-bit)
method texture-space: Texture-space diffusion (first_gaussian = blurred, gutter = nearest, passes = incremental, reading = bilinear, stretch = raw, taps = seven, texture_size = 1024)
view front: 48 x 48 px
  truth front/spike-and-base/euclidean-normalised: Euclidean, normalised, not cut, 3 Gaussians; headline; own target of none
  truth front/spike-and-base/euclidean-normalised-r4.5: Euclidean, normalised, cut at 4.5 mm, 3 Gaussians; own target of pscbf, coarse
  truth front/spike-and-base/geodesic-normalised: geodesic, normalised, not cut, 3 Gaussians; own target of texture-space
  run front/spike-and-base/none: 0 + 1 frames
  run front/spike-and-base/pscbf: 0 + 1 frames
  run front/spike-and-base/coarse: 0 + 1 frames
  run front/spike-and-base/texture-space: 0 + 1 frames
threshold coarse: rmse <= 0.5
piece view.front: about so long; nothing of it is kept
piece truth.front.spike-and-base.truth: about so long; nothing of it is kept
piece run.front.spike-and-base.none: about so long; nothing of it is kept
piece run.front.spike-and-base.pscbf: about so long; nothing of it is kept
piece run.front.spike-and-base.coarse: about so long; nothing of it is kept
piece run.front.spike-and-base.texture-space: about so long; nothing of it is kept
pieces: about so long, and what their scenes and truths share
output out: a new folder
)");
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"e.toml"});
}

// What is listed is what runs: the truths and runs of results.json, in their order.
TEST_F(CliRun, ADryRunListsTheTruthsAndRunsOfTheRun) {
  const std::string experiment =
      with(kTiny, "[[profile]]", "[[profile]]\nname = \"skin-six-gaussian\"\n[[profile]]");
  std::vector<std::string> listed;
  std::istringstream lines(run(experiment, {"--dry-run"}).out);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("  truth ") || line.starts_with("  run "))
      listed.push_back(line.substr(0, line.find(':')));
  }
  ASSERT_EQ(run(experiment).exit_code, 0);
  const Json results = json("out/results.json");
  std::vector<std::string> done;
  for (const Json& truth : results.at("truths"))
    done.push_back("  truth " + truth.at("id").get<std::string>());
  for (const Json& run : results.at("runs")) {
    done.push_back("  run " + run.at("view").get<std::string>() + "/" + run.at("profile").get<std::string>() +
                   "/" + run.at("label").get<std::string>());
  }
  EXPECT_EQ(listed, done);
  EXPECT_EQ(listed.size(), 8U);  // two profiles, each with two truths and two runs
  EXPECT_TRUE(contains(run(experiment, {"--dry-run"}).out, "output out: replaces what is there\n"));
}

TEST_F(CliRun, OverridesReachTheRun) {
  const ProgramResult result = run(kTiny, {"--set", "view.front.width_px=20", "--set", "name=other"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  EXPECT_EQ(results.at("views").at(0).at("width_px"), 20);
  EXPECT_EQ(results.at("experiment").at("name"), "other");
}

// pscbf on a slanted light differs from the truth by more than nothing; none is bounded by a large number.
TEST_F(CliRun, AnExceededThresholdEndsWithOneButWritesEverything) {
  const std::string experiment = kCards + R"([[threshold]]
method = "none"
metric = "max"
maximum = 1e-9
[[threshold]]
method = "pscbf"
maximum = 1e9
)";
  const ProgramResult result = run(experiment);
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_TRUE(contains(result.err, "exceeded: e.toml:31")) << result.err;
  EXPECT_TRUE(contains(result.err, "max of none in view front with spike-and-base is ")) << result.err;
  EXPECT_FALSE(contains(result.err, "of pscbf")) << result.err;
  EXPECT_TRUE(exists("out/report.html"));
  EXPECT_EQ(json("out/results.json").at("exceeded").size(), 1U);
  EXPECT_EQ(run(with(experiment, "1e-9", "1e9")).exit_code, 0);
}

TEST_F(CliRun, TextureSpaceWithoutUvsIsSkippedWithAReason) {
  folder_.write("a.obj", "v -10 -10 0\nv 10 -10 0\nv 10 10 0\nv -10 10 0\nf 1 2 3\nf 1 3 4\n");
  const std::string experiment =
      with(with(kTiny, "mesh = \"builtin:plane\"\n[scene.parameters]\nsize_mm = 20.0\nedge_mm = 5.0\n",
                "mesh = \"a.obj\"\n"),
           "\"pscbf\"", "\"texture-space\"");
  EXPECT_TRUE(contains(run(experiment, {"--dry-run"}).out,
                       "  skip front/spike-and-base/texture-space: it needs UVs, and the mesh has none\n"));
  const ProgramResult result = run(experiment);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  ASSERT_EQ(results.at("runs").size(), 2U);
  EXPECT_FALSE(results.at("runs").at(0).contains("skipped"));
  EXPECT_EQ(results.at("runs").at(1).at("skipped"), "this method needs UVs, and the mesh has none");
  EXPECT_FALSE(results.at("runs").at(1).contains("metrics"));
  EXPECT_TRUE(
      contains(text("out/results.csv"), "texture-space,\"this method needs UVs, and the mesh has none\","));
}

// On a plane geodesics are straight, so the truth along the surface is the headline's: the errors against
// both differ by the two uncertainties at most, for an RMSE is a norm.
TEST_F(CliRun, TextureSpaceIsMeasuredAgainstItsGeodesicTruth) {
  const std::string experiment = with(with(kTiny, "\"pscbf\"", "\"texture-space\""), "[timing]",
                                      "[truth]\ngeodesic = \"extra\"\n[timing]");
  EXPECT_TRUE(contains(run(experiment, {"--dry-run"}).out,
                       "  truth front/spike-and-base/geodesic-normalised: geodesic, normalised, not cut, 3 "
                       "Gaussians; own target of texture-space; extra\n"));
  const ProgramResult result = run(experiment);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  ASSERT_EQ(results.at("truths").size(), 2U);
  const Json& headline = results.at("truths").at(0);
  const Json& geodesic = results.at("truths").at(1);
  EXPECT_EQ(geodesic.at("id"), "front/spike-and-base/geodesic-normalised");
  EXPECT_EQ(geodesic.at("metric"), "geodesic");
  EXPECT_EQ(geodesic.at("own_target_of"), Json({"texture-space"}));
  EXPECT_EQ(geodesic.at("extra"), true);
  EXPECT_EQ(geodesic.at("certificate").at("audited"), 256);
  const double bound = (headline.at("uncertainty").get<double>() + geodesic.at("uncertainty").get<double>()) *
                       results.at("scene").at("largest_irradiance").get<double>();
  for (const Json& run : results.at("runs")) {
    ASSERT_EQ(run.at("extra_targets").size(), 1U);
    const Json& extra = run.at("extra_targets").at(0);
    EXPECT_EQ(extra.at("truth"), geodesic.at("id"));
    EXPECT_NEAR(extra.at("metrics").at("rmse").get<double>(), run.at("metrics").at("rmse").get<double>(),
                bound + 1e-7);  // and single precision's rounding of both pictures
    EXPECT_EQ(extra.at("distinguishable"), run.at("distinguishable"));
  }
  const Json& texture_space = results.at("runs").at(1);
  EXPECT_EQ(texture_space.at("own_target"), texture_space.at("extra_targets").at(0));
}

// A stripe of skin, 1.25 mm wide, on an evenly lit plane: alone it holds less than half of the wider
// Gaussians' mass; with the plane around it all.
TEST_F(CliRun, WhatIsNotSkinGivesLightWhereAskedTo) {
  Image stripe(64, 4, 1);
  for (int y = 0; y < 4; ++y) {
    for (int x = 30; x < 34; ++x) stripe.at(x, y, 0) = 1.0F;
  }
  write_png(folder_.path() / "stripe.png", stripe);
  const std::string masked =
      with(kTiny, "[scene.parameters]", "skin_mask = \"stripe.png\"\n[scene.parameters]");
  const std::string all = with(masked, "[timing]", "[truth]\nmask_truth = \"all\"\n[timing]");
  const std::string said = "truth: what is not skin gives and receives light too\n";
  EXPECT_FALSE(contains(run(masked, {"--dry-run"}).out, said));
  EXPECT_TRUE(contains(run(all, {"--dry-run"}).out, said));
  const auto results_of = [&](const std::string& experiment) {
    const ProgramResult result = run(experiment);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json("out/results.json");
  };
  const Json alone = results_of(masked);
  const Json together = results_of(all);
  EXPECT_EQ(alone.at("scene").at("mask_truth"), "skin");
  EXPECT_EQ(together.at("scene").at("mask_truth"), "all");
  for (const char* same : {"skin_triangles", "skin_components", "shading_triangles"})
    EXPECT_EQ(alone.at("scene").at(same), together.at("scene").at(same)) << same;
  const Json& seen = alone.at("views").at(0).at("skin_pixels");
  EXPECT_EQ(seen, together.at("views").at(0).at("skin_pixels"));
  EXPECT_EQ(alone.at("truths").at(0).at("low_mass_pixels"), seen);
  EXPECT_EQ(together.at("truths").at(0).at("low_mass_pixels"), 0);
}

// The plane goes on beyond the picture, where the visible surface ends.
TEST_F(CliRun, MeasuresAgainstTheVisibleSurfaceWhereAskedTo) {
  const std::string experiment = with(kTiny, "[timing]", "[truth]\nvisible_only = true\n[timing]");
  EXPECT_TRUE(
      contains(run(experiment, {"--dry-run"}).out,
               "  truth front/spike-and-base/euclidean-visible-normalised: Euclidean, normalised, not "
               "cut, visible surface only, 3 Gaussians; extra\n"));
  const ProgramResult result = run(experiment);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  const Json& truth = results.at("truths").at(2);
  EXPECT_EQ(truth.at("id"), "front/spike-and-base/euclidean-visible-normalised");
  EXPECT_EQ(truth.at("visible_only"), true);
  const double rms = truth.at("visibility_bound").at("rms");
  EXPECT_GT(rms, 0.0);
  EXPECT_LT(rms, truth.at("visibility_bound").at("max").get<double>());
  EXPECT_FALSE(results.at("truths").at(0).contains("visibility_bound"));
  for (const Json& run : results.at("runs")) {
    ASSERT_EQ(run.at("extra_targets").size(), 1U);
    const Json& extra = run.at("extra_targets").at(0);
    EXPECT_EQ(extra.at("truth"), truth.at("id"));
    // Even light stays even, whatever part of the surface gives it.
    if (run.at("method") == "none") {
      EXPECT_LT(extra.at("metrics").at("max").get<double>(), 1e-4);
      EXPECT_EQ(extra.at("distinguishable"), false);
    }
  }
}

// A plane has none of any: G of two distances that are equal but for rounding. What r_max = 4.5 mm cuts off
// is exp(-4.5^2 / 2 v) of each channel's Gaussian of variance v (2.3, 1.4, 1.1 mm^2) and weight (0.85, 0.82,
// 0.80); the quadrature is cut by the circle, see light_paths_test.cpp.
TEST_F(CliRun, SplitsLightByItsWayWhereAskedTo) {
  const std::string wide = with(kTiny, "size_mm = 20.0", "size_mm = 60.0");
  const ProgramResult result = run(with(wide, "[timing]", "[truth]\nlight_paths = 20\n[timing]"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json paths = json("out/results.json").at("light_paths");
  ASSERT_EQ(paths.size(), 1U);
  const Json& entry = paths.at(0);
  EXPECT_EQ(entry.at("view"), "front");
  EXPECT_EQ(entry.at("points"), 20);
  for (const std::string part : {"transmittance", "air", "curvature", "sum"})
    EXPECT_LT(entry.at(part).at("rms").get<double>(), 1e-9) << part;
  const double cut = 0.2126 * 0.85 * std::exp(-10.125 / 2.3) + 0.7152 * 0.82 * std::exp(-10.125 / 1.4) +
                     0.0722 * 0.80 * std::exp(-10.125 / 1.1);
  EXPECT_NEAR(entry.at("beyond_r_max").at("mean").get<double>(), cut, 6e-4);
  EXPECT_LE(entry.at("sum_check").at("max_difference").get<double>(),
            entry.at("sum_check").at("allowed").get<double>());
  ASSERT_EQ(run(kTiny).exit_code, 0);
  EXPECT_TRUE(json("out/results.json").at("light_paths").empty());
}

// A method with transmittance has the truth of what it sets out to compute at as many pixels as are audited.
void expect_sampled_own_target(const Json& results) {
  const Json& run = results.at("runs").at(0);
  const Json& own = run.at("own_target");
  EXPECT_EQ(own.at("transmittance"), true);
  EXPECT_GT(own.at("sampled").at("points").get<int>(), 200);
  EXPECT_LE(own.at("sampled").at("points").get<int>(), 256);
  EXPECT_EQ(own.at("sampled").at("headline_metrics").size(), own.at("metrics").size());
  EXPECT_LT(own.at("metrics").at("rmse"), run.at("metrics").at("rmse")) << run.at("label");
  for (const Json& truth : results.at("truths")) {
    if (truth.at("id") != own.at("truth")) continue;
    EXPECT_EQ(truth.at("points"), 256);
    EXPECT_EQ(truth.at("own_target_of"), Json::array({run.at("label")}));
    return;
  }
  ADD_FAILURE() << "no truth " << own.at("truth");
}

// A slab lit from behind: through it comes light, unless the mask leaves no transmitter.
TEST_F(CliRun, LetsLightThroughTransmittersOnly) {
  write_png(folder_.path() / "dark.png", Image(8, 8, 3, 0.0F));
  const auto difference = [&](const std::string& experiment) {
    const ProgramResult result = run(with(experiment, "size_mm = 20.0", "thickness_mm = 1.0"));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const Json runs = json("out/results.json").at("runs");
    return runs.at(0).at("metrics").at("bias").get<double>() -
           runs.at(1).at("metrics").at("bias").get<double>();
  };
  const auto slab = [&](const std::string& local, const std::string& transmitting,
                        const std::string& settings) {
    return with(
        with(with(with(kTiny, "builtin:plane", "builtin:slab"), "[0.0, 0.5, 1.0]", "[0.0, 0.5, -1.0]"),
             "\"pscbf\"", "\"" + local + "\"" + settings),
        "\"none\"", "\"" + transmitting + "\"" + settings);
  };
  for (const auto& [local, transmitting, settings] :
       {std::tuple("pscbf", "pscbf-transmit", ""),
        std::tuple("texture-space", "texture-space-transmit", "\nsettings.texture_size = 256")}) {
    const std::string experiment = slab(local, transmitting, settings);
    EXPECT_GT(difference(experiment), 0.1) << transmitting;
    expect_sampled_own_target(json("out/results.json"));
    EXPECT_EQ(difference(with(experiment, "[scene.parameters]",
                              "transmitter_mask = \"dark.png\"\n[scene.parameters]")),
              0.0)
        << transmitting;
  }
}

// A ball's atlas has seams in view; a square has none, and says so.
TEST_F(CliRun, MeasuresSeamsAndStretchWhereAskedTo) {
  const std::string ball = kBallScene +
                           "width_px = 48\nheight_px = 48\n[[profile]]\nname = \"spike-and-base\"\n"
                           "[[method]]\nname = \"texture-space\"\n[truth]\ngeodesic = \"off\"\n"
                           "[metrics]\nseam = true\n[timing]\nwarm_up = 0\nrepeats = 1\n";
  const ProgramResult result = run(ball);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json metrics = json("out/results.json").at("runs").at(0).at("metrics");
  const Json& seam = metrics.at("seam");
  expect_keys(seam, {"peak", "width_mm", "energy", "contrast", "profile", "pixels", "stretch"}, "seam");
  EXPECT_GT(seam.at("peak").get<double>(), 0.0);
  EXPECT_GT(seam.at("energy").get<double>(), 0.0);
  int pixels = 0;
  for (const Json& bin : seam.at("stretch")) pixels += bin.at("pixels").get<int>();
  EXPECT_EQ(pixels, metrics.at("pixels"));
  EXPECT_TRUE(seam.at("stretch").back().at("to").is_null());
  expect_keys(metrics.at("channels").at("g").at("seam"), {"peak", "stretch"}, "seam of green");

  ASSERT_EQ(run(with(kTiny, "[timing]", "[metrics]\nseam = true\n[timing]")).exit_code, 0);
  const Json square = json("out/results.json").at("runs").at(0).at("metrics").at("seam");
  EXPECT_TRUE(square.at("peak").is_null());
  EXPECT_EQ(square.at("peak_reason"), "no UV seam in view with light beside it");
}

// Two cards of 60 mm, one 20 mm behind the other, in view side by side: 30 mm each of one straight edge of 60
// mm.
const std::string kTwoCards = R"(
[scene]
mesh = "builtin:cards"
[[light]]
direction = [0.0, 0.0, 1.0]
shadows = false
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 2000.0]
fov_deg = 2.2915
width_px = 256
height_px = 256
[[profile]]
name = "spike-and-base"
[[method]]
name = "none"
[[method]]
name = "blur2d"
[[method]]
name = "cbf"
[metrics]
leak = true
[timing]
warm_up = 0
repeats = 1
)";

// Either card lit alone with I = 1. A Gaussian carries Phi(-x / s) of it to a distance x beyond a straight
// edge: s / sqrt(2 pi) per mm of edge, less at the edge's two ends, which have dark corners beside them: s^2
// / 2 pi each. With spike w_0 = 15, 18, 20 % and v = 2.3, 1.4, 1.1 mm^2, by the weights of luminance. That
// twice, over a truth of 1 on 30 mm x 60 mm twice, but for its corners. The scale of the cards differs by 1 %
// and blur2d has one for both: 0.5 %; pixels of 0.31 mm at the edges of 60 mm: 0.5 %; corners of less than
// half the mass are not measured, six of less than s^2 each: 0.4 %; the taps end at 4 s: 0.01 %.
TEST_F(CliRun, MeasuresLeaksWhereAskedTo) {
  const ProgramResult result = run(kTwoCards);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  const std::array<double, 3> luminance_weight = {0.2126, 0.7152, 0.0722};
  const std::array<double, 3> base = {0.85, 0.82, 0.80};
  const std::array<double, 3> variance_mm2 = {2.3, 1.4, 1.1};
  // The first pixel beyond the edge: its centre is half a pixel away, at most 1 % of which is the scale.
  const double half_px_mm = 0.5 * 80.0 / 256.0;
  double crossing_mm2 = 0.0;
  double beside_edge = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double s = std::sqrt(variance_mm2[c]);
    const double weight = luminance_weight[c] * base[c];
    crossing_mm2 += weight * (60.0 * s / std::sqrt(2.0 * kPi) - 2.0 * variance_mm2[c] / (2.0 * kPi));
    beside_edge += weight * 0.5 * std::erfc(half_px_mm / (s * std::sqrt(2.0)));
  }
  const double expected = 2.0 * crossing_mm2 / (2.0 * 30.0 * 60.0);
  const Json& none = results.at("runs").at(0).at("metrics").at("leak");
  EXPECT_EQ(none.at("energy"), 0.0);
  EXPECT_EQ(none.at("peak"), 0.0);
  ASSERT_EQ(none.at("by_surface").size(), 2U);
  const Json& blur = results.at("runs").at(1).at("metrics").at("leak");
  EXPECT_NEAR(blur.at("energy").get<double>(), expected, 0.015 * expected);
  EXPECT_NEAR(blur.at("peak").get<double>(), beside_edge, 0.01 * beside_edge);
  for (const Json& surface : blur.at("by_surface"))
    EXPECT_NEAR(surface.at("energy").get<double>(), expected, 0.03 * expected) << surface;
  // Its depth term is exp(-20^2 / (2 * 2.3)) = 2e-38 at most.
  const Json& filter = results.at("runs").at(2).at("metrics").at("leak");
  EXPECT_LT(filter.at("energy").get<double>(), 1e-30);
  EXPECT_TRUE(contains(text("out/results.csv"), ",leak_energy,leak_peak,"));
}

TEST_F(CliRun, ASurfaceAloneHasNoLeakAndSaysWhy) {
  ASSERT_EQ(run(with(kTiny, "[timing]", "[metrics]\nleak = true\n[timing]")).exit_code, 0);
  const Json metrics = json("out/results.json").at("runs").at(0).at("metrics");
  EXPECT_TRUE(metrics.at("leak").is_null());
  EXPECT_EQ(metrics.at("leak_reason"), "the view shows one surface alone");
}

// The textures by which light comes through a slab of 1 mm that is lit from behind: t cos(theta), corrected
// for the light's angle, is its thickness, so that exp(-0.2 / mm * 1 mm) is stored. A texel of the shadow map
// is 1/1024 of the light's picture of the slab, 70 mm at most, and reads a depth that is off by tan(theta) =
// 1/2 of that at most: 0.035 mm, 0.2 times that of the value.
TEST_F(CliRun, ExportsWhatLightComesThroughBy) {
  const std::string slab =
      with(with(with(with(kTiny, "builtin:plane", "builtin:slab"), "size_mm = 20.0", "thickness_mm = 1.0"),
                "[0.0, 0.5, 1.0]", "[0.0, 0.5, -1.0]"),
           "\"pscbf\"", "\"texture-space-transmit\"");
  ASSERT_EQ(run(slab, {"--export-passes"}).exit_code, 0);
  std::map<std::string, Json> named;
  const Json results = json("out/results.json");
  for (const Json& pass : results.at("runs").at(1).at("files").at("passes")) named[pass.at("name")] = pass;
  EXPECT_EQ(named.at("shadow-map").at("channels"), "zuvt");
  EXPECT_EQ(named.at("entry").at("channels"), "uvde");
  const std::string file = named.at("thickness").at("exr");
  const Image thickness = read_image(folder_.path() / "out" / file);
  EXPECT_NEAR(thickness.at(24, 24, 0), std::exp(-0.2), 0.2 * 0.035);
}

TEST_F(CliRun, SwitchedOffGeodesicTruthsLeaveAReason) {
  const std::string experiment = with(with(kTiny, "\"pscbf\"", "\"texture-space\""), "[timing]",
                                      "[truth]\ngeodesic = \"off\"\n[timing]");
  const std::string reason = "the experiment sets truth.geodesic = \"off\"";
  EXPECT_TRUE(contains(run(experiment, {"--dry-run"}).out,
                       "own target of texture-space; not computed: " + reason + "\n"));
  ASSERT_EQ(run(experiment).exit_code, 0);
  const Json results = json("out/results.json");
  EXPECT_EQ(results.at("truths").size(), 1U);
  const Json& own = results.at("runs").at(1).at("own_target");
  EXPECT_EQ(own.at("metric"), "geodesic");
  EXPECT_TRUE(own.at("truth").is_null());
  EXPECT_TRUE(own.at("metrics").is_null());
  EXPECT_EQ(own.at("metrics_reason"), reason);
  EXPECT_FALSE(results.at("runs").at(1).contains("extra_targets"));
}

// Two squares and a fin on their common edge: what the fin does to geodesics has no one answer, and all else
// has.
TEST_F(CliRun, AMeshThatCarriesNoGeodesicsIsMeasuredWithoutThem) {
  folder_.write("fin.obj",
                "v -10 -10 0\nv 0 -10 0\nv 10 -10 0\nv -10 10 0\nv 0 10 0\nv 10 10 0\nv 0 0 -5\n"
                "vt 0 0\nvt 0.4 0\nvt 0.8 0\nvt 0 1\nvt 0.4 1\nvt 0.8 1\nvt 1 0.5\n"
                "f 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\nf 2/2 5/5 7/7\n");
  const ProgramResult result =
      run(with(with(kTiny, "mesh = \"builtin:plane\"\n[scene.parameters]\nsize_mm = 20.0\nedge_mm = 5.0\n",
                    "mesh = \"fin.obj\"\n"),
               "\"pscbf\"", "\"texture-space\""));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  const Json& texture_space = results.at("runs").at(1);
  EXPECT_TRUE(texture_space.at("metrics").at("rmse").is_number());
  EXPECT_TRUE(texture_space.at("own_target").at("metrics").is_null());
  const std::string reason = texture_space.at("own_target").at("metrics_reason");
  EXPECT_TRUE(reason.starts_with("the mesh carries no geodesics: fin.obj: triangles ")) << reason;
}

// Each rung is an image; so signed differences add up whatever the rungs are.
TEST_F(CliRun, LaddersTelescope) {
  const std::string ladder =
      "\n[[ladder]]\nname = \"chain\"\n[[ladder.rung]]\ntruth = \"whole\"\nassumption = \"none\"\n"
      "[[ladder.rung]]\ntruth = \"cut-visible\"\nassumption = \"a cut\"\n"
      "[[ladder.rung]]\nmethod = \"pscbf\"\nassumption = \"a filter\"\n"
      "[[ladder.rung]]\nmethod = \"none\"\nassumption = \"nothing at all\"\n";
  const ProgramResult result = run(with(kTiny, "direction = [0.0, 0.5, 1.0]",
                                        "type = \"point\"\nposition_mm = [0, 0, 8]\nreference_mm = 8") +
                                   ladder);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json("out/results.json");
  ASSERT_EQ(results.at("ladders").size(), 1U);
  const Json& chain = results.at("ladders").at(0);
  ASSERT_EQ(chain.at("rungs").size(), 4U);
  EXPECT_FALSE(chain.at("rungs").at(0).contains("step"));
  double sum = 0.0;
  for (std::size_t r = 1; r < 4; ++r) {
    const Json& rung = chain.at("rungs").at(r);
    sum += rung.at("step").at("bias").get<double>();
    EXPECT_TRUE(exists("out/" + rung.at("files").at("signed").get<std::string>()));
  }
  // Sums of some thousand differences of numbers up to 1, each to rounding in double precision.
  EXPECT_NEAR(sum, chain.at("rungs").at(3).at("so_far").at("bias").get<double>(), 1e-14);
  // Three steps of values below 1, each rounded to a float.
  EXPECT_LE(chain.at("telescopes").at("largest_gap").get<double>(), 3.0 * std::exp2(-25.0));
  EXPECT_GT(std::abs(sum), 1e-4);  // there is something to add up

  // The maps that are written: each step is a difference of values below 1, rounded to single precision
  // (2^-25), and three of them sum to the last rung less the first.
  const std::filesystem::path maps = folder_.path() / "out/maps";
  const Image first = read_rgb(maps / "front.spike-and-base.truth.exr");
  const Image last = read_rgb(maps / "front.spike-and-base.none.exr");
  std::vector<Image> steps;
  for (const std::string rung : {"truth-cut-visible", "pscbf", "none"})
    steps.push_back(read_rgb(maps / "front.spike-and-base.ladder-chain.exr", rung));
  double largest = 0.0;
  int measured = 0;
  for (int y = 0; y < first.height(); ++y) {
    for (int x = 0; x < first.width(); ++x) {
      const Vec3d whole = last.rgb(x, y) - first.rgb(x, y);
      // Where the picture's border leaves the truth of what is seen less than half of its mass, nothing is
      // measured.
      if (steps[0].rgb(x, y).isZero() && steps[1].rgb(x, y).isZero() && steps[2].rgb(x, y).isZero()) continue;
      ++measured;
      const Vec3d all = steps[0].rgb(x, y) + steps[1].rgb(x, y) + steps[2].rgb(x, y);
      EXPECT_LE((all - whole).cwiseAbs().maxCoeff(), 3.0 * 0x1p-25) << x << ", " << y;
      largest = std::max(largest, whole.cwiseAbs().maxCoeff());
    }
  }
  EXPECT_GT(largest, 1e-3);
  EXPECT_GE(measured, 44 * 44);  // of 48 x 48: all but two rows and columns at each side
}

TEST_F(CliRun, ReportWritesTheReportAgain) {
  ASSERT_EQ(run(kTiny).exit_code, 0);
  std::filesystem::remove(folder_.path() / "out" / "report.html");
  const ProgramResult result = truescatter({"report", "out"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(exists("out/report.html"));
}

// Every file below a folder with its bytes.
// Of a run that was cut off.
bool is_left(const std::string& name) { return name.starts_with(".out."); }

std::map<std::string, std::string> contents(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    files[name] = entry.is_directory() ? "a folder" : read_text_file(entry.path());
  }
  return files;
}

// A second run into the same folder replaces the first one's files, those too that it does not write again.
TEST_F(CliRun, ARunReplacesAnEarlierOneAsAWhole) {
  ASSERT_EQ(run(kTiny, {"--set", "name=first"}).exit_code, 0);
  ASSERT_TRUE(exists("out/maps/front.spike-and-base.pscbf.exr"));
  ASSERT_EQ(run(with(kTiny, "[[method]]\nname = \"pscbf\"", ""), {"--set", "name=second"}).exit_code, 0);
  EXPECT_EQ(json("out/results.json").at("experiment").at("name"), "second");
  EXPECT_TRUE(exists("out/maps/front.spike-and-base.none.exr"));
  for (const auto& [name, bytes] : contents(folder_.path()))
    EXPECT_FALSE(contains(name, "pscbf") || contains(name, ".part") || contains(name, ".old")) << name;
}

// No file may grow beyond 4 KiB (8 blocks of 512 bytes), as on a full disk: the maps cannot be written.
TEST_F(CliRun, AFailingRunLeavesTheEarlierResultByteForByte) {
  ASSERT_EQ(run(kTiny).exit_code, 0);
  const auto before = contents(folder_.path());
  const ProgramResult result =
      run_program("/bin/sh",
                  {"-c", "trap '' XFSZ; ulimit -f 8; exec \"$0\" run e.toml --out out --set name=second",
                   TRUESCATTER_BINARY},
                  folder_.path());
  EXPECT_EQ(result.exit_code, 3) << result.err;
  EXPECT_TRUE(contains(result.err, "cannot write")) << result.err;
  auto after = contents(folder_.path());
  std::erase_if(after, [](const auto& file) { return is_left(file.first); });
  EXPECT_EQ(after, before);
}

// Without an earlier result there is what --resume goes on from, and nothing else.
TEST_F(CliRun, AFailingFirstRunLeavesWhatIsFinished) {
  folder_.write("e.toml", kTiny);
  const ProgramResult result =
      run_program("/bin/sh", {"-c", "trap '' XFSZ; ulimit -f 8; exec \"$0\" run e.toml", TRUESCATTER_BINARY},
                  folder_.path());
  EXPECT_EQ(result.exit_code, 3) << result.err;
  EXPECT_FALSE(exists("runs/tiny"));
  for (const auto& left : std::filesystem::directory_iterator(folder_.path() / "runs"))
    EXPECT_TRUE(left.path().filename().string().starts_with(".tiny.")) << left.path();
}

// Wrong input that is found late leaves nothing, not even the folders made on the way: it stays wrong.
TEST_F(CliRun, WrongInputLeavesNothing) {
  folder_.write("e.toml",
                kTiny +
                    "[[view]]\nname = \"away\"\neye_mm = [0.0, 0.0, 100.0]\ntarget_mm = [0.0, 0.0, 200.0]\n"
                    "fov_deg = 10.0\nwidth_px = 8\nheight_px = 8\n");
  const ProgramResult result = truescatter({"run", "e.toml"});
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_TRUE(contains(result.err, "view 'away' sees no skin")) << result.err;
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"e.toml"});
}

TEST_F(CliRun, WhatAKilledRunLeftIsRemovedAndSaid) {
  const std::filesystem::path left = folder_.path() / ".out.4194305.part";  // above Linux' largest process id
  std::filesystem::create_directories(left / "maps");
  folder_.write(".out.4194305.part/maps/front.png", "half a picture");
  const ProgramResult result = run(kTiny);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, ".out.4194305.part: left by a run that was cut off; removed"))
      << result.err;
  EXPECT_FALSE(std::filesystem::exists(left));
  EXPECT_TRUE(exists("out/report.html"));
}

}  // namespace
}  // namespace truescatter::test
