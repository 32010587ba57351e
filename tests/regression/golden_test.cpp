// Small experiments against their golden results, which scripts/update-golden regenerates. One of the 13 taps
// of pscbf at half its weight moves plane-shadow by 0.019, where 3e-5 are allowed.
//
// Where TRUESCATTER_UPDATE_GOLDEN is set, what a run gives becomes the golden result, and what changed is
// printed.
#include "regression/golden.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "support/run_program.h"

namespace truescatter::test {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(TRUESCATTER_SOURCE_DIR) / "tests/regression";
const std::filesystem::path kFailed =
    std::filesystem::path(TRUESCATTER_BINARY).parent_path() / "regression-failures";

class Golden : public testing::TestWithParam<std::string> {};
std::string test_name(const testing::TestParamInfo<std::string>& experiment) {
  std::string name = experiment.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Experiments, Golden, testing::ValuesIn(kGoldenExperiments), test_name);

TEST_P(Golden, IsReproduced) {
  const TempDir folder;
  const ProgramResult run = run_program(
      TRUESCATTER_BINARY, {"run", (kFolder / (GetParam() + ".toml")).string(), "--out", "out", "--no-cache"},
      folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Outcome fresh = read_results(folder.path() / "out");
  const std::filesystem::path golden = kFolder / "golden" / GetParam();
  const bool updates = std::getenv("TRUESCATTER_UPDATE_GOLDEN") != nullptr;
  if (!updates || std::filesystem::exists(golden)) {
    for (const std::string& change : changes(read_golden(golden), fresh, kFailed / GetParam())) {
      if (updates) {
        std::cout << change << '\n';
      } else {
        ADD_FAILURE() << change;
      }
    }
  }
  if (!updates) return;
  std::filesystem::remove_all(golden);
  write_golden(fresh, golden);
}

// One value of one pixel of each picture, off by twice what is allowed, is found, and half of it is not.
TEST(GoldenComparison, FindsOnePixel) {
  const Outcome golden = read_golden(kFolder / "golden/sphere");
  const TempDir folder;
  EXPECT_TRUE(changes(golden, golden, folder.path()).empty());
  for (const auto& [name, picture] : golden.pictures) {
    const double allowed = tolerance_of(name, golden, golden);
    for (const double share : {0.5, 2.0}) {
      Outcome fresh = golden;
      fresh.pictures[name].at(20, 30, 0) +=
          static_cast<float>(name == "mask" ? share - 0.5 : share * allowed);
      const auto found = changes(golden, fresh, folder.path());
      ASSERT_EQ(found.size(), share > 1.0 ? 1U : 0U) << name;
      if (share < 1.0) continue;
      EXPECT_NE(found[0].find("at pixel (20, 30)"), std::string::npos) << found[0];
      for (const std::string kind : {".golden", ".new", ".difference"}) {
        EXPECT_NE(found[0].find((folder.path() / (name + kind + ".png")).string()), std::string::npos);
        EXPECT_TRUE(std::filesystem::exists(folder.path() / (name + kind + ".png")));
      }
    }
  }
}

}  // namespace
}  // namespace truescatter::test
