#include "profile/profile.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace truescatter {
namespace {

GaussianTerm shared_term(double variance_mm2, const Vec3d& weight) {
  return {Vec3d::Constant(variance_mm2), weight};
}

// Mikkelsen 2010, table 1: spike 15/18/20 %, the base takes the rest.
Profile spike_and_base() {
  Profile profile;
  profile.name = "spike-and-base";
  profile.title = "Spike and base (Mikkelsen)";
  profile.source = "Mikkelsen 2010, table 1; its 'variance' read as a variance in mm^2";
  profile.delta_weight = {0.15, 0.18, 0.20};
  profile.terms = {{Vec3d(2.3, 1.4, 1.1), Vec3d(0.85, 0.82, 0.80)}};
  profile.r_max_mm = 4.5;
  return profile;
}

Profile spike_and_base_sigma() {
  Profile profile = spike_and_base();
  profile.name = "spike-and-base-sigma";
  profile.title = "Spike and base (Mikkelsen), wide reading";
  profile.source = "Mikkelsen 2010, table 1; its 'variance' read as a standard deviation in mm";
  for (GaussianTerm& term : profile.terms)
    term.variance_mm2 = term.variance_mm2.cwiseProduct(term.variance_mm2);
  return profile;
}

// Yang et al. figure 2, after d'Eon & Luebke 2007. Each column sums to 1. (Public copies carry 0.366 for the
// second green weight; then green sums to 1.03.)
Profile skin_six_gaussian() {
  Profile profile;
  profile.name = "skin-six-gaussian";
  profile.title = "Skin, six Gaussians (d'Eon & Luebke)";
  profile.source = "Yang et al., figure 2, after d'Eon & Luebke 2007";
  profile.terms = {shared_term(0.0064, {0.233, 0.455, 0.649}), shared_term(0.0484, {0.100, 0.336, 0.344}),
                   shared_term(0.187, {0.118, 0.198, 0.0}),    shared_term(0.567, {0.113, 0.007, 0.007}),
                   shared_term(1.99, {0.358, 0.004, 0.0}),     shared_term(7.41, {0.078, 0.0, 0.0})};
  // Three standard deviations of the widest Gaussian, which is the "roughly 8 mm" that Mikkelsen section 5
  // quotes from d'Eon & Luebke.
  profile.r_max_mm = 3.0 * std::sqrt(7.41);
  return profile;
}

// d'Eon & Luebke 2007: four Gaussians for the green of marble. Their red and blue are not published.
Profile marble_green_four_gaussian() {
  Profile profile;
  profile.name = "marble-green-four-gaussian";
  profile.title = "Marble, green alone, four Gaussians (d'Eon & Luebke)";
  profile.source = "d'Eon & Luebke 2007; fitted to a dipole of Jensen et al. 2001's marble, green";
  profile.terms = {shared_term(0.036, {0.0, 0.070, 0.0}), shared_term(0.14, {0.0, 0.18, 0.0}),
                   shared_term(0.91, {0.0, 0.21, 0.0}), shared_term(7.0, {0.0, 0.29, 0.0})};
  profile.r_max_mm = 3.0 * std::sqrt(7.0);
  return profile;
}

}  // namespace

Vec3d Profile::total_weight() const {
  Vec3d total = delta_weight;
  for (const GaussianTerm& term : terms) total += term.weight;
  return total;
}

double Profile::widest_std_dev_mm() const {
  double widest_mm = 0.0;
  for (const GaussianTerm& term : terms) {
    for (int c = 0; c < 3; ++c) {
      if (term.weight[c] != 0.0) widest_mm = std::max(widest_mm, std::sqrt(term.variance_mm2[c]));
    }
  }
  return widest_mm;
}

double GaussianLevel::std_dev_mm() const { return std::sqrt(variance_mm2); }

std::vector<GaussianLevel> gaussian_levels(const Profile& profile) {
  std::map<double, Vec3d> by_variance;
  for (const GaussianTerm& term : profile.terms) {
    for (int c = 0; c < 3; ++c) {
      if (term.weight[c] == 0.0) continue;
      by_variance.try_emplace(term.variance_mm2[c], Vec3d::Zero()).first->second[c] += term.weight[c];
    }
  }
  std::vector<GaussianLevel> levels;
  for (const auto& [variance_mm2, weight] : by_variance) levels.push_back({variance_mm2, weight});
  return levels;
}

Profile sum_of_gaussians(const std::string& name, const std::vector<GaussianLevel>& levels) {
  constexpr double kRadiusStdDevs = 3.0;
  Profile profile;
  profile.name = name;
  for (const GaussianLevel& level : levels)
    profile.terms.push_back(shared_term(level.variance_mm2, level.weight));
  profile.r_max_mm = kRadiusStdDevs * profile.widest_std_dev_mm();
  return profile;
}

const std::vector<Profile>& builtin_profiles() {
  static const std::vector<Profile> profiles = {spike_and_base(), spike_and_base_sigma(),
                                                skin_six_gaussian()};
  return profiles;
}

const std::vector<Profile>& published_sums() {
  static const std::vector<Profile> sums = {skin_six_gaussian(), marble_green_four_gaussian()};
  return sums;
}

Profile scaled(const Profile& profile, double factor) {
  Profile result = profile;
  for (GaussianTerm& term : result.terms) term.variance_mm2 *= factor * factor;
  result.r_max_mm *= factor;
  return result;
}

}  // namespace truescatter
