#include "cli/cli_fixture.h"
#include "core/image_io.h"

namespace truescatter::test {
namespace {

// 16 x 8 pixels of a grey ramp; every value is exact in binary.
Image ramp(double offset = 0.0) {
  Image image(16, 8, 3);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) image.set_rgb(x, y, Vec3d::Constant((x + 1) / 32.0 + offset));
  }
  return image;
}

class CliCompare : public Cli {
 protected:
  void SetUp() override {
    const Image truth = ramp();
    write_exr(folder_.path() / "truth.exr", {{"", &truth}, {"mask", &ramp_mask_}});
  }
  const Image ramp_mask_{16, 8, 1, 1.0F};
  void write_test(const Image& image) const { write_exr(folder_.path() / "test.exr", {{"", &image}}); }
};

TEST_F(CliCompare, IdenticalPicturesHaveNoError) {
  const ProgramResult result = truescatter({"compare", "truth.exr", "truth.exr", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json stats = nlohmann::json::parse(result.out);
  EXPECT_EQ(stats.at("pixels"), 128);
  for (const char* key :
       {"bias", "mae", "rmse", "rel_rmse", "p50", "p95", "p99", "max", "flip", "flip_hdr"}) {
    EXPECT_EQ(stats.at(key), 0.0) << key;
  }
  for (const char* channel : {"r", "g", "b"}) EXPECT_EQ(stats.at("channels").at(channel).at("max"), 0.0);
}

// Everywhere 1/4 too bright: bias, mae, rmse and every quantile of a channel are 1/4.
TEST_F(CliCompare, AConstantOffsetIsEveryMetric) {
  write_test(ramp(0.25));
  const ProgramResult result = truescatter({"compare", "test.exr", "truth.exr", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json red = nlohmann::json::parse(result.out).at("channels").at("r");
  for (const char* key : {"bias", "mae", "rmse", "p50", "p95", "p99", "max"})
    EXPECT_EQ(red.at(key), 0.25) << key;
  EXPECT_EQ(nlohmann::json::parse(truescatter({"compare", "truth.exr", "test.exr", "--json"}).out)
                .at("channels")
                .at("r")
                .at("bias"),
            -0.25);
}

// Whole numbers are sRGB-encoded: the code 188 of 255 is 0.502886 of linear light ((188/255 + 0.055) / 1.055
// to the power of 2.4). Taken as it is, it would be 0.737.
TEST_F(CliCompare, APngIsDecodedToLinearLight) {
  write_png(folder_.path() / "test.png", Image(16, 8, 3, 188.0F / 255.0F));
  const Image linear(16, 8, 3, 0.502886F);
  write_test(linear);
  const ProgramResult result = truescatter({"compare", "test.png", "test.exr", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(nlohmann::json::parse(result.out).at("max").get<double>(), 1e-6);
}

TEST_F(CliCompare, PrintsATable) {
  const ProgramResult result = truescatter({"compare", "truth.exr", "truth.exr"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* piece :
       {"rel_rmse", "luminance", "sqrt((1/n) sum truth^2)", "128 pixels", "FLIP 0", "HDR-FLIP 0"}) {
    EXPECT_TRUE(contains(result.out, piece)) << piece << "\n" << result.out;
  }
}

TEST_F(CliCompare, TheMaskLeavesPixelsOut) {
  Image test = ramp();
  test.set_rgb(3, 2, {9, 9, 9});
  write_test(test);
  Image mask(16, 8, 1, 1.0F);
  mask.at(3, 2, 0) = 0.0F;
  write_exr(folder_.path() / "mask.exr", {{"", &mask}});
  const ProgramResult result =
      truescatter({"compare", "test.exr", "truth.exr", "--mask", "mask.exr", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("pixels"), 127);
  EXPECT_EQ(nlohmann::json::parse(result.out).at("max"), 0.0);
}

// NaN never reaches a JSON: null and the reason do.
TEST_F(CliCompare, AnEmptyMaskGivesReasons) {
  const Image mask(16, 8, 1);
  write_exr(folder_.path() / "mask.exr", {{"", &mask}});
  const ProgramResult result =
      truescatter({"compare", "truth.exr", "truth.exr", "--mask", "mask.exr", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  nlohmann::json stats = nlohmann::json::parse(result.out);
  EXPECT_TRUE(stats.at("rmse").is_null());
  EXPECT_EQ(stats.at("rmse_reason"), "no pixel to measure");
  stats.erase("provenance");  // it names a library nanoflann
  EXPECT_FALSE(contains(stats.dump(), "nan"));
}

// Skin in columns 8 to 55 of 64, before nothing: delta is 0 at the columns 8 and 55, and grows by 1 px a
// column. With s = 2 px bins are s/8 = 1/4 px. Too bright by 1/4 in the five columns of delta 0 to 4, by
// 1/256 where delta > 6 s. So the halo's height is 1/4; the last bin above 1 % is [4, 4.25); within 3 s = 6
// px lie seven columns on each of two sides of 8 rows, five of them in error: energy 5/7 / 4, contrast
// sqrt(5/7) / 4 * 256. In blue there is half of it. Outside of the mask anything may be.
TEST_F(CliCompare, TheHaloOfASyntheticStepComesBack) {
  Image truth(64, 8, 3, 9.0F);
  Image test(64, 8, 3, 0.0F);
  Image mask(64, 8, 1);
  for (int y = 0; y < 8; ++y) {
    for (int x = 8; x <= 55; ++x) {
      const int delta = std::min(x - 8, 55 - x);
      const double error = delta < 5 ? 0.25 : delta > 12 ? 1.0 / 256.0 : 0.0;
      mask.at(x, y, 0) = 1.0F;
      truth.set_rgb(x, y, Vec3d::Ones());
      test.set_rgb(x, y, Vec3d(1.0 + error, 1.0 + error, 1.0 + 0.5 * error));
    }
  }
  write_test(test);
  write_exr(folder_.path() / "truth.exr", {{"", &truth}});
  write_exr(folder_.path() / "mask.exr", {{"", &mask}});
  const ProgramResult result =
      truescatter({"compare", "test.exr", "truth.exr", "--mask", "mask.exr", "--halo", "2", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json halo = nlohmann::json::parse(result.out).at("halo");
  for (const auto& [channel, factor] : {std::pair("r", 1.0), std::pair("b", 0.5)}) {
    const nlohmann::json& found = halo.at("channels").at(channel);
    EXPECT_EQ(found.at("pixels"), 2 * 7 * 8);
    EXPECT_EQ(found.at("profile").at("bin_px"), 0.25);
    EXPECT_EQ(found.at("peak"), factor * 0.25);
    EXPECT_EQ(found.at("width_px"), 4.25);
    EXPECT_DOUBLE_EQ(found.at("energy").get<double>(), factor * 0.25 * 5.0 / 7.0);
    EXPECT_DOUBLE_EQ(found.at("contrast").get<double>(), std::sqrt(5.0 / 7.0) * 64.0);
  }
  EXPECT_NEAR(halo.at("peak").get<double>(), 0.25 * (1.0 - 0.5 * 0.0722), 1e-12);  // luminance of Rec. 709
  EXPECT_TRUE(
      contains(truescatter({"compare", "test.exr", "truth.exr", "--mask", "mask.exr", "--halo", "2"}).out,
               "width_px"));
}

void expect_refused(const ProgramResult& result, const std::vector<std::string>& pieces) {
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  for (const std::string& piece : pieces)
    EXPECT_TRUE(contains(result.err, piece)) << piece << "\nin\n" << result.err;
}

TEST_F(CliCompare, RefusesWhatItCannotCompare) {
  const Image small(4, 4, 3);
  write_test(small);
  expect_refused(truescatter({"compare", "test.exr", "truth.exr"}),
                 {"test.exr: is 4 x 4 pixels, but truth.exr is 16 x 8"});
  const Image small_mask(4, 4, 1);
  write_exr(folder_.path() / "mask.exr", {{"", &small_mask}});
  expect_refused(truescatter({"compare", "truth.exr", "truth.exr", "--mask", "mask.exr"}),
                 {"mask.exr: is 4 x 4 pixels"});
  folder_.write("text.exr", "no picture");
  expect_refused(truescatter({"compare", "text.exr", "truth.exr"}), {"text.exr: cannot read this image"});
  expect_refused(truescatter({"compare", "none.exr", "truth.exr"}), {"none.exr: no such file"});
  expect_refused(truescatter({"compare", "mask.exr", "truth.exr"}),
                 {"mask.exr: has 1 plain channels; R, G, B are needed"});
  expect_refused(truescatter({"compare", "truth.exr"}), {"truth"});
  expect_refused(truescatter({"compare", "truth.exr", "truth.exr", "--halo", "2"}), {"--halo: needs --mask"});
  write_exr(folder_.path() / "mask.exr", {{"", &ramp_mask_}});
  expect_refused(truescatter({"compare", "truth.exr", "truth.exr", "--mask", "mask.exr", "--halo", "0"}),
                 {"--halo: \"0\": a standard deviation in pixels must be above 0"});
  Image hole = ramp();
  hole.at(1, 1, 1) = std::numeric_limits<float>::quiet_NaN();
  write_test(hole);
  expect_refused(truescatter({"compare", "test.exr", "truth.exr"}),
                 {"test.exr: holds a value that is not finite"});
}

// Two folders as `run` writes them, the second with another setting, a method less and one more.
class CliCompareResults : public Cli {
 protected:
  static std::string results(const std::string& commit, const nlohmann::json& runs) {
    return nlohmann::json(
               {{"schema", "truescatter-results-1"},
                {"provenance", {{"version", "0.1.0"}, {"commit", commit}, {"gl_renderer", "llvmpipe"}}},
                {"runs", runs}})
        .dump(1);
  }
  static nlohmann::json entry(const std::string& label, const nlohmann::json& rmse, double bias) {
    return {
        {"scene", "builtin:plane"},
        {"view", "front"},
        {"profile", "skin"},
        {"method", "pscbf"},
        {"label", label},
        {"metrics",
         {{"rmse", rmse}, {"rel_rmse", 0.5}, {"bias", bias}, {"max", 2.0}, {"halo", {{"peak", nullptr}}}}},
        {"cost", {{"frame_ms", {{"median", 4.0}}}, {"fetches_per_pixel", 61.0}}}};
  }
  void SetUp() override {
    std::filesystem::create_directory(folder_.path() / "a");
    std::filesystem::create_directory(folder_.path() / "b");
    nlohmann::json moved = entry("both", 0.3, 0.0);
    moved["cost"]["frame_ms"]["median"] = 5.0;
    folder_.write("a/results.json", results("c1", {entry("both", 0.4, 0.0), entry("gone", 0.1, -0.1)}));
    folder_.write("b/results.json", results("c2", {entry("come", 0.2, 0.2), moved}));
    folder_.write(
        "a/experiment.resolved.toml",
        "[truth]\nseed = 1\n[[method]]\nname = \"pscbf\"\nlabel = \"both\"\n[method.settings]\ntaps = 13\n");
    folder_.write(
        "b/experiment.resolved.toml",
        "[[method]]\nname = \"pscbf\"\nlabel = \"both\"\n[method.settings]\ntaps = 7\n[truth]\nseed = 1\n"
        "tolerance = 1e-4\n");
  }
  nlohmann::json compared() const {
    const ProgramResult result = truescatter({"compare", "a", "b", "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  }
};

// 0.4 -> 0.3 is a quarter less, 4 ms -> 5 ms a quarter more.
TEST_F(CliCompareResults, SaysWhatChanged) {
  const nlohmann::json changes = compared();
  ASSERT_EQ(changes.at("runs").size(), 1U);
  const nlohmann::json& run = changes.at("runs").at(0);
  EXPECT_EQ(run.at("label"), "both");
  const nlohmann::json& metrics = run.at("metrics");
  EXPECT_EQ(metrics.at("rmse").at("old"), 0.4);
  EXPECT_EQ(metrics.at("rmse").at("new"), 0.3);
  EXPECT_NEAR(metrics.at("rmse").at("change").get<double>(), -0.25, 1e-15);
  EXPECT_EQ(metrics.at("frame_ms").at("change"), 0.25);
  for (const char* same : {"rel_rmse", "bias", "max", "fetches_per_pixel"})
    EXPECT_EQ(metrics.at(same).at("change"), 0.0) << same;
  EXPECT_TRUE(metrics.at("halo_peak").at("change").is_null());
  EXPECT_EQ(metrics.at("halo_peak").at("change_reason"), "a value is missing");
  EXPECT_EQ(changes.at("only_old").at(0).at("label"), "gone");
  EXPECT_EQ(changes.at("only_new").at(0).at("label"), "come");
  EXPECT_EQ(changes.at("provenance"), nlohmann::json({{"commit", {{"old", "c1"}, {"new", "c2"}}}}));
  EXPECT_EQ(changes.at("experiment"),
            nlohmann::json({{"method.both.settings.taps", {{"old", "13"}, {"new", "7"}}},
                            {"truth.tolerance", {{"old", nullptr}, {"new", "0.0001"}}}}));
}

TEST_F(CliCompareResults, PrintsWhatChanged) {
  const ProgramResult result = truescatter({"compare", "a", "b"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, R"(old: a
new: b
provenance:
  commit: c1 -> c2
experiment:
  method.both.settings.taps: 13 -> 7
  truth.tolerance: (none) -> 0.0001
changed (*): bias, mae, rmse (own_rmse too), quantiles and max by more than the uncertainties of both truths together, which is what a change of truth alone can do; rel_rmse by more than that times (1 + rel_rmse) / RMS of the truth; frame_ms where the ranges [min, max] of the repeats do not overlap; all else where it differs
builtin:plane / front / skin / both
  rmse                       0.4 -> 0.3          -25.00 % *
  frame_ms                     4 -> 5            +25.00 % (fewer than two repeats on a side say nothing of noise)
only in the old: builtin:plane / front / skin / gone
only in the new: builtin:plane / front / skin / come
)");
}

// Uncertainties 0.005 and 0.01 of the largest irradiance, 2: together 0.03 of irradiance. The bias moves by
// 0.02, which the truth alone could do, the RMSE by 0.1. With rms = rmse / rel_rmse = 0.8, rel_rmse of 0.5
// may move by 0.03 * 1.5 / 0.8 = 0.05625. Ranges [3, 5] and [4, 6] overlap, [3, 4.5] and [4.6, 6] do not. A
// count has no noise.
TEST_F(CliCompareResults, TellsChangesFromNoise) {
  const auto folder = [&](const std::string& name, double uncertainty, const nlohmann::json& run) {
    nlohmann::json results = nlohmann::json::parse(this->results("c1", nlohmann::json::array({run})));
    results["scene"] = {{"largest_irradiance", 2.0}};
    results["truths"] = {{{"id", "front.skin"}, {"uncertainty", uncertainty}}};
    folder_.write(name + "/results.json", results.dump());
  };
  nlohmann::json before = entry("both", 0.4, 0.1);
  before["truth"] = "front.skin";
  before["cost"]["frame_ms"] = {{"median", 4.0}, {"min", 3.0}, {"max", 5.0}, {"repeats", 3}};
  nlohmann::json after = before;
  after["metrics"]["rmse"] = 0.3;
  after["metrics"]["rel_rmse"] = 0.55;
  after["metrics"]["bias"] = 0.12;
  after["cost"]["fetches_per_pixel"] = 61.5;
  after["cost"]["frame_ms"] = {{"median", 5.0}, {"min", 4.0}, {"max", 6.0}, {"repeats", 3}};
  folder("a", 0.005, before);
  folder("b", 0.01, after);
  nlohmann::json run = compared().at("runs").at(0);
  EXPECT_EQ(run.at("changed"), nlohmann::json({"rmse", "fetches_per_pixel"}));
  EXPECT_NEAR(run.at("metrics").at("bias").at("noise").get<double>(), 0.03, 1e-15);
  EXPECT_NEAR(run.at("metrics").at("rel_rmse").at("noise").get<double>(), 0.05625, 1e-15);
  EXPECT_EQ(run.at("metrics").at("frame_ms").at("changed"), false);
  const std::string text = truescatter({"compare", "a", "b"}).out;
  for (const char* line : {"+20.00 % (noise 0.03)\n", "-25.00 % *\n", "+10.00 % (noise 0.056)\n",
                           "+25.00 % (within [3, 5] and [4, 6])\n", "+0.82 % *\n"})
    EXPECT_TRUE(contains(text, line)) << line << "\nin\n" << text;
  before["cost"]["frame_ms"]["max"] = 4.5;
  after["cost"]["frame_ms"]["min"] = 4.6;
  after["metrics"]["rel_rmse"] = 0.56;
  folder("a", 0.005, before);
  folder("b", 0.01, after);
  run = compared().at("runs").at(0);
  EXPECT_EQ(run.at("changed"), nlohmann::json({"rmse", "rel_rmse", "frame_ms", "fetches_per_pixel"}));
  after["cost"]["frame_ms"]["repeats"] = 1;
  folder("b", 0.01, after);
  EXPECT_TRUE(compared().at("runs").at(0).at("metrics").at("frame_ms").at("changed").is_null());
}

TEST_F(CliCompareResults, AFolderAgainstItselfIsTheSame) {
  const ProgramResult result = truescatter({"compare", "a", "a"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.out, "provenance: the same\nexperiment: the same\n")) << result.out;
  EXPECT_TRUE(contains(result.out, "/ both\n  the same\n")) << result.out;
  EXPECT_FALSE(contains(result.out, " %")) << result.out;
  EXPECT_FALSE(contains(result.out, "only in")) << result.out;
}

// From nothing to something there is no relative change.
TEST_F(CliCompareResults, AChangeFromZeroHasAReason) {
  folder_.write("b/results.json", results("c1", nlohmann::json::array({entry("both", 0.4, 0.1)})));
  const nlohmann::json bias = compared().at("runs").at(0).at("metrics").at("bias");
  EXPECT_TRUE(bias.at("change").is_null());
  EXPECT_EQ(bias.at("change_reason"), "the old value is 0");
}

// The same experiment, run from its resolved file: the path of the mesh is absolute there.
TEST_F(CliCompareResults, AMovedSceneIsTheSameScene) {
  nlohmann::json here = entry("both", 0.4, 0.0);
  nlohmann::json there = here;
  here["scene"] = "data/face.obj";
  there["scene"] = "/elsewhere/data/face.obj";
  folder_.write("a/results.json", results("c1", nlohmann::json::array({here})));
  folder_.write("b/results.json", results("c1", nlohmann::json::array({there})));
  EXPECT_EQ(compared().at("runs").size(), 1U);
}

TEST_F(CliCompareResults, WithoutAResolvedExperimentItSaysSo) {
  std::filesystem::remove(folder_.path() / "b/experiment.resolved.toml");
  const nlohmann::json changes = compared();
  EXPECT_TRUE(changes.at("experiment").is_null());
  EXPECT_EQ(changes.at("experiment_reason"), "there is no b/experiment.resolved.toml");
  EXPECT_TRUE(contains(truescatter({"compare", "a", "b"}).out,
                       "experiment: not compared, there is no b/experiment.resolved.toml\n"));
}

TEST_F(CliCompareResults, RefusesWhatItCannotCompare) {
  expect_refused(
      truescatter({"compare", "a", "a/results.json"}),
      {"truescatter: a is a folder and a/results.json is a file; compare takes two pictures or two "
       "result folders\n"});
  expect_refused(truescatter({"compare", "a/results.json", "a"}),
                 {"a is a folder and a/results.json is a file"});
  expect_refused(truescatter({"compare", "a", "b", "--mask", "m.exr"}), {"--mask is for pictures"});
  expect_refused(truescatter({"compare", "a", "none"}), {"truescatter: none: no such folder\n"});
  // The comma before the brace: line 3, column 1.
  folder_.write("b/results.json", "{\n \"schema\": \"truescatter-results-1\",\n}");
  expect_refused(truescatter({"compare", "a", "b"}),
                 {"truescatter: b/results.json:3:1: this is not valid JSON: "});
  folder_.write("b/results.json", "");
  expect_refused(truescatter({"compare", "a", "b"}), {"b/results.json:1:1: this is not valid JSON"});
  folder_.write("b/results.json", "{\"schema\": \"truescatter-results-2\"}");
  expect_refused(truescatter({"compare", "a", "b"}),
                 {"b/results.json: the schema is \"truescatter-results-2\"; this version knows "});
  folder_.write("b/results.json", results("c1", nlohmann::json::array({{{"scene", 1}}})));
  expect_refused(truescatter({"compare", "a", "b"}), {"b/results.json: the results are not laid out"});
  folder_.write("b/results.json", results("c1", {entry("x", 1, 1), entry("x", 1, 1)}));
  expect_refused(truescatter({"compare", "a", "b"}),
                 {"b/results.json: two runs have the name builtin:plane / front / skin / x"});
  std::filesystem::remove(folder_.path() / "b/results.json");
  expect_refused(truescatter({"compare", "a", "b"}),
                 {"b/results.json: no such file; a folder that `run` has written"});
}

TEST_F(CliCompare, ListNamesEverythingThereIs) {
  const ProgramResult result = truescatter({"list"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  for (const char* piece :
       {"none ", "blur2d ", "screen-gaussian ", "pscbf ", "texture-space ", "taps = ", "spike-and-base ",
        "spike-and-base-sigma ", "skin-six-gaussian ", "builtin:head ", "builtin:sphere ", "builtin:plane ",
        "builtin:wedge ", "builtin:slab ", "builtin:tube ", "builtin:cards "}) {
    EXPECT_TRUE(contains(result.out, piece)) << piece;
  }
}

TEST_F(CliCompare, HelpIsNoError) {
  const ProgramResult result = truescatter({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* command : {"run", "compare", "report", "list"})
    EXPECT_TRUE(contains(result.out, command)) << command;
}

}  // namespace
}  // namespace truescatter::test
