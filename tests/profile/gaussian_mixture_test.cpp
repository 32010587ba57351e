#include "profile/gaussian_mixture.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <string>

#include "support/error_of.h"

namespace truescatter {
namespace {

double mixture_at(const GaussianMixture& mixture, int channel, double r) {
  double sum = 0.0;
  for (const GaussianLevel& level : mixture.levels)
    sum += level.weight[channel] * std::exp(-0.5 * r * r / level.variance_mm2) /
           (2.0 * kPi * level.variance_mm2);
  return sum;
}

// int |f - mixture| 2 pi r dr over r from 1e-5 mm to 1000 mm: 20 Gauss-Legendre nodes on each of 4000 panels
// of equal ratio. The difference oscillates once or so for each step of the mixture, a ratio of exp(0.1) or
// more, against a panel's exp(0.005): the quadrature's error lies at the changes of sign alone, 1e-3 of the
// result.
double area_error(const ImageSources& profile, const GaussianMixture& mixture, int channel) {
  constexpr int kPanels = 4000;
  const double ratio = std::log(1e8) / kPanels;
  double sum = 0.0;
  for (int i = 0; i < kPanels; ++i) {
    const double from = std::log(1e-5) + i * ratio;
    sum += boost::math::quadrature::gauss<double, 20>::integrate(
        [&](double log_r) {
          const double r = std::exp(log_r);
          return std::abs(profile.value(r) - mixture_at(mixture, channel, r)) * 2.0 * kPi * r * r;
        },
        from, from + ratio);
  }
  return sum;
}

std::array<ImageSources, 3> channels_of(const std::string& name, ImageSources (*profile)(const Medium&)) {
  for (const Material& m : materials())
    if (m.name == name) return {profile(m.channel(0)), profile(m.channel(1)), profile(m.channel(2))};
  throw std::runtime_error("no material " + name);
}

ImageSources exact_better_dipole(const Medium& medium) { return better_dipole(medium); }
ImageSources slab(const Medium& medium) { return multipole(medium, 3.0, SlabSide::lit); }
ImageSources behind_slab(const Medium& medium) { return multipole(medium, 3.0, SlabSide::far); }

struct Case {
  const char* name;
  std::array<ImageSources, 3> channels;
};

std::vector<Case> cases() {
  return {{"skin1, classical", channels_of("skin1", classical_dipole)},
          {"marble, classical", channels_of("marble", classical_dipole)},
          {"ketchup, classical", channels_of("ketchup", classical_dipole)},
          {"cream, better", channels_of("cream", exact_better_dipole)},
          {"skin2, better", channels_of("skin2", exact_better_dipole)},
          {"skin1, slab", channels_of("skin1", slab)},
          {"marble, behind a slab", channels_of("marble", behind_slab)}};
}

// 1e-12: f's own rounding over 1e8 in r.
TEST(GaussianMixture, KeepsItsBound) {
  for (const Case& profile : cases()) {
    for (const double tolerance : {1e-2, 1e-4, 1e-7}) {
      const GaussianMixture mixture = gaussian_mixture(profile.channels, tolerance);
      for (int c = 0; c < 3; ++c) {
        const double error = area_error(profile.channels[static_cast<std::size_t>(c)], mixture, c);
        EXPECT_LE(error, 1.001 * mixture.error_bound[c] + 1e-12)
            << profile.name << " " << tolerance << " " << c;
        EXPECT_LE(mixture.error_bound[c], tolerance) << profile.name << " " << c;
      }
    }
  }
}

// Each Gaussian has mass 1, so the weights sum to the albedo.
TEST(GaussianMixture, WeightsSumToTheAlbedo) {
  for (const Case& profile : cases()) {
    const GaussianMixture mixture = gaussian_mixture(profile.channels, 1e-10);
    Vec3d total = Vec3d::Zero();
    double before = 0.0;
    for (const GaussianLevel& level : mixture.levels) {
      EXPECT_GT(level.variance_mm2, before);
      before = level.variance_mm2;
      total += level.weight;
    }
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(total[static_cast<Eigen::Index>(c)], profile.channels[c].albedo(), 1e-10) << profile.name;
  }
}

// A dipole's two sources are both positive mixtures.
TEST(GaussianMixture, OfAClassicalDipoleIsPositive) {
  for (const GaussianLevel& level : gaussian_mixture(channels_of("skin1", classical_dipole), 1e-6).levels)
    EXPECT_GE(level.weight.minCoeff(), 0.0);
}

// Without absorption weights fall off only as the standard deviation's inverse.
TEST(GaussianMixture, NeedsNoAbsorption) {
  const ImageSources dipole = classical_dipole({0.0, 1.0, 1.3});
  const GaussianMixture mixture = gaussian_mixture({dipole, dipole, dipole}, 1e-4);
  EXPECT_LE(mixture.error_bound.maxCoeff(), 1e-4);
  EXPECT_LE(area_error(dipole, mixture, 0), 1.001 * mixture.error_bound[0]);
}

TEST(GaussianMixture, RefusesWhatItCannotReach) {
  const auto dipoles = channels_of("skin1", classical_dipole);
  for (const double tolerance : {0.0, 1e-13, 0.2, std::nan("")}) {
    const auto error = test::error_of([&] { gaussian_mixture(dipoles, tolerance); });
    ASSERT_TRUE(error) << tolerance;
    EXPECT_EQ(error->kind(), ErrorKind::input);
  }
  const ImageSources white = better_dipole({0.0, 1.0, 1.3});
  EXPECT_TRUE(test::error_of([&] { gaussian_mixture({white, white, white}, 1e-4); }));
}

}  // namespace
}  // namespace truescatter
