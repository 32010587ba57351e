#include "report/advice.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"
#include "support/error_of.h"

namespace truescatter {
namespace {

using nlohmann::json;

json run(const std::string& view, const std::string& profile, const std::string& label, double error,
         double ms, double fetches) {
  return {{"view", view},
          {"profile", profile},
          {"label", label},
          {"settings", json::object()},
          // RMS of the truth 0.5, so that the 99 % quantile is 4 RMSE: 4 times the relative RMSE.
          {"metrics",
           {{"rmse", 0.5 * error},
            {"rel_rmse", error},
            {"p99", 2.0 * error},
            {"halo", {{"peak", -3.0 * error}}}}},
          {"cost",
           {{"frame_ms", {{"median", ms}, {"min", 0.9 * ms}, {"max", 1.2 * ms}, {"repeats", 3}}},
            {"passes", fetches == 0.0 ? 0 : 2},
            {"fetches_per_pixel", fetches},
            {"bytes_per_pixel", 16.0 * fetches}}}};
}

json view(const std::string& name, int size, double skin_pixels, double eye_x = 0.0) {
  return {{"name", name},
          {"width_px", size},
          {"height_px", size},
          {"skin_pixels", skin_pixels},
          {"camera", {{"eye_mm", {eye_x, 0.0, 1.0}}}}};
}

// Two views, five settings; errors in view a, then b. Their largest: none 0.40, dear 0.02, fast 0.10, mid
// 0.04 and waste 0.05. By time: none 0, fast 1, mid 4, waste 6, dear 9; by fetches fast and mid change
// places.
json two_views() {
  json results = {{"views", {view("a", 10, 50.0), view("b", 10, 60.0, 2.0)}},
                  {"profiles", {{{"name", "skin"}}}},
                  {"runs", json::array()}};
  const auto add = [&](const std::string& label, double a, double b, double ms, double fetches) {
    results["runs"].push_back(run("a", "skin", label, a, 0.5 * ms, fetches));
    results["runs"].push_back(run("b", "skin", label, b, ms, fetches));
  };
  add("none", 0.40, 0.30, 0.5, 0.0);
  add("dear", 0.01, 0.02, 9.0, 90.0);
  add("fast", 0.10, 0.04, 1.0, 40.0);
  add("mid", 0.03, 0.04, 4.0, 20.0);
  add("waste", 0.05, 0.05, 6.0, 60.0);
  return results;
}

std::string label_of(const json& setting) {
  return setting.is_null() ? "" : setting.at("label").get<std::string>();
}

AdviceRequest within(double error) {
  AdviceRequest request;
  request.error = error;
  return request;
}

TEST(Advice, NamesTheCheapestWithinAnErrorInEveryView) {
  const json found = advice(two_views(), within(0.05));
  EXPECT_TRUE(found.at("meets"));
  EXPECT_EQ(label_of(found.at("chosen")), "mid");  // fast is cheaper, and misses it in view a
  EXPECT_DOUBLE_EQ(found.at("chosen").at("error").get<double>(), 0.04);
  EXPECT_EQ(found.at("chosen").at("worst_case"), "view b, skin");
  EXPECT_DOUBLE_EQ(found.at("chosen").at("ms").at("median").get<double>(), 4.0);  // view b's
  EXPECT_EQ(label_of(found.at("next_cheaper")), "fast");
  EXPECT_DOUBLE_EQ(found.at("next_cheaper").at("error").get<double>(), 0.10);
  // By time: none, fast, mid, waste, dear; waste is beaten by mid.
  const json& settings = found.at("settings");
  ASSERT_EQ(settings.size(), 5U);
  const char* const order[] = {"none", "fast", "mid", "waste", "dear"};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(label_of(settings[i]), order[i]);
    EXPECT_EQ(settings[i].at("front").get<bool>(), i != 3);
  }
}

TEST(Advice, SaysWhatTheBestReachesWhereNoneMeetsTheError) {
  const json found = advice(two_views(), within(0.01));
  EXPECT_FALSE(found.at("meets"));
  EXPECT_EQ(label_of(found.at("chosen")), "dear");
  const std::string text = advice_text(found);
  EXPECT_NE(
      text.find(
          "no setting meets 1 %; the most accurate:\n  dear: error 2 % (view b, skin), 9 ms (8.1..10.8)"),
      std::string::npos)
      << text;
}

TEST(Advice, KeepsToABudget) {
  AdviceRequest request = within(0.02);
  request.budget = 5.0;
  json found = advice(two_views(), request);
  EXPECT_EQ(label_of(found.at("chosen")), "mid");
  EXPECT_FALSE(found.at("meets"));
  EXPECT_EQ(label_of(found.at("next_better")), "dear");
  // Fetches: mid 20, fast 40, waste 60.
  request.by_fetches = true;
  request.budget = 19.0;
  found = advice(two_views(), request);
  EXPECT_EQ(label_of(found.at("chosen")), "none");
  request.budget = 45.0;
  EXPECT_EQ(label_of(advice(two_views(), request).at("chosen")), "mid");
}

TEST(Advice, KnowsOtherMetrics) {
  AdviceRequest request = within(0.15);
  request.metric = "halo-peak";  // dear 0.06, mid 0.12, waste 0.15
  EXPECT_EQ(label_of(advice(two_views(), request).at("chosen")), "mid");
  request.metric = "p99";  // dear 0.08, mid 0.16
  const json found = advice(two_views(), request);
  EXPECT_EQ(label_of(found.at("chosen")), "dear");
  EXPECT_DOUBLE_EQ(found.at("chosen").at("error").get<double>(), 0.08);
}

TEST(Advice, LeavesOutWhatWasNotMeasuredEverywhere) {
  json results = two_views();
  results["runs"].erase(9);                        // waste in view b
  results["runs"][2]["skipped"] = "it needs UVs";  // dear in view a
  results["runs"][2].erase("metrics");
  results["runs"][7]["metrics"]["rel_rmse"] = nullptr;  // mid in view b
  const json found = advice(results, within(0.05));
  EXPECT_EQ(found.at("settings").size(), 2U);
  ASSERT_EQ(found.at("left_out").size(), 3U);
  EXPECT_EQ(found.at("left_out")[0], json({{"name", "dear"}, {"reason", "it needs UVs"}}));
  EXPECT_EQ(found.at("left_out")[1], json({{"name", "mid"}, {"reason", "view b has no rmse"}}));
  EXPECT_EQ(found.at("left_out")[2], json({{"name", "waste"}, {"reason", "it was not run in every case"}}));
  EXPECT_EQ(label_of(found.at("chosen")), "fast");
}

TEST(Advice, RefusesAResultWithoutAnError) {
  json results = two_views();
  for (json& r : results["runs"]) r["metrics"]["halo"]["peak"] = nullptr;
  AdviceRequest request;
  request.metric = "halo-peak";
  const auto error = test::error_of([&] { advice(results, request); });
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(std::string(error->what()).find("no setting has halo-peak and a cost in every case"),
            std::string::npos)
      << error->what();
}

// One camera at two sizes, and two sums of Gaussians for one profile: four settings of one case, with errors
// against the profile itself. Half a frame's 25 of 100 skin pixels read a quarter.
TEST(Advice, TakesGaussiansAndFramesForSettings) {
  json results = {
      {"views", {view("full", 20, 100.0), view("half", 10, 25.0)}},
      {"profiles",
       {{{"name", "k1"}, {"of", {{"title", "dipole"}}}}, {{"name", "k2"}, {"of", {{"title", "dipole"}}}}}},
      {"runs", json::array()}};
  for (const std::string v : {"full", "half"}) {
    for (const std::string k : {"k1", "k2"}) {
      json r = run(v, k, "m", 0.001, v == "full" ? 8.0 : 2.0, 40.0);
      r["profile_error"] = {
          {"metrics", {{"rel_rmse", (k == "k1" ? 0.3 : 0.01) + (v == "full" ? 0.0 : 0.01)}}}};
      results["runs"].push_back(r);
    }
  }
  const json found = advice(results, within(0.02));
  ASSERT_EQ(found.at("settings").size(), 4U);
  EXPECT_EQ(found.at("chosen").at("name"), "m, k2, 10x10");
  EXPECT_DOUBLE_EQ(found.at("chosen").at("error").get<double>(), 0.02);
  EXPECT_DOUBLE_EQ(found.at("chosen").at("fetches").get<double>(), 10.0);
  EXPECT_DOUBLE_EQ(found.at("chosen").at("bytes").get<double>(), 160.0);
  EXPECT_EQ(found.at("chosen").at("worst_case"), "view full/half, dipole");
}

json need(double layers, double transmittance) {
  const auto part = [](double difference) { return json{{"difference", difference}}; };
  return {{"view", "a"},
          {"profile", "skin"},
          {"layers", part(layers)},
          {"shadows", {{"difference", nullptr}, {"reason", "no light casts any"}}},
          {"geodesics", part(0.0)},
          {"transmittance", part(transmittance)},
          {"gaussians",
           {{{"difference", 0.002}, {"below_pixel", true}},
            {{"difference", 0.004}, {"below_pixel", false}},
            {{"difference", 0.2}, {"below_pixel", false}}}}};
}

// Of an error of 2 % a quarter is 0.5 %; the largest difference of all views decides.
TEST(ModelAdvice, NeedsWhatChangesTheTruthByAQuarterOfTheError) {
  const json parts = model_advice({need(0.0, 0.0049), need(0.0, 0.0051)}, 0.02);
  ASSERT_EQ(parts.size(), 5U);
  EXPECT_EQ(parts[0].at("part"), "layers");
  EXPECT_EQ(parts[0].at("needed"), false);
  EXPECT_EQ(parts[1].at("needed"), nullptr);
  EXPECT_EQ(parts[1].at("sentence"), "shadows: not measured: no light casts any");
  EXPECT_EQ(parts[2].at("needed"), false);
  EXPECT_EQ(parts[3].at("needed"), true);
  EXPECT_DOUBLE_EQ(parts[3].at("difference").get<double>(), 0.0051);
  EXPECT_NE(parts[3].at("sentence").get<std::string>().find("0.51 %"), std::string::npos);
  EXPECT_EQ(parts[4].at("views")[0].at("below_pixel"), 1);
  EXPECT_EQ(parts[4].at("views")[0].at("unblurred"), 2);
  EXPECT_DOUBLE_EQ(parts[4].at("views")[0].at("difference").get<double>(), 0.004);
}

}  // namespace
}  // namespace truescatter
