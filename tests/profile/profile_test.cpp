#include "profile/profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace truescatter {
namespace {

const Profile& builtin(const std::string& name) {
  const std::vector<Profile>& all = builtin_profiles();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Profile& p) { return p.name == name; });
  if (found == all.end()) throw std::runtime_error("no profile " + name);
  return *found;
}

// The radial second moment, integral of r^2 R(r) dA = 2 sum of w v: each Gaussian's is 2 v, delta's is 0.
Vec3d second_moment_mm2(const Profile& profile) {
  Vec3d sum = Vec3d::Zero();
  for (const GaussianTerm& term : profile.terms) sum += 2.0 * term.weight.cwiseProduct(term.variance_mm2);
  return sum;
}

// Published weights have three decimals, so the true sums are exactly 1; six additions of numbers below 1
// round by at most 6 * 1.1e-16, and the decimals' own conversion by as much: far below 1e-12.
TEST(BuiltinProfiles, KeepEnergy) {
  ASSERT_FALSE(builtin_profiles().empty());
  for (const Profile& profile : builtin_profiles()) {
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(profile.total_weight()[c], 1.0, 1e-12) << profile.name << " " << c;
  }
}

TEST(BuiltinProfiles, HaveDistinctNamesSourcesAndUsableNumbers) {
  std::set<std::string> names;
  for (const Profile& profile : builtin_profiles()) {
    EXPECT_TRUE(names.insert(profile.name).second) << profile.name;
    EXPECT_FALSE(profile.source.empty()) << profile.name;
    EXPECT_GT(profile.r_max_mm, 0.0) << profile.name;
    double last = 0.0;
    for (const GaussianTerm& term : profile.terms) {
      EXPECT_GT(term.variance_mm2.minCoeff(), 0.0) << profile.name;
      EXPECT_GE(term.weight.minCoeff(), 0.0) << profile.name;
      EXPECT_GE(term.variance_mm2.x(), last) << profile.name << ": terms ascend in the red variance";
      last = term.variance_mm2.x();
    }
  }
}

// Yang et al. figure 2. Red: 2 (0.233*0.0064 + 0.100*0.0484 + 0.118*0.187 + 0.113*0.567 + 0.358*1.99
// + 0.078*7.41) = 2 * 1.3828682 = 2.7657364; green 0.1362588; blue 0.0495444. The bounds are half a unit of
// the last digit of the values as quoted, 2.7657 / 0.13626 / 0.04954 mm^2.
TEST(SkinSixGaussian, HasThePublishedSecondMoments) {
  const Vec3d moment = second_moment_mm2(builtin("skin-six-gaussian"));
  EXPECT_NEAR(moment.x(), 2.7657, 0.5e-4);
  EXPECT_NEAR(moment.y(), 0.13626, 0.5e-5);
  EXPECT_NEAR(moment.z(), 0.04954, 0.5e-5);
}

// The typo of public copies is 0.366 in the second green weight, which makes green sum to 1.03.
TEST(SkinSixGaussian, HasTheRightGreenWeight) {
  EXPECT_EQ(builtin("skin-six-gaussian").terms[1].weight.y(), 0.336);
}

// Mikkelsen 2010, table 1.
TEST(SpikeAndBase, HoldsTheTablesNumbers) {
  const Profile& profile = builtin("spike-and-base");
  ASSERT_EQ(profile.terms.size(), 1U);
  EXPECT_EQ(profile.delta_weight, Vec3d(0.15, 0.18, 0.20));
  EXPECT_EQ(profile.terms[0].weight, Vec3d(0.85, 0.82, 0.80));
  EXPECT_EQ(profile.terms[0].variance_mm2, Vec3d(2.3, 1.4, 1.1));
  EXPECT_EQ(profile.r_max_mm, 4.5);
  EXPECT_DOUBLE_EQ(profile.widest_std_dev_mm(), std::sqrt(2.3));
}

TEST(SpikeAndBase, TheSigmaReadingSquaresTheNumbers) {
  const Profile& profile = builtin("spike-and-base-sigma");
  const Vec3d std_dev = profile.terms[0].std_dev_mm();
  EXPECT_DOUBLE_EQ(std_dev.x(), 2.3);
  EXPECT_DOUBLE_EQ(std_dev.y(), 1.4);
  EXPECT_DOUBLE_EQ(std_dev.z(), 1.1);
  EXPECT_DOUBLE_EQ(profile.terms[0].variance_mm2.x(), 5.29);  // 2.3^2
  EXPECT_EQ(profile.delta_weight, builtin("spike-and-base").delta_weight);
}

Profile of_terms(std::vector<GaussianTerm> terms) {
  Profile profile;
  profile.terms = std::move(terms);
  profile.r_max_mm = 2.0;
  return profile;
}

// Red and blue of the first term share v = 4 with the second's green; the second's blue has no weight, so its
// v = 9 makes no level.
TEST(GaussianLevels, MergesEqualVariancesAndOrdersThem) {
  const std::vector<GaussianLevel> levels = gaussian_levels(of_terms(
      {{Vec3d(4.0, 1.0, 4.0), Vec3d(0.5, 0.25, 0.125)}, {Vec3d(4.0, 4.0, 9.0), Vec3d(0.25, 0.5, 0.0)}}));
  ASSERT_EQ(levels.size(), 2U);
  EXPECT_EQ(levels[0].variance_mm2, 1.0);
  EXPECT_EQ(levels[0].weight, Vec3d(0.0, 0.25, 0.0));
  EXPECT_EQ(levels[1].variance_mm2, 4.0);
  EXPECT_EQ(levels[1].weight, Vec3d(0.75, 0.5, 0.125));
  EXPECT_EQ(levels[1].std_dev_mm(), 2.0);
}

TEST(GaussianLevels, KeepTheWeightsOfEveryProfile) {
  for (const Profile& profile : builtin_profiles()) {
    Vec3d sum = profile.delta_weight;
    double last = 0.0;
    for (const GaussianLevel& level : gaussian_levels(profile)) {
      EXPECT_GT(level.variance_mm2, last) << profile.name;
      last = level.variance_mm2;
      sum += level.weight;
    }
    // The same numbers summed in another order: a rounding for each of at most eight terms.
    EXPECT_LT((sum - profile.total_weight()).cwiseAbs().maxCoeff(), 8 * 1.2e-16) << profile.name;
  }
}

TEST(WidestStdDev, IgnoresVariancesWithoutWeight) {
  const Profile profile = of_terms({{Vec3d(1.0, 4.0, 100.0), Vec3d(1.0, 1.0, 0.0)}});
  EXPECT_EQ(profile.widest_std_dev_mm(), 2.0);
}

// Lengths scale by the factor: variances by its square. 2 and 4 are exact in binary.
TEST(Scaled, ScalesEveryLengthAndNoWeight) {
  for (const Profile& profile : builtin_profiles()) {
    const Profile twice = scaled(profile, 2.0);
    EXPECT_EQ(twice.r_max_mm, 2.0 * profile.r_max_mm);
    EXPECT_EQ(twice.widest_std_dev_mm(), 2.0 * profile.widest_std_dev_mm());
    EXPECT_EQ(twice.total_weight(), profile.total_weight());
    EXPECT_EQ(twice.delta_weight, profile.delta_weight);
    ASSERT_EQ(twice.terms.size(), profile.terms.size());
    for (std::size_t i = 0; i < profile.terms.size(); ++i) {
      EXPECT_EQ(twice.terms[i].variance_mm2, 4.0 * profile.terms[i].variance_mm2);
    }
  }
}

}  // namespace
}  // namespace truescatter
