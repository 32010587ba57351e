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
    const Image mask(16, 8, 1, 1.0F);
    write_exr(folder_.path() / "truth.exr", {{"", &truth}, {"mask", &mask}});
  }
  void write_test(const Image& image) const { write_exr(folder_.path() / "test.exr", {{"", &image}}); }
};

TEST_F(CliCompare, IdenticalPicturesHaveNoError) {
  const ProgramResult result = truescatter({"compare", "truth.exr", "truth.exr", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json stats = nlohmann::json::parse(result.out);
  EXPECT_EQ(stats.at("pixels"), 128);
  for (const char* key : {"bias", "mae", "rmse", "rel_rmse", "p50", "p95", "p99", "max", "flip"}) {
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

TEST_F(CliCompare, PrintsATable) {
  const ProgramResult result = truescatter({"compare", "truth.exr", "truth.exr"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* piece : {"rel_rmse", "luminance", "128 pixels", "FLIP 0"}) {
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
  const nlohmann::json stats = nlohmann::json::parse(result.out);
  EXPECT_TRUE(stats.at("rmse").is_null());
  EXPECT_EQ(stats.at("rmse_reason"), "no pixel to measure");
  EXPECT_FALSE(contains(result.out, "nan"));
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
  Image hole = ramp();
  hole.at(1, 1, 1) = std::numeric_limits<float>::quiet_NaN();
  write_test(hole);
  expect_refused(truescatter({"compare", "test.exr", "truth.exr"}),
                 {"test.exr: holds a value that is not finite"});
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
