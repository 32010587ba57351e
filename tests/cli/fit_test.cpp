// `truescatter fit` as a user types it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/file.h"
#include "support/run_program.h"
#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

using nlohmann::json;

class CliFit : public testing::Test {
 protected:
  ProgramResult fit(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "fit");
    return run_program(TRUESCATTER_BINARY, arguments, folder_.path());
  }
  json fitted(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--out", "fit.json"});
    const ProgramResult result = fit(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(text("fit.json"));
  }
  std::string text(const std::string& name) { return read_text_file(folder_.path() / name); }

  TempDir folder_;
};

// By the formulas that the file states, from nothing but the file: the curve's fit is the sum of its
// Gaussians (to the nine or more digits of a JSON's doubles), albedos are sums of weights.
TEST_F(CliFit, WritesAFileThatHoldsTogether) {
  const json file = fitted({"--profile", "dipole", "--material", "skin1", "--gaussians", "4"});
  const auto variances = file["variances"].get<std::vector<double>>();
  ASSERT_EQ(variances.size(), 4u);
  EXPECT_TRUE(std::is_sorted(variances.begin(), variances.end()));
  ASSERT_EQ(file["weights"].size(), 4u);
  for (std::size_t c = 0; c < 3; ++c) {
    double total = 0.0;
    for (const json& weight : file["weights"]) total += weight[c].get<double>();
    EXPECT_NEAR(file["albedo"]["fit"][c].get<double>(), total, 1e-14);
    const auto& curve = file["curve"];
    for (std::size_t i = 0; i < curve["r_mm"].size(); ++i) {
      const double r = curve["r_mm"][i];
      double sum = 0.0;
      for (std::size_t j = 0; j < 4; ++j)
        sum += file["weights"][j][c].get<double>() * std::exp(-0.5 * r * r / variances[j]) /
               (2.0 * M_PI * variances[j]);
      EXPECT_NEAR(curve["fit"][i][c].get<double>(), sum, 1e-14);
    }
    for (const char* norm : {"r", "area", "r2"}) {
      EXPECT_GT(file["error"][norm][c].get<double>(), 0.0);
      EXPECT_LT(file["error"][norm][c].get<double>(), 0.1);
    }
  }
  // Jensen et al. 2001's skin1 under the classical dipole, to the four digits that are known.
  const double known[] = {.4360, .2273, .1310};
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(file["albedo"]["profile"][c].get<double>(), known[c], 0.5e-4);
  EXPECT_EQ(file["asked"]["profile"], "classical-dipole");
  EXPECT_EQ(file["asked"]["material"], "skin1");
  EXPECT_EQ(file["asked"]["gaussians"], 4);
  EXPECT_EQ(file["asked"]["norm"], "r");
}

TEST_F(CliFit, TakesEveryProfile) {
  folder_.write(
      "t.csv",
      "r_mm,r,g,b\n0.1,1,0.9,0.8\n0.3,0.5,0.4,0.3\n0.7,0.2,0.15,0.1\n1.5,0.05,0.03,0.02\n3,0.01,0.004,0.001\n"
      "6,0.001,0.0003,0.0001\n");
  folder_.write(
      "layers.csv",
      "thickness_mm,sigma_a_r,sigma_a_g,sigma_a_b,sigma_s_prime_r,sigma_s_prime_g,sigma_s_prime_b,eta\n"
      "0.25,2.1,2.1,5.0,48,60,65,1.4\n0.2,0.16,0.19,0.30,32,40,46,1.34\n0,0.085,1,25,4.5,4.7,4.8,1.4\n");
  const std::vector<std::vector<std::string>> profiles = {
      {"better-dipole", "--material", "skin2"},
      {"dipole", "--sigma-a", "0.03,0.2,0.5", "--sigma-s-prime", "1", "--eta", "1.4"},
      {"multipole", "--material", "skin1", "--thickness", "3"},
      {"multipole", "--material", "skin-three-layer"},
      {"multipole", "--layers", "layers.csv"},
      {"burley", "--material", "marble", "--scaling", "diffuse"},
      {"table", "--table", "t.csv"}};
  json layered;
  for (std::vector<std::string> arguments : profiles) {
    arguments.insert(arguments.begin(), "--profile");
    arguments.insert(arguments.end(), {"--gaussians", "2"});
    const json file = fitted(arguments);
    EXPECT_EQ(file["variances"].size(), 2u) << arguments[1];
    EXPECT_EQ(file["error"]["r"][0].is_null(), arguments[1] == "burley");
    EXPECT_EQ(file.contains("error_note"), arguments[1] == "burley");
    if (arguments[3] == "skin-three-layer") layered = file["variances"];
    // The built-in stack, spelled out.
    if (arguments[3] == "layers.csv") {
      EXPECT_EQ(file["variances"], layered);
    }
  }
}

TEST_F(CliFit, FindsTheFewestWithinATolerance) {
  const std::vector<std::string> skin = {"--profile", "dipole", "--material", "skin1", "--norm", "area"};
  std::vector<std::string> few = skin;
  few.insert(few.end(), {"--gaussians", "auto", "--tolerance", "0.05"});
  const json file = fitted(few);
  const std::size_t count = file["variances"].size();
  const auto worst = [](const json& f) {
    const auto errors = f["error"]["area"].get<std::vector<double>>();
    return *std::max_element(errors.begin(), errors.end());
  };
  EXPECT_LE(worst(file), 0.05);
  std::vector<std::string> fewer = skin;
  fewer.insert(fewer.end(), {"--gaussians", std::to_string(count - 1)});
  EXPECT_GT(worst(fitted(fewer)), 0.05);
}

TEST_F(CliFit, WritesSnippetsAndAPlot) {
  const ProgramResult result =
      fit({"--profile", "dipole", "--material", "skin2", "--gaussians", "3", "--energy", "albedo", "--out",
           "f.json", "--glsl", "f.glsl", "--cpp", "f.h", "--svg", "f.svg"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("relative error, %"), std::string::npos);
  EXPECT_NE(text("f.glsl").find("const vec3 weight[3] = vec3[3]("), std::string::npos);
  EXPECT_TRUE(text("f.svg").starts_with("<svg "));
  // The C++ array is a program's: its weights sum to the albedo in single precision.
  folder_.write(
      "main.cpp",
      "#include \"f.h\"\nint main() { float s = 0; for (const Gaussian& g : gaussians) s += g.weight[0];\n"
      "return s > 0.6225f && s < 0.6227f ? 0 : 1; }\n");
  const ProgramResult compiled = run_program(
      "/usr/bin/c++", {"-std=c++17", "-Wall", "-Werror", "main.cpp", "-o", "main"}, folder_.path());
  ASSERT_EQ(compiled.exit_code, 0) << compiled.err;
  EXPECT_EQ(run_program((folder_.path() / "main").string(), {}, folder_.path()).exit_code, 0);
}

// Fitted, then scored from its own file: the same errors.
TEST_F(CliFit, ScoresAFileAsItWasFitted) {
  const json file = fitted({"--profile", "dipole", "--material", "skin1", "--gaussians", "3"});
  const ProgramResult result =
      fit({"--profile", "dipole", "--material", "skin1", "--score", "fit.json", "--out", "score.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json scored = json::parse(text("score.json"));
  for (const char* norm : {"r", "area", "r2"})
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(scored["error"][norm][c].get<double>(), file["error"][norm][c].get<double>(), 1e-12);
}

// d'Eon & Luebke 2007's marble errs by 1.54 % (as measured elsewhere, to the digits given); ours by less.
TEST_F(CliFit, BeatsThePublishedMarble) {
  const std::vector<std::string> marble = {"--profile", "dipole", "--material", "marble"};
  std::vector<std::string> score = marble;
  score.insert(score.end(), {"--score", "marble-green-four-gaussian"});
  const json published = fitted(score);
  EXPECT_NEAR(published["error"]["r"][1].get<double>(), 0.0154, 0.5e-4);
  EXPECT_TRUE(published["error"]["r"][0].is_null());  // green alone is published
  std::vector<std::string> four = marble;
  four.insert(four.end(), {"--gaussians", "4"});
  EXPECT_LT(fitted(four)["error"]["r"][1].get<double>(), 0.0154);
}

// A slab that hardly absorbs has more images than can be summed, and a closed form.
TEST_F(CliFit, TakesASlabThatDoesNotAbsorb) {
  const json file = fitted({"--profile", "multipole", "--sigma-a", "0", "--sigma-s-prime", "1", "--eta",
                            "1.3", "--thickness", "3", "--gaussians", "3"});
  EXPECT_LT(file["error"]["r"][0].get<double>(), 0.05);
}

// What cannot be written last takes back what was written first.
TEST_F(CliFit, WritesAllOfItsFilesOrNone) {
  const ProgramResult result = fit({"--profile", "dipole", "--material", "skin1", "--gaussians", "2", "--out",
                                    "f.json", "--svg", "/proc/no.svg"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "f.json"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(CliFit, RefusesWhatIsBrokenAndWritesNothing) {
  folder_.write("nan.csv", "r_mm,r,g,b\n0,1,1,1\n1,nan,1,1\n");
  folder_.write("unsorted.csv", "r_mm,r,g,b\n0,1,1,1\n2,0.5,0.5,0.5\n1,0.1,0.1,0.1\n");
  folder_.write("short.csv", "r_mm,r,g,b\n0.1,1,1,1\n0.5,0.5,0.5,0.5\n1,0.1,0.1,0.1\n");
  folder_.write("tiny.csv", "r_mm,r,g,b\n0.1,1e-200,1,1\n0.5,0,0.5,0.5\n1,0,0.1,0.1\n");
  const std::vector<std::string> skin = {"--profile", "dipole", "--material", "skin1"};
  const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const std::vector<std::string> medium = {"--profile", "dipole", "--gaussians", "3"};
  const std::vector<std::pair<std::vector<std::string>, std::string>> table = {
      {with(medium, {"--sigma-a", "-0.1,0.1,0.1", "--sigma-s-prime", "1,1,1", "--eta", "1.3"}),
       "--sigma-a: \"-0.1,0.1,0.1\": an absorption must not be negative"},
      {with(medium, {"--sigma-a", "0.1,0.1", "--sigma-s-prime", "1,1,1", "--eta", "1.3"}),
       "--sigma-a: \"0.1,0.1\": an absorption in 1/mm needs one number, or three as R,G,B"},
      {with(medium, {"--sigma-a", "0.1", "--sigma-s-prime", "1,1,1", "--eta", "0.9"}),
       "--eta: 0.9: an index of refraction must be above 1"},
      {with(medium, {"--sigma-a", "0.1", "--sigma-s-prime", "1,1,1"}), "--eta: is missing"},
      {with(medium, {"--material", "chalk"}), "--material: there is no material 'chalk'; there are: marble"},
      {with(medium, {"--material", "skin1", "--eta", "1.3"}), "--eta: \"1.3\": is the material's"},
      {with(skin, {"--gaussians", "0"}), "--gaussians: 0 is out of range: 1 to 16, or auto"},
      {with(skin, {"--gaussians", "many"}), "--gaussians: \"many\""},
      {with(skin, {"--gaussians", "auto"}), "--tolerance: is missing"},
      {with(skin, {"--gaussians", "3", "--tolerance", "0.1"}), "--tolerance: \"0.1\": goes with"},
      {with(skin, {"--gaussians", "auto", "--tolerance", "1e-30", "--max-variance", "1"}),
       "--tolerance: a tolerance of 1e-30 in the norm r is out of reach"},
      {with(skin, {"--gaussians", "3", "--norm", "r3"}),
       "--norm: \"r3\" is not known; there are: r, area, r2"},
      {with(skin, {"--gaussians", "3", "--thickness", "2"}),
       "--thickness: \"2\": goes with --profile multipole"},
      {{"--profile", "multipole", "--material", "skin1", "--thickness", "0.5", "--gaussians", "2"},
       "--profile: the slab is 0.5 mm thick: diffusion theory has no valid answer"},
      {{"--profile", "multipole", "--material", "skin1", "--gaussians", "2"}, "--profile: a multipole needs"},
      {{"--profile", "burley", "--material", "skin1", "--norm", "r", "--gaussians", "2"},
       "--norm: the norm r is not finite"},
      {{"--profile", "table", "--gaussians", "2"}, "--table: is missing"},
      {{"--profile", "table", "--table", "none.csv", "--gaussians", "2"}, "none.csv"},
      {{"--profile", "table", "--table", "nan.csv", "--gaussians", "1"}, "nan.csv:3:3: "},
      {{"--profile", "table", "--table", "unsorted.csv", "--gaussians", "1"},
       "unsorted.csv:4:1: 1 after 2: radii must ascend"},
      {{"--profile", "table", "--table", "short.csv", "--gaussians", "2"},
       "--gaussians: 2 Gaussians have 4 unknowns a channel, and the table has 3 points"},
      {with(medium, {"--sigma-a", "1e-150", "--sigma-s-prime", "1e-150", "--eta", "1.3"}),
       "sigma_s' (1/mm) is 1e-150: it must be 1e-9 to 1e9"},
      {with(medium, {"--sigma-a", "1e300", "--sigma-s-prime", "1", "--eta", "1.3"}),
       "sigma_a (1/mm) is 1e+300: it must be at most 1e9"},
      {{"--profile", "table", "--table", "tiny.csv", "--gaussians", "1"}, "tiny.csv:2:5: 1e-200: R is 0, or"},
      {with(skin, {"--gaussians", "2", "--glsl", "out.json"}), "out.json: is named twice"},
      {{"--profile", "trumpet", "--gaussians", "2"}, "--profile: \"trumpet\" is not known"}};
  for (const auto& [arguments, message] : table) {
    const ProgramResult result = fit(with(arguments, {"--out", "out.json", "--svg", "out.svg"}));
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err << " where " << message;
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out.json"));
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out.svg"));
  }
  EXPECT_EQ(fit(with(skin, {"--gaussians", "2"})).exit_code, 2);  // --out is missing
  EXPECT_EQ(fit(with(skin, {"--gaussians", "2", "--out", "no/such/f.json"})).exit_code, 2);
  EXPECT_EQ(fit(with(skin, {"--score", "nothing"})).exit_code, 2);
}

}  // namespace
}  // namespace truescatter::test
