#include "experiment/sweep.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "experiment/run_experiment.h"
#include "support/plane_experiment.h"
#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

using nlohmann::json;

const std::string kMethods = R"(
[[profile]]
name = "wide"
[[profile.gaussian]]
variance_mm2 = 1.0
weight = 1.0
[[method]]
name = "none"
[[method]]
name = "pscbf"
[truth]
geodesic = "off"
[timing]
warm_up = 0
repeats = 1
)";

class Sweep : public testing::Test {
 protected:
  ExperimentSpec read(const std::string& text) const {
    return read_experiment(folder_.write("e.toml", text));
  }
  json run(const ExperimentSpec& spec) const {
    run_experiment(spec, out_.path());
    return json::parse(read_text_file(out_.path() / "results.json"));
  }

  TempDir folder_;
  TempDir out_;
};

TEST_F(Sweep, IsARunForEachValue) {
  const ExperimentSpec spec = read(kPlane + kMethods + R"(
[sweep]
key = "view.front.width_px"
values = [24, 12, 20]
axis_values = [1.0, 2.0, 5.0]
title = "narrowness"
unit = "1/px"
)");
  const json results = run(spec);
  ASSERT_EQ(results["views"].size(), 3U);
  ASSERT_EQ(results["runs"].size(), 6U);
  const std::vector<int> widths = {24, 12, 20};
  const std::vector<double> axis = {1.0, 2.0, 5.0};
  for (std::size_t i = 0; i < 3; ++i) {
    const json& view = results["views"][i];
    EXPECT_EQ(view["name"], "front-0" + std::to_string(i + 1));
    EXPECT_EQ(view["width_px"], widths[i]);
    EXPECT_EQ(view["sweep"], (json{{"index", i}, {"axis", axis[i]}, {"view", "front"}}));
    for (const std::size_t m : {0U, 1U}) {
      const json& run = results["runs"][2 * i + m];
      EXPECT_EQ(run["view"], view["name"]);
      EXPECT_EQ(run["sweep"]["index"], i);
      EXPECT_EQ(run["sweep"]["profile"], "wide");
      EXPECT_TRUE(std::filesystem::exists(out_.path() / run["files"]["exr"].get<std::string>()));
    }
  }
  EXPECT_EQ(results["profiles"].size(), 1U);
  const json& sweep = results["sweep"];
  EXPECT_EQ(sweep["title"], "narrowness");
  EXPECT_EQ(sweep["keys"], json{"view.front.width_px"});
  ASSERT_EQ(sweep["points"].size(), 3U);
  EXPECT_EQ(sweep["points"][1]["value"], "12");
  ASSERT_EQ(sweep["curves"].size(), 2U);
  const json& curve = sweep["curves"][1];
  EXPECT_EQ(curve["label"], "pscbf");
  ASSERT_EQ(curve["points"].size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(curve["points"][i]["axis"], axis[i]);
    EXPECT_EQ(curve["points"][i]["rel_rmse"], results["runs"][2 * i + 1]["metrics"]["rel_rmse"]);
    EXPECT_EQ(curve["points"][i]["own_rel_rmse"],
              results["runs"][2 * i + 1]["own_target"]["metrics"]["rel_rmse"]);
  }
  // Even light on a plane: no method breaks.
  EXPECT_EQ(curve["breaks_at"]["2%"], nullptr);
  EXPECT_TRUE(curve["breaks_at"]["2%_reason"].get<std::string>().starts_with("never: "));
}

// A shadow on a plane: without scattering the error grows with s. The curve goes from easy to hard however
// the values are given; a profile has its number as a view has.
TEST_F(Sweep, OfAProfileGoesFromEasyToHard) {
  std::string cards = kPlane;
  cards.replace(cards.find("builtin:plane"), 13, "builtin:cards");
  cards.replace(cards.find("[0.0, 0.5, 1.0]"), 15, "[-0.5, 0.0, 1.0]");
  const ExperimentSpec spec = read(cards + kMethods + R"(
[sweep]
key = ["profile.wide.gaussian.0.variance_mm2", "profile.wide.r_max_mm"]
values = [[4.0, 6.0], [1.0, 3.0], [1e-4, 0.03]]
axis_values = [2.0, 1.0, 0.01]
scale = "log"
)");
  const json results = run(spec);
  ASSERT_EQ(results["profiles"].size(), 3U);
  EXPECT_EQ(results["profiles"][1]["name"], "wide-02");
  EXPECT_EQ(results["profiles"][2]["r_max_mm"], 0.03);
  const json& curve = results["sweep"]["curves"][0];
  EXPECT_EQ(curve["profile"], "wide");
  ASSERT_EQ(curve["points"].size(), 3U);
  EXPECT_EQ(curve["points"][0]["axis"], 0.01);
  EXPECT_EQ(curve["points"][2]["axis"], 2.0);
  const double easy = curve["points"][0]["rel_rmse"];
  const double hard = curve["points"][2]["rel_rmse"];
  ASSERT_LT(easy, 0.02);
  ASSERT_GT(hard, 0.10);
  EXPECT_TRUE(curve["only_rises"]);
  const double at_2 = curve["breaks_at"]["2%"];
  const double at_10 = curve["breaks_at"]["10%"];
  EXPECT_GT(at_2, 0.01);
  EXPECT_GT(at_10, at_2);
  EXPECT_LT(at_10, 2.0);

  // The resolved file repeats the run.
  const ExperimentSpec again = read_experiment(out_.path() / "experiment.resolved.toml");
  ASSERT_TRUE(again.sweep);
  EXPECT_EQ(again.sweep->axis, spec.sweep->axis);
  EXPECT_EQ(again.sweep->values, spec.sweep->values);
  ASSERT_EQ(again.sweep->point.size(), 3U);
  EXPECT_EQ(again.sweep->point[2].profiles[0].r_max_mm, 0.03);
}

}  // namespace
}  // namespace truescatter::test
