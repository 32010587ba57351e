#include <cmath>
#include <cstdlib>

#include "cli/cli_fixture.h"
#include "core/image_io.h"
#include "support/image_difference.h"

namespace truescatter::test {
namespace {

using Json = nlohmann::json;

const Json& run_of(const Json& results, const std::string& label) {
  const auto found = std::find_if(results["runs"].begin(), results["runs"].end(),
                                  [&](const Json& r) { return r["label"] == label; });
  if (found == results["runs"].end()) throw std::runtime_error("no such run: " + label);
  return *found;
}

// A sphere of 8 mm that does not fill its 40 x 40 pixels.
const std::string kBall = kBallScene + R"(width_px = 40
height_px = 40
[[profile]]
name = "spike-and-base"
[timing]
warm_up = 0
repeats = 1
[[method]]
name = "none"
)";

// One axis of blur2d: the same sum, written anew.
const std::string kBlur = R"(SAMPLER(previous);
uniform float focal_px, median_skin_depth_mm, std_dev_mm;
uniform int axis;
uniform float reach;
void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  float s = std_dev_mm * focal_px / median_skin_depth_mm;
  vec4 sum = vec4(read_texel(previous, p).rgb, 1.0);
  for (int i = 1; i <= int(ceil(reach * s)); ++i) {
    for (int side = -1; side <= 1; side += 2) {
      ivec2 q = p + side * i * (axis == 0 ? ivec2(1, 0) : ivec2(0, 1));
      if (inside(q, textureSize(previous, 0)))
        sum += exp(-float(i * i) / (2.0 * s * s)) * vec4(read_texel(previous, q).rgb, 1.0);
    }
  }
  result = vec4(sum.rgb / sum.a, read_texel(previous, p).a);
}
)";

const std::string kMine = R"(
[[method]]
name = "mine"
settings.reach = 4.0
[[method.pass]]
shader = "mine.frag"
inputs = ["previous"]
settings.axis = 0
[[method.pass]]
shader = "mine.frag"
inputs = ["previous"]
settings.axis = 1
)";

// A method of one pass, with its shader in mine.frag.
const std::string kOnePass = R"(
[[method]]
name = "mine"
run = "once"
[[method.pass]]
shader = "mine.frag"
inputs = ["irradiance"]
)";

class OwnShader : public Cli {
 protected:
  Json results(const std::string& shader, const std::string& method,
               const std::vector<std::string>& arguments = {}) const {
    folder_.write("mine.frag", shader);
    const ProgramResult result = run(kBall + method, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json_of();
  }
  Json json_of() const { return json("out/results.json"); }
  Image exitance(const std::string& label) const {
    return read_rgb(folder_.path() / "out" / "maps" / ("front.spike-and-base." + label + ".exr"));
  }
  Image irradiance() const {
    return read_rgb(folder_.path() / "out" / "maps" / "front.spike-and-base.truth.exr", "irradiance");
  }
};

// The sums have the same terms in the same order but for one multiplication; blur2d's manual gives 2e-6 of
// the largest light, 1, for its rounding, and each of the two may take that.
TEST_F(OwnShader, EqualsTheBuiltInMethodThatItImitates) {
  const Json found = results(kBlur, "[[method]]\nname = \"blur2d\"\n" + kMine);
  EXPECT_LE(largest_difference(exitance("mine"), exitance("blur2d")), 4e-6);
  EXPECT_GT(largest_difference(exitance("mine"), exitance("none")), 0.1);
  const Json& mine = run_of(found, "mine");
  EXPECT_EQ(mine["settings"], Json({{"reach", 4.0}}));
  EXPECT_EQ(mine["cost"]["passes"], run_of(found, "blur2d")["cost"]["passes"]);
  EXPECT_EQ(mine["own_target"]["truth"], mine["truth"]);
  EXPECT_EQ(mine["own_target"]["metrics"]["rmse"], mine["metrics"]["rmse"]);
}

// blur2d reads the center once a pass and the shader above twice: a texel of 16 bytes more, for each of the
// picture's 1600 pixels, six passes of three Gaussians and two axes.
TEST_F(OwnShader, ItsReadsAreCounted) {
  const Json found = results(kBlur, "[[method]]\nname = \"blur2d\"\n" + kMine);
  const double skin = found["views"][0]["skin_pixels"];
  const double more = 6.0 * 1600.0 / skin;
  const Json& mine = run_of(found, "mine")["cost"];
  const Json& built_in = run_of(found, "blur2d")["cost"];
  EXPECT_NEAR(mine["fetches_per_pixel"].get<double>(), built_in["fetches_per_pixel"].get<double>() + more,
              1e-9);
  EXPECT_NEAR(mine["bytes_per_pixel"].get<double>(), built_in["bytes_per_pixel"].get<double>() + 16.0 * more,
              1e-6);
}

TEST_F(OwnShader, ASettingCanBeOverridden) {
  results(kBlur, kMine, {"--set", "method.mine.settings.reach=0"});
  const Image mine = exitance("mine");
  // Without taps each Gaussian is the identity, and the weights sum to 1.
  EXPECT_LE(largest_difference(mine, exitance("none")), 1e-6);
  EXPECT_EQ(run_of(json_of(), "mine")["settings"]["reach"], 0.0);
}

// Table 1 of Mikkelsen 2010: red has 0.15 in the spike and 0.85 in a Gaussian of 2.3 mm^2, and so on; where
// light is replaced by the standard deviation, exitance is w_0 I + w s.
TEST_F(OwnShader, TermsHaveAWidthForEachChannel) {
  results("uniform vec3 std_dev_mm;\nvoid main() { result = vec4(std_dev_mm, 1.0); }\n", R"(
[[method]]
name = "mine"
run = "per-term"
[[method.pass]]
shader = "mine.frag"
)");
  const Vec3d spike(0.15, 0.18, 0.20);
  const Vec3d variance_mm2(2.3, 1.4, 1.1);
  const Vec3d expected = (Vec3d::Ones() - spike).cwiseProduct(variance_mm2.cwiseSqrt()) +
                         spike.cwiseProduct(irradiance().rgb(20, 20));
  EXPECT_LE((exitance("mine").rgb(20, 20) - expected).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_F(OwnShader, OncePassesGetTheWholeProfile) {
  results(R"(SAMPLER(irradiance);
SAMPLER(mask);
uniform vec3 delta_weight;
uniform float gaussian_std_dev_mm[GAUSSIANS];
uniform vec3 gaussian_weight[GAUSSIANS];
uniform float profile_r_max_mm;
void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec3 sum = delta_weight * read_texel(irradiance, p).rgb;
  for (int i = 0; i < GAUSSIANS; ++i) sum += gaussian_weight[i] * gaussian_std_dev_mm[i];
  result = vec4(read_texel(mask, p).r * sum + profile_r_max_mm, 1.0);
}
)",
          with(kOnePass, R"(["irradiance"])", R"(["irradiance", "mask"])"));
  const Vec3d spike(0.15, 0.18, 0.20);
  const Vec3d gaussians = (Vec3d::Ones() - spike).cwiseProduct(Vec3d(2.3, 1.4, 1.1).cwiseSqrt());
  const Vec3d expected = spike.cwiseProduct(irradiance().rgb(20, 20)) + gaussians + Vec3d::Constant(4.5);
  EXPECT_LE((exitance("mine").rgb(20, 20) - expected).cwiseAbs().maxCoeff(), 2e-6);
  EXPECT_LE((exitance("mine").rgb(0, 0) - Vec3d::Constant(4.5)).cwiseAbs().maxCoeff(), 1e-6);
}

// Every input holds what its name says: depth is -z of the position, the ball's middle is nearest, at 92 mm,
// where both normals look at the viewer, and a length of 1 mm there is focal_px / 92 pixels.
TEST_F(OwnShader, InputsHoldWhatTheirNamesSay) {
  results(R"(SAMPLER(position);
SAMPLER(depth);
SAMPLER(normal);
SAMPLER(face_normal);
void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  float same = abs(read_texel(depth, p).r + read_texel(position, p).z);
  vec3 between = read_texel(normal, p).xyz - read_texel(face_normal, p).xyz;
  result = vec4(read_texel(depth, p).r, read_texel(normal, p).z, same + length(between), 1.0);
}
)",
          with(kOnePass, R"(["irradiance"])", R"(["position", "depth", "normal", "face_normal"])"));
  const Vec3d middle = exitance("mine").rgb(20, 20);
  EXPECT_GT(middle.x(), 92.0 - 1e-3);
  EXPECT_LT(middle.x(), 92.3);  // facets of 2 mm lie some 2^2 / (8 * 8) mm below the ball
  EXPECT_GT(middle.y(), 0.99);
  EXPECT_LT(middle.z(), 0.3);  // a facet's normal is off by an edge over the radius at most
}

TEST_F(OwnShader, IncludedFilesGoBeforeTheShader) {
  folder_.write("half.glsl", "float half_of(float x) { return 0.5 * x; }\n");
  results(R"(SAMPLER(position);
SAMPLER(normal);
void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  float extent = disc_half_extent(read_texel(position, p).xyz, read_texel(normal, p).xyz, 0, 1.0);
  result = vec4(half_of(extent), extent, 0.0, 1.0);
}
)",
          with(with(kOnePass, R"(["irradiance"])", R"(["position", "normal"])"), "run",
               "include = [\"builtin:filter_geometry.glsl\", \"half.glsl\"]\nrun") +
              "[method.target]\nr_max_mm = 1.0\n");
  const Vec3d middle = exitance("mine").rgb(20, 20);
  EXPECT_FLOAT_EQ(static_cast<float>(middle.x()), 0.5F * static_cast<float>(middle.y()));
}

TEST_F(OwnShader, TheResolvedExperimentRepeatsTheRun) {
  results(kBlur, kMine);
  const Image first = exitance("mine");
  const ProgramResult again = truescatter({"run", "out/experiment.resolved.toml", "--out", "again"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Image second = read_rgb(folder_.path() / "again" / "maps" / "front.spike-and-base.mine.exr");
  EXPECT_EQ(largest_difference(first, second), 0.0);
}

class OwnShaderErrors : public CliErrorsBeforeComputing {
 protected:
  void expect_refused_shader(const std::string& shader, const std::string& method,
                             const std::vector<std::string>& pieces,
                             const std::vector<std::string>& arguments = {}) const {
    folder_.write("mine.frag", shader);
    expect_refused(run(kBall + method, arguments), pieces);
  }
};

const std::string kPlain =
    "SAMPLER(irradiance);\nvoid main() {\n  result = read_texel(irradiance, ivec2(gl_FragCoord.xy));\n}\n";

TEST_F(OwnShaderErrors, TheCompilersMessageNamesFileAndLine) {
  expect_refused_shader(
      with(kPlain, "result = ", "result = banana + "), kOnePass,
      {"mine.frag:3: this shader does not compile:\n", "mine.frag:3: error: `banana' undeclared"});
  expect_refused_shader("#include \"x\"\n" + kPlain, kOnePass, {"mine.frag:1"});
  folder_.write("part.glsl", "float f() { return 1.0 }\n");
  expect_refused_shader(kPlain, with(kOnePass, "run", "include = [\"part.glsl\"]\nrun"), {"part.glsl:1:"});
}

TEST_F(OwnShaderErrors, WhatIsDeclaredButNotUsed) {
  expect_refused_shader(kPlain, with(kOnePass, R"("irradiance"])", R"("irradiance", "depth"])"),
                        {"e.toml:28:10: the input 'depth' is not used by ", "mine.frag"});
  expect_refused_shader(
      kPlain, with(kOnePass, "run", "settings.width = 1\nrun"),
      {"e.toml:25:18: method 'mine': the setting 'width' is no uniform that one of its shaders uses"});
  expect_refused_shader(kPlain, kOnePass + "settings.width = 1\n",
                        {"e.toml:29:18: the setting 'width' is no uniform that ", "mine.frag uses"});
  expect_refused_shader(kPlain, kOnePass,
                        {"--set method.mine.settings.width=2: method 'mine': the setting 'width'"},
                        {"--set", "method.mine.settings.width=2"});
}

TEST_F(OwnShaderErrors, AnInputThatItsPassDoesNotHave) {
  expect_refused_shader(with(kPlain, "irradiance, ivec2", "position, ivec2"), kOnePass, {"mine.frag:3:"});
  expect_refused_shader(
      "SAMPLER(position);\nvoid main() { result = read_texel(position, ivec2(0)); }\n", kOnePass,
      {"mine.frag: reads 'position', which is not among the inputs of its pass (irradiance)"});
  expect_refused_shader(kPlain, with(kOnePass, R"(["irradiance"])", R"(["irradience"])"),
                        {"e.toml:28:10: there is no input 'irradience'; there are: position, "});
  expect_refused_shader(kPlain, with(kOnePass, R"(["irradiance"])", R"(["irradiance", "irradiance"])"),
                        {"e.toml:28:10: 'method.pass.inputs' names 'irradiance' twice"});
}

TEST_F(OwnShaderErrors, UniformsThatNothingSetsOrOfAnotherType) {
  const auto scaled = [](const std::string& declaration, const std::string& factor) {
    return declaration + with(kPlain, "result = ", "result = " + factor + " * ");
  };
  expect_refused_shader(scaled("uniform float width;\n", "width"), kOnePass,
                        {"mine.frag: nothing sets the uniform 'width': give it by 'settings.width'"});
  expect_refused_shader(scaled("uniform int focal_px;\n", "float(focal_px)"), kOnePass,
                        {"mine.frag: the uniform 'focal_px' must be a float where run = \"once\""});
  expect_refused_shader(scaled("uniform vec3 std_dev_mm;\n", "std_dev_mm.x"),
                        with(kOnePass, "\"once\"", "\"per-gaussian\""),
                        {"mine.frag: the uniform 'std_dev_mm' must be a float where run = \"per-gaussian\""});
  const std::string width = kOnePass + "settings.width = 1.5\n";
  expect_refused_shader(
      scaled("uniform int width;\n", "float(width)"), width,
      {"e.toml:29:18: 'width' is 1.5; ", "declares it as an int, so it must be a whole number"});
  expect_refused_shader(scaled("uniform vec2 width;\n", "width.x"), width,
                        {"mine.frag: the uniform 'width' is a setting: a float or an int"});
  expect_refused_shader(kPlain, kOnePass + "settings.focal_px = 1\n",
                        {"e.toml:29:21: 'focal_px' is not for a setting: every shader is given it"});
  expect_refused_shader(scaled("uniform float width;\n", "width"),
                        with(width, "run", "settings.width = 2\nrun"),
                        {"e.toml:30:18: 'width' is a setting of the whole method too"});
  expect_refused_shader(kPlain, with(kOnePass, "run", "settings.width = \"wide\"\nrun"),
                        {"e.toml:25:18: 'method.settings.width' must be a number: it is a uniform"});
}

TEST_F(OwnShaderErrors, ReadsThatWouldNotBeCounted) {
  expect_refused_shader(with(kPlain, "read_texel(irradiance, ivec2(gl_FragCoord.xy))",
                             "/* texture() \n */ texelFetch(irradiance, ivec2(0), 0)"),
                        kOnePass, {"mine.frag:4:5: a read by texelFetch() would be missing"});
  expect_refused_shader("vec4 f(sampler2D s) { return vec4(1.0); }\n" + kPlain, kOnePass,
                        {"mine.frag:1:8: 'sampler2D': an input is declared by SAMPLER(name);"});
}

TEST_F(OwnShaderErrors, AShaderWithoutMainOrWithoutAFile) {
  expect_refused_shader("// void main() {}\n", kOnePass, {"mine.frag: this shader has no main()"});
  expect_refused_shader(kPlain, with(kOnePass, "mine.frag", "yours.frag"),
                        {"e.toml:27:10: no such file: ", "yours.frag"});
  expect_refused_shader(kPlain, with(kOnePass, "run", "include = [\"builtin:x.glsl\"]\nrun"),
                        {"e.toml:25:11: there is no builtin:x.glsl; there are: filter_geometry.glsl"});
}

TEST_F(OwnShaderErrors, KeysAndNames) {
  expect_refused_shader(
      kPlain, with(kOnePass, "\"mine\"", "\"blur2d\""),
      {"e.toml:24:8: 'blur2d' is a built-in method: a method of your own needs another name"});
  expect_refused_shader(kPlain, with(kOnePass, "\"mine\"", "\"my own\""),
                        {"e.toml:24:8: 'method.name' names files"});
  expect_refused_shader(kPlain, with(kOnePass, "once", "twice"), {"e.toml:25:7: 'method.run' is \"twice\""});
  expect_refused_shader(kPlain, with(kOnePass, "inputs", "input"),
                        {"e.toml:28:9: unknown key 'method.pass.input'"});
  expect_refused_shader(kPlain, with(kOnePass, "shader = \"mine.frag\"\n", ""),
                        {"'method.pass.shader' is missing"});
  expect_refused_shader(kPlain, with(kOnePass, "run", "layer = \"x\"\nrun"),
                        {"e.toml:25:9: unknown key 'method.layer'"});
  expect_refused_shader(kPlain, with(kOnePass, "run", "image = \"a.exr\"\nrun"),
                        {"e.toml:25:9: a method is a picture ('image') or GLSL ('pass'), not both"});
  expect_refused_shader(kPlain, kOnePass + "[method.target]\nmetric = \"manhattan\"\n",
                        {"e.toml:30:10: 'method.target.metric' is \"manhattan\""});
  expect_refused_shader(kPlain, kOnePass + "[method.target]\nmetric = \"geodesic\"\nvisible_only = true\n",
                        {"e.toml:31:16: 'method.target.visible_only' is for the Euclidean metric"});
  expect_refused_shader(kPlain, kOnePass + "[method.target]\nvisible_only = true\ntransmittance = true\n",
                        {"e.toml:31:17: 'method.target.transmittance' comes from what the view does not see: "
                         "not with visible_only"});
}

// What shows only in the picture: nothing is written either.
TEST_F(CliErrors, AShaderThatGivesNoNumber) {
  folder_.write("mine.frag", with(kPlain, "result = ", "result = sqrt(-1.0 - gl_FragCoord.x) * "));
  expect_refused(run(kBall + kOnePass), {"method 'mine': its exitance at column ", "is not finite"});
}

// Of methods of one's own every pass, of built-in ones what they name. A pass that is drawn once gives what
// it draws.
TEST_F(OwnShader, PassesAreExportedAsTheyAreDrawn) {
  folder_.write("mine.frag", kPlain);
  const std::string methods = kOnePass + "[[method]]\nname = \"pscbf\"\n";
  const ProgramResult result = run(kBall + methods, {"--export-passes"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json results = json_of();
  EXPECT_EQ(run_of(results, "none")["files"]["passes"], Json::array());
  const Json& passes = run_of(results, "mine")["files"]["passes"];
  ASSERT_EQ(passes.size(), 1U);
  EXPECT_EQ(passes[0]["name"], "pass-1");
  EXPECT_EQ(passes[0]["channels"], "RGB");
  EXPECT_EQ(passes[0]["exr"], "passes/front.spike-and-base.mine.pass-1.exr");
  // White is the brightest irradiance, as in all pictures of a run.
  EXPECT_NEAR(passes[0]["white"].get<double>(), results["scene"]["largest_irradiance"].get<double>(), 1e-12);
  const std::filesystem::path out = folder_.path() / "out";
  EXPECT_EQ(largest_difference(read_rgb(out / passes[0]["exr"].get<std::string>()), exitance("mine")), 0.0);
  EXPECT_EQ(text("out/" + passes[0]["png"].get<std::string>()),
            text("out/maps/front.spike-and-base.mine.png"));

  // Its geometry, the profile's spike and one level: w_0 I + w_1 level is the method's picture.
  const Json& levels = run_of(results, "pscbf")["files"]["passes"];
  ASSERT_EQ(levels.size(), 3U);
  EXPECT_EQ(levels[0]["name"], "extent");
  EXPECT_EQ(levels[1]["name"], "scale");
  EXPECT_EQ(levels[2]["name"], "level");
  const Image level = read_rgb(out / levels[2]["exr"].get<std::string>());
  const Image plain = exitance("none");
  const Image blurred = exitance("pscbf");
  const Json& profile = results["profiles"][0];
  for (int y = 0; y < level.height(); ++y) {
    for (int x = 0; x < level.width(); ++x) {
      if (plain.rgb(x, y).isZero()) continue;
      for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<std::size_t>(c);
        EXPECT_NEAR(profile["delta_weight"][i].get<double>() * plain.at(x, y, c) +
                        profile["gaussians"][0]["weight"][i].get<double>() * level.at(x, y, c),
                    blurred.at(x, y, c), 1e-6);
      }
    }
  }
  // A run without them takes the place of one with them.
  ASSERT_EQ(run(kBall + methods).exit_code, 0);
  EXPECT_FALSE(exists("out/passes"));
  EXPECT_FALSE(run_of(json_of(), "mine")["files"].contains("passes"));
}

class OwnPicture : public OwnShader {};

const std::string kPicture = R"(
[[method]]
name = "elsewhere"
image = "inputs/{view}.exr"
layer = "irradiance"
)";

TEST_F(OwnPicture, WhatIsExportedReadsBackAsNoScattering) {
  ProgramResult result = run(kBall + kPicture, {"--export-inputs"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(run_of(json_of(), "elsewhere")["skipped"], "its picture is not there yet: "));
  std::filesystem::copy(folder_.path() / "out" / "inputs", folder_.path() / "inputs");

  result = run(kBall + kPicture);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(exists("out/inputs"));
  EXPECT_EQ(largest_difference(exitance("elsewhere"), exitance("none")), 0.0);
  const Json results = json_of();
  const Json& none = run_of(results, "none");
  const Json& picture = run_of(results, "elsewhere");
  EXPECT_EQ(picture["metrics"], none["metrics"]);
  EXPECT_GT(picture["metrics"]["rmse"].get<double>(), 0.0);
  EXPECT_EQ(picture["own_target"], none["own_target"]);
  EXPECT_TRUE(picture["cost"].is_null());
  EXPECT_EQ(picture["cost_reason"], "a picture made elsewhere: nothing of it ran here");
  EXPECT_TRUE(contains(text("out/results.csv"), "front,spike-and-base,elsewhere,elsewhere,,"));
}

// The camera's convention: x = (column + 1/2 - width / 2) depth / focal_px, y = (height / 2 - row - 1/2)
// depth / focal_px.
TEST_F(OwnPicture, ExportedInputsAgreeWithTheirCamera) {
  const ProgramResult result = run(kBall, {"--export-inputs"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::filesystem::path file = folder_.path() / "out" / "inputs" / "front.exr";
  const Json camera = json("out/inputs/front.json");
  const double focal_px = camera["focal_px"];
  // Half the picture's height over the tangent of half the field of view.
  EXPECT_NEAR(focal_px, 20.0 / std::tan(5.5 * 3.14159265358979 / 180.0), 1e-9);
  EXPECT_EQ(json_of()["views"][0]["files"]["inputs"], "inputs/front.exr");
  const Image position = read_rgb(file, "position");
  const Image normal = read_rgb(file, "normal");
  const Image face_normal = read_rgb(file, "face_normal");
  const Image mask = read_exr_layer(file, "mask");
  const Image depth = read_exr_layer(file, "depth");
  int seen = 0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      if (mask.at(x, y, 0) == 0.0F) {
        EXPECT_EQ(position.rgb(x, y), Vec3d::Zero());
        continue;
      }
      ++seen;
      const double z_mm = depth.at(x, y, 0);
      const Vec3d expected((x + 0.5 - 20.0) * z_mm / focal_px, (20.0 - y - 0.5) * z_mm / focal_px, -z_mm);
      // Single precision of some 100 mm: 1e-5 mm, through a few operations.
      EXPECT_LE((position.rgb(x, y) - expected).norm(), 2e-4);
      EXPECT_NEAR(normal.rgb(x, y).norm(), 1.0, 1e-5);
      EXPECT_NEAR(face_normal.rgb(x, y).norm(), 1.0, 1e-5);
      // The ball's normal is its radius, but for the facets: an edge over the radius.
      EXPECT_GT(normal.rgb(x, y).dot((position.rgb(x, y) - Vec3d(0.0, 0.0, -100.0)).normalized()), 0.95);
    }
  }
  EXPECT_GT(seen, 400);
  EXPECT_EQ(static_cast<std::size_t>(seen), json_of()["views"][0]["skin_pixels"].get<std::size_t>());
}

// A folder with inputs is one that `run` may replace; one with anything else in inputs/ is not.
TEST_F(OwnPicture, AResultWithInputsCanBeReplaced) {
  ASSERT_EQ(run(kBall, {"--export-inputs"}).exit_code, 0);
  EXPECT_EQ(run(kBall).exit_code, 0);
  EXPECT_FALSE(exists("out/inputs"));
  ASSERT_EQ(run(kBall, {"--export-inputs"}).exit_code, 0);
  folder_.write("out/inputs/notes.txt", "mine");
  EXPECT_EQ(run(kBall).exit_code, 2);
  EXPECT_TRUE(exists("out/inputs/notes.txt"));
}

// The shipped example, step by step as its head says. Its renderer's formula, by a second route: sum over
// skin of g I over that of g, g = exp(-r^2 / 2 v), in the square of 4 s around the pixel. Its pictures are of
// single precision.
TEST_F(OwnPicture, TheShippedExampleIsReproduced) {
  if (std::system("python3 -c ''") != 0) GTEST_SKIP() << "needs python3";
  const std::filesystem::path source = TRUESCATTER_SOURCE_DIR;
  std::filesystem::create_directory(folder_.path() / "experiments");
  std::filesystem::copy(source / "experiments" / "own-image.toml", folder_.path() / "experiments");
  const std::vector<std::string> arguments = {"run", "experiments/own-image.toml", "--out", "out"};
  std::vector<std::string> exporting = arguments;
  exporting.emplace_back("--export-inputs");
  ASSERT_EQ(truescatter(exporting).exit_code, 0);
  const std::string script = (source / "scripts" / "own-image-example").string();
  const ProgramResult made =
      run_program("/usr/bin/env", {"python3", script, "out", "runs/own-image-pictures"}, folder_.path());
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Image position = read_rgb(folder_.path() / "out" / "inputs" / "front.exr", "position");
  const Image light = read_rgb(folder_.path() / "out" / "inputs" / "front.exr", "irradiance");
  const Image mask = read_exr_layer(folder_.path() / "out" / "inputs" / "front.exr", "mask");
  const double focal_px = json("out/inputs/front.json")["focal_px"];

  const ProgramResult result = truescatter(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Image picture = exitance("straight-distances");
  const double variance_mm2 = 2.3;  // red's
  for (int y = 8; y < 48; y += 7) {
    for (int x = 8; x < 48; x += 7) {
      if (mask.at(x, y, 0) == 0.0F) continue;
      const double reach = std::ceil(4.0 * std::sqrt(variance_mm2) * focal_px / -position.rgb(x, y).z());
      double sum = 0.0;
      double mass = 0.0;
      for (int v = 0; v < 48; ++v) {
        for (int u = 0; u < 48; ++u) {
          if (mask.at(u, v, 0) == 0.0F || std::abs(u - x) > reach || std::abs(v - y) > reach) continue;
          const double g =
              std::exp(-0.5 * (position.rgb(u, v) - position.rgb(x, y)).squaredNorm() / variance_mm2);
          sum += g * light.rgb(u, v).x();
          mass += g;
        }
      }
      EXPECT_NEAR(picture.rgb(x, y).x(), 0.15 * light.rgb(x, y).x() + 0.85 * sum / mass, 1e-6);
    }
  }
}

TEST_F(OwnShader, TheShippedStarterCompiles) {
  const std::filesystem::path file =
      std::filesystem::path(TRUESCATTER_SOURCE_DIR) / "experiments" / "own-shader.toml";
  const ProgramResult result = truescatter({"run", file.string(), "--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.out, "method masked-blur: Masked Gaussian (width = 1)")) << result.out;
}

class OwnPictureErrors : public CliErrorsBeforeComputing {
 protected:
  void write(const std::string& name, const Image& image, const std::string& layer = "") const {
    write_exr(folder_.path() / name, {{layer, &image}});
  }
};

const std::string kFile = "\n[[method]]\nname = \"elsewhere\"\nimage = \"a.exr\"\n";

TEST_F(OwnPictureErrors, ThePicture) {
  expect_refused(run(kBall + kFile), {"e.toml:25:9: no such file: ",
                                      "a.exr; what it can be made from is written by "
                                      "run --export-inputs"});
  write("a.exr", Image(40, 39, 3));
  expect_refused(run(kBall + kFile),
                 {"a.exr: is 40 x 39 pixels, but view 'front' is 40 x 40; they must agree"});
  write("a.exr", Image(40, 40, 1));
  expect_refused(run(kBall + kFile), {"a.exr: has 1 plain channels; R, G, B are needed"});
  write("a.exr", Image(40, 40, 3, std::nanf("")));
  expect_refused(run(kBall + kFile), {"a.exr: holds a value that is not finite"});
  write("a.exr", Image(40, 40, 3));
  expect_refused(run(kBall + kFile + "layer = \"light\"\n"),
                 {"a.exr: no layer 'light'; the file's channels are R, G, B"});
  folder_.write("a.exr", "not a picture");
  expect_refused(run(kBall + kFile), {"a.exr: cannot read this image"});
}

TEST_F(OwnPictureErrors, ThePath) {
  write("a.exr", Image(40, 40, 3));
  const std::string second = R"(
[[view]]
name = "side"
eye_mm = [100.0, 0.0, 0.0]
width_px = 40
height_px = 40
)";
  expect_refused(run(kBall + second + kFile),
                 {"e.toml:31:9: 'method.image' needs {view} in it: there are 2 views"});
  expect_refused(run(kBall + with(kFile, "a.exr", "{vew}.exr")),
                 {"e.toml:25:9: 'method.image' has a '{' that is none of {view}, {profile} and ${VARIABLE}"});
  expect_refused(run(kBall + with(kFile, "a.exr", "")), {"e.toml:25:9: 'method.image' must not be empty"});
  expect_refused(run(kBall + kFile + "settings.width = 1\n"),
                 {"'method.settings' is for GLSL and built-in methods"});
  expect_refused(run(kBall + kFile + "run = \"once\"\n"), {"e.toml:26:7: unknown key 'method.run'"});
}

}  // namespace
}  // namespace truescatter::test
