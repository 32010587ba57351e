#include "report/fit_plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "support/error_of.h"

namespace truescatter {
namespace {

nlohmann::json document() {
  nlohmann::json fit = {
      {"asked", {{"title", "a <b> & c"}}},
      {"variances", {1.0}},
      {"error", {{"r", {nullptr, 0.1, 0.1}}, {"area", {0.1, 0.1, 0.1}}, {"r2", {0.1, 0.1, 0.1}}}},
      {"curve", {{"r_mm", {0.01, 0.1, 1.0}}}}};
  fit["curve"]["profile"] = {{1.0, 1.0, 0.0}, {0.5, 0.5, 0.0}, {0.1, 0.0, 0.0}};
  fit["curve"]["fit"] = {{1.0, 0.9, 0.0}, {0.5, 0.6, 0.0}, {0.1, 0.0, 0.0}};
  return fit;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

TEST(FitPlot, DrawsWhatIsOnItsAxes) {
  const std::string svg = fit_plot_svg(document().dump());
  EXPECT_NE(svg.find("a &lt;b> &amp; c: 1 Gaussian<"), std::string::npos);
  EXPECT_NE(svg.find("r none"), std::string::npos);
  // Red and green profile and fit above; below, green's error, too dark first and then too bright. Blue is
  // dark, red is exact.
  EXPECT_EQ(count(svg, "class=\"line\""), 6u);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  // r = 0.1 lies halfway between 74 and 740 px, on a decade axis from 0.01 to 1.
  EXPECT_NE(svg.find("407.0"), std::string::npos);
}

TEST(FitPlot, SaysWhereTheFitIsFrom) {
  nlohmann::json fit = document();
  EXPECT_EQ(fit_plot_svg(fit.dump()).find("<desc>"), std::string::npos);
  fit["provenance"] = {{"version", "1.2"}, {"commit", "abc"}, {"commit_dirty", true}};
  EXPECT_NE(fit_plot_svg(fit.dump()).find("<desc>fitted by truescatter 1.2 (abc with changes)</desc>"),
            std::string::npos);
}

TEST(FitPlot, RefusesWhatHasNoCurve) {
  nlohmann::json fit = document();
  fit.erase("curve");
  EXPECT_TRUE(test::error_of([&] { fit_plot_svg(fit.dump()); }));
  EXPECT_TRUE(test::error_of([] { fit_plot_svg("no JSON"); }));
}

}  // namespace
}  // namespace truescatter
