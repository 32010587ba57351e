#include "experiment/fit_file.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

TEST(FitFile, IsRead) {
  const test::TempDir folder;
  const std::vector<GaussianLevel> levels =
      read_fit(folder.write("fit.json",
                            "{\"profile\": \"dipole\", \"variances\": [0.25, 4],\n"
                            "\"weights\": [[0.5, 0, 1e-3], [-0.25, 0.5, 1]], \"error\": null}"));
  ASSERT_EQ(levels.size(), 2U);
  EXPECT_EQ(levels[0].variance_mm2, 0.25);
  EXPECT_EQ(levels[0].std_dev_mm(), 0.5);
  EXPECT_EQ(levels[0].weight, Vec3d(0.5, 0, 1e-3));
  EXPECT_EQ(levels[1].variance_mm2, 4.0);
  EXPECT_EQ(levels[1].weight, Vec3d(-0.25, 0.5, 1));
}

TEST(FitFile, RefusesWhatIsBroken) {
  const test::TempDir folder;
  const std::vector<std::pair<std::string, std::string>> table = {
      {"", "fit.json:1:1: this is not valid JSON: "},
      {"{\"variances\": [1],\n \"weights\": [[1, 1 1]]}", "fit.json:2:20: this is not valid JSON: "},
      {"{\"variances\": [1e999], \"weights\": [[1, 1, 1]]}", "fit.json: this is not valid JSON: number"},
      {"[1]", "fit.json: an object with the key \"variances\" is needed"},
      {"{\"weights\": [[1, 1, 1]]}", "fit.json: the key \"variances\" is missing"},
      {"{\"variances\": [1]}", "fit.json: the key \"weights\" is missing"},
      {"{\"variances\": 1, \"weights\": [[1, 1, 1]]}",
       "fit.json: variances is 1: an array of one or more is needed"},
      {"{\"variances\": [], \"weights\": []}",
       "fit.json: variances is []: an array of one or more is needed"},
      {"{\"variances\": [1, 2], \"weights\": [[1, 1, 1]]}",
       "fit.json: weights has 1 rows and variances 2: one row for each variance is needed"},
      {"{\"variances\": [\"1\"], \"weights\": [[1, 1, 1]]}",
       "fit.json: variances[0] is \"1\": a finite number is needed"},
      {"{\"variances\": [null], \"weights\": [[1, 1, 1]]}",
       "fit.json: variances[0] is null: a finite number is needed"},
      {"{\"variances\": [0], \"weights\": [[1, 1, 1]]}",
       "fit.json: variances[0] is 0: a variance in mm^2 must be above 0"},
      {"{\"variances\": [-1], \"weights\": [[1, 1, 1]]}",
       "fit.json: variances[0] is -1: a variance in mm^2 must be above 0"},
      {"{\"variances\": [1, 1], \"weights\": [[1, 1, 1], [1, 1, 1]]}",
       "fit.json: variances[1] is 1, after 1: variances must ascend"},
      {"{\"variances\": [2, 1], \"weights\": [[1, 1, 1], [1, 1, 1]]}",
       "fit.json: variances[1] is 1, after 2: variances must ascend"},
      {"{\"variances\": [1], \"weights\": [[1, 1]]}",
       "fit.json: weights[0] is [1,1]: three weights [r, g, b] are needed"},
      {"{\"variances\": [1], \"weights\": [1]}",
       "fit.json: weights[0] is 1: three weights [r, g, b] are needed"},
      {"{\"variances\": [1], \"weights\": [[1, true, 1]]}",
       "fit.json: weights[0][1] is true: a finite number is needed"},
  };
  for (const auto& [content, message] : table) {
    const std::filesystem::path path = folder.write("fit.json", content);
    const auto error = test::error_of([&] { read_fit(path); });
    ASSERT_TRUE(error) << content;
    EXPECT_EQ(error->kind(), ErrorKind::input);
    const std::string text = std::string(error->what()).substr(folder.path().string().size() + 1);
    EXPECT_EQ(text.substr(0, message.size()), message);
  }
  const auto missing = test::error_of([&] { read_fit(folder.path() / "none.json"); });
  ASSERT_TRUE(missing);
  EXPECT_EQ(missing->kind(), ErrorKind::input);
}

}  // namespace
}  // namespace truescatter
