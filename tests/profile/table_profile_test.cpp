#include "profile/table_profile.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include "core/vec.h"
#include "profile/gaussian_fit.h"
#include "profile/image_sources.h"
#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

// Three points on a parabola that falls: monotone slopes keep within them.
TEST(TableProfile, PassesThroughItsPointsAndDoesNotOvershoot) {
  const TableProfile profile({0.5, 1.0, 2.0, 4.0, 5.0}, {3.0, 3.0, 1.0, 0.0, 0.0});
  for (const auto& [r, f] : {std::pair(0.5, 3.0), {1.0, 3.0}, {2.0, 1.0}, {4.0, 0.0}, {5.0, 0.0}})
    EXPECT_NEAR(profile.value(r), f, 1e-14);
  EXPECT_EQ(profile.value(0.0), 3.0);
  EXPECT_EQ(profile.value(5.1), 0.0);
  double last = 3.0;
  for (double r = 0.0; r < 6.0; r += 0.01) {
    EXPECT_LE(profile.value(r), last);
    EXPECT_GE(profile.value(r), 0.0);
    last = profile.value(r);
  }
}

// By Gauss-Kronrod quadrature in each interval, which is exact for r times a cubic.
TEST(TableProfile, IntegratesItself) {
  const std::vector<double> radii = {0.1, 0.3, 0.4, 1.0, 2.5};
  const TableProfile profile(radii, {2.0, 1.5, 0.9, 0.7, 0.0});
  double light = 0.5 * 0.01 * 2.0;  // within the first radius
  EXPECT_NEAR(profile.antiderivative(0.1) - profile.antiderivative(0.0), light, 1e-15);
  for (std::size_t i = 0; i + 1 < radii.size(); ++i) {
    light += boost::math::quadrature::gauss_kronrod<double, 15>::integrate(
        [&](double r) { return r * profile.value(r); }, radii[i], radii[i + 1], 0);
    EXPECT_NEAR(profile.antiderivative(radii[i + 1]) - profile.antiderivative(0.0), light, 1e-14);
  }
  EXPECT_NEAR(profile.albedo(), 2.0 * kPi * light, 1e-14);
  EXPECT_EQ(profile.antiderivative(9.0), 0.0);
}

// A dipole that was "measured" finely is fitted as the dipole is: 400 points a decade-and-a-half leave an
// interpolation error of some h^3, (12 / 400)^3 = 3e-5 relative, and constant light within the first radius
// of 1e-3 l leaves less.
TEST(TableProfile, OfADipoleIsFittedAsTheDipole) {
  const ImageSources dipole = classical_dipole({0.17, 0.88, 1.3});
  std::vector<double> radii;
  std::vector<double> values;
  for (int i = 0; i <= 400; ++i) {
    radii.push_back(1e-3 * std::exp(i * 0.0265));
    values.push_back(dipole.value(radii.back()));
  }
  const FitTarget table = fit_target(TableProfile(radii, values));
  const FitTarget closed = fit_target(dipole);
  for (const FitNorm norm : kFitNorms) {
    FitOptions options;
    options.norm = norm;
    const GaussianFit of_table = fit_gaussians({table, table, table}, 3, options);
    const GaussianFit of_dipole = fit_gaussians({closed, closed, closed}, 3, options);
    EXPECT_NEAR(of_table.worst(norm), of_dipole.worst(norm), 1e-4) << name_of(norm);
  }
}

// A table that ends long before its light does: the Gaussians that it was made of, which are wide beside it.
// Cubics through 41 points leave h^4 / 384 of the fourth derivative, (1/20)^4 * 3 / 384 = 5e-8 of f, and more
// where slopes are estimated, h^3 / 12 = 1e-5. Beyond the table R is 0, so light of the fit there is error by
// area.
TEST(TableProfile, MayEndBeforeItsLightDoes) {
  std::vector<double> radii;
  std::array<std::vector<double>, 3> values;
  const double variances[] = {1.0, 2.0, 4.0};
  for (int i = 0; i <= 40; ++i) {
    radii.push_back(0.05 * i);
    for (std::size_t c = 0; c < 3; ++c)
      values[c].push_back(sum_value(std::vector<WeightedGaussian>{{variances[c], 1.0}}, radii.back()));
  }
  const std::array<FitTarget, 3> targets = {fit_target(TableProfile(radii, values[0])),
                                            fit_target(TableProfile(radii, values[1])),
                                            fit_target(TableProfile(radii, values[2]))};
  const GaussianFit fit = fit_gaussians(targets, 3, {});
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(fit.levels[i].variance_mm2, variances[i], 1e-3 * variances[i]);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_LT(fit.errors[c].r.value(), 2e-5);
    const double beyond = std::exp(-2.0 / variances[c]);  // exp(-r^2 / 2v) of the light
    EXPECT_NEAR(fit.errors[c].area, beyond / (1.0 - beyond), 1e-3);
  }
}

class TableFile : public testing::Test {
 protected:
  std::string refusal(const std::string& text) {
    write(text);
    const auto error = test::error_of([&] { read_table_profile(path_); });
    if (!error) return "accepted";
    EXPECT_EQ(error->kind(), ErrorKind::input);
    const std::string what = error->what();
    const std::string folder = path_.parent_path().string() + "/";
    return what.starts_with(folder) ? what.substr(folder.size()) : what;
  }
  void write(const std::string& text) { std::ofstream(path_) << text; }

  test::TempDir folder_;
  std::filesystem::path path_ = folder_.path() / "t.csv";
};

TEST_F(TableFile, IsReadInItsUnit) {
  write("r_mm,r,g,b\n0.5,1,2,3\n1,0.5,0.25,0.125\n");
  const auto mm = read_table_profile(path_);
  EXPECT_DOUBLE_EQ(mm[1].value(0.5), 2.0);
  EXPECT_DOUBLE_EQ(mm[2].value(1.0), 0.125);
  write("r_cm,r,g,b\n0.05,100,200,300\n0.1,50,25,12.5\n");
  const auto cm = read_table_profile(path_);
  write("r_m,r,g,b\n0.0005,1e6,2e6,3e6\n0.001,5e5,2.5e5,1.25e5\n");
  const auto m = read_table_profile(path_);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(cm[c].albedo(), mm[c].albedo(), 1e-14);
    EXPECT_NEAR(m[c].albedo(), mm[c].albedo(), 1e-14);
  }
}

TEST_F(TableFile, IsRefusedAtTheOffendingCell) {
  EXPECT_EQ(refusal("r,R\n0,1\n"), "t.csv:1: \"r,R\" where the header \"r_mm,r,g,b\" is needed");
  EXPECT_TRUE(refusal("r_mm,r,g,b\n0,1,1,1\n1,nan,1,1\n").starts_with("t.csv:3:3: "));
  EXPECT_EQ(refusal("r_mm,r,g,b\n0,1,1,1\n2,1,1,1\n1,1,1,1\n"), "t.csv:4:1: 1 after 2: radii must ascend");
  EXPECT_EQ(refusal("r_mm,r,g,b\n0,1,1,1\n1,1,-0.5,1\n"), "t.csv:3:5: -0.5: R must not be negative");
  EXPECT_EQ(refusal("r_mm,r,g,b\n-1,1,1,1\n"), "t.csv:2:1: -1: a radius must not be negative");
  EXPECT_EQ(refusal("r_mm,r,g,b\n0,1,1,1\n"), "t.csv:2: the table has 1 of at least 2 rows");
  EXPECT_EQ(refusal("r_mm,r,g,b\n0,1,0,1\n1,1,0,1\n"),
            "t.csv: the channel g has no light: every R of it is 0");
}

TEST(TableFit, NeedsAPointForEachUnknown) {
  const FitTarget table = fit_target(TableProfile({0.1, 0.2, 0.5, 1.0, 2.0}, {5.0, 3.0, 1.0, 0.3, 0.05}));
  EXPECT_NO_THROW(fit_gaussians({table, table, table}, 2, {}));
  const auto error = test::error_of([&] { fit_gaussians({table, table, table}, 3, {}); });
  ASSERT_TRUE(error);
  EXPECT_STREQ(error->what(), "3 Gaussians have 6 unknowns a channel, and the table has 5 points");
}

}  // namespace
}  // namespace truescatter
