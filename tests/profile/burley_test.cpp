#include "profile/burley.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/exp_sinh.hpp>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <cmath>
#include <string>

#include "core/vec.h"
#include "profile/image_sources.h"
#include "support/error_of.h"

namespace truescatter {
namespace {

// Light within r is 1 - exp(-r/d)/4 - 3 exp(-r/3d)/4 of the albedo (Christensen & Burley 2015).
TEST(Burley, HasItsClosedDistribution) {
  const Burley profile(0.7, 0.4);
  boost::math::quadrature::tanh_sinh<double> rule;
  for (const double r : {0.01, 0.3, 1.0, 7.0}) {
    const double within = 2.0 * kPi * rule.integrate([&](double x) { return x * profile.value(x); }, 0.0, r);
    const double closed = 0.7 * (1.0 - std::exp(-r / 0.4) / 4.0 - 3.0 * std::exp(-r / 1.2) / 4.0);
    EXPECT_NEAR(within, closed, 1e-12) << r;
    EXPECT_NEAR(2.0 * kPi * (profile.antiderivative(r) - profile.antiderivative(0.0)), closed, 1e-14) << r;
  }
}

TEST(Burley, AlbedoIsTheIntegralForEveryMaterial) {
  boost::math::quadrature::exp_sinh<double> rule;
  for (const Material& material : materials()) {
    for (const double eta : {1.3, 1.5}) {
      for (int c = 0; c < 3; ++c) {
        Medium medium = material.channel(c);
        medium.eta = eta;
        for (const BurleyScaling scaling :
             {BurleyScaling::searchlight, BurleyScaling::diffuse, BurleyScaling::diffuse_free_path}) {
          const Burley profile = burley(medium, scaling);
          const double integral =
              2.0 * kPi * rule.integrate([&](double r) { return r * profile.value(r); }, 1e-12);
          EXPECT_NEAR(integral, profile.albedo(), 1e-8) << material.name << " " << c;
          EXPECT_NEAR(profile.albedo(), better_dipole(medium).albedo(), 1e-15);
        }
      }
    }
  }
}

// By hand: at A = 0.8 the first two are 1.85 - 0.8 and 1.9 - 0.8, at A = 0.33 the last is 3.5.
TEST(Burley, ScalesAreThePublishedFormulas) {
  EXPECT_DOUBLE_EQ(burley_scale(0.8, BurleyScaling::searchlight), 1.05);
  EXPECT_DOUBLE_EQ(burley_scale(0.3, BurleyScaling::searchlight), 1.55 + 7.0 * 0.125);
  EXPECT_DOUBLE_EQ(burley_scale(0.8, BurleyScaling::diffuse), 1.1);
  EXPECT_DOUBLE_EQ(burley_scale(0.3, BurleyScaling::diffuse), 1.6 + 3.5 * 0.25);
  EXPECT_DOUBLE_EQ(burley_scale(0.33, BurleyScaling::diffuse_free_path), 3.5);
  EXPECT_NEAR(burley_scale(0.83, BurleyScaling::diffuse_free_path), 3.5 + 6.25, 1e-12);
}

TEST(Burley, RefusesWhatHasNoAnswer) {
  const auto refusal = [](const std::function<void()>& body) {
    const auto error = test::error_of(body);
    return error ? std::string(error->what()) : "accepted";
  };
  EXPECT_EQ(refusal([] { Burley(1.1, 1.0); }), "albedo is 1.1: it must be 0 to 1");
  EXPECT_EQ(refusal([] { Burley(0.5, 0.0); }), "d is 0 mm: it must be above 0, and finite");
  EXPECT_NE(refusal([] {
              burley({0.0, 1.0, 1.3}, BurleyScaling::diffuse_free_path);
            }).find("no diffuse mean free path"),
            std::string::npos);
  EXPECT_EQ(refusal([] { burley({0.0, 1.0, 1.3}, BurleyScaling::searchlight); }), "accepted");
  EXPECT_NE(refusal([] {
              burley({-0.1, 1.0, 1.3}, BurleyScaling::searchlight);
            }).find("sigma_a"),
            std::string::npos);
}

}  // namespace
}  // namespace truescatter
