// Test vectors marked (table) are those of the project's notes on profiles: Jensen et al. 2001 for the
// coefficients, and totals and moments that were computed there by quadrature, to the digits given.
#include "profile/image_sources.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/exp_sinh.hpp>
#include <cmath>
#include <string>

#include "support/error_of.h"
#include "support/media.h"

namespace truescatter {
namespace {

using test::error_of;
using test::kMarbleGreen;
using test::kSkin1Green;

const Material& material(const std::string& name) {
  for (const Material& m : materials())
    if (m.name == name) return m;
  throw std::runtime_error("no material " + name);
}

// d'Eon's polynomials for the moments of internal reflection, eta > 1.
FresnelMoments polynomial_moments(double n) {
  const double n2 = n * n;
  const double n3 = n2 * n;
  return {-9.23372 + 22.2272 * n - 20.9292 * n2 + 10.2291 * n3 - 2.54396 * n2 * n2 + 0.254913 * n2 * n3,
          -1641.1 + 135.926 / n3 - 656.175 / n2 + 1376.53 / n + 1213.67 * n - 568.556 * n2 + 164.798 * n3 -
              27.0181 * n2 * n2 + 1.91826 * n2 * n3};
}

TEST(Materials, TotalsAreThoseOfTheTable) {
  struct Row {
    const char* name;
    Vec3d classical;
    Vec3d better;  // with the polynomial moments
  };
  const std::vector<Row> rows = {{"marble", {.8302, .7910, .7526}, {.8346, .7944, .7544}},
                                 {"skin1", {.4360, .2273, .1310}, {.4050, .1629, .0702}},
                                 {"skin2", {.6226, .4333, .3435}, {.6181, .4018, .2954}},
                                 {"whole-milk", {.9077, .8809, .7594}, {.9121, .8859, .7638}},
                                 {"skim-milk", {.8149, .8130, .6823}, {.8204, .8184, .6828}},
                                 {"apple", {.8464, .8407, .5279}, {.8519, .8462, .5118}},
                                 {"cream", {.9757, .9000, .7247}, {.9772, .9046, .7277}},
                                 {"ketchup", {.1638, .0063, .0018}, {.0991, .0004, 0.0}}};
  ASSERT_EQ(materials().size(), rows.size());
  for (const Row& row : rows) {
    const Material& m = material(row.name);
    for (int c = 0; c < 3; ++c) {
      const Medium medium = m.channel(c);
      // Four digits are given.
      EXPECT_NEAR(classical_dipole(medium).albedo(), row.classical[c], 0.5001e-4) << row.name << " " << c;
      EXPECT_NEAR(better_dipole(medium, polynomial_moments(m.eta)).albedo(), row.better[c], 0.5001e-4)
          << row.name << " " << c;
      // The exact moments change a total by up to 2e-4 (table).
      EXPECT_NEAR(better_dipole(medium).albedo(), row.better[c], 2.5e-4) << row.name << " " << c;
    }
  }
  const Vec3d skin1(.4048, .1628, .0701);
  const Vec3d marble(.8345, .7943, .7543);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(better_dipole(material("skin1").channel(c)).albedo(), skin1[c], 0.5001e-4) << c;
    EXPECT_NEAR(better_dipole(material("marble").channel(c)).albedo(), marble[c], 0.5001e-4) << c;
  }
}

TEST(FresnelMoments, AreThoseOfTheTable) {
  EXPECT_NEAR(internal_fresnel_moments(1.3).two_c1, .444457, 0.5001e-6);
  EXPECT_NEAR(internal_fresnel_moments(1.3).three_c2, .300267, 0.5001e-6);
  EXPECT_NEAR(internal_fresnel_moments(1.4).two_c1, .528985, 0.5001e-6);
  EXPECT_NEAR(internal_fresnel_moments(1.4).three_c2, .388783, 0.5001e-6);
  EXPECT_NEAR(internal_fresnel_moments(1.5).two_c1, .596346, 0.5001e-6);
  EXPECT_NEAR(internal_fresnel_moments(1.5).three_c2, .464431, 0.5001e-6);
}

// Without a jump of the index nothing is reflected; with an endless one, all of it.
TEST(FresnelMoments, HaveTheRightLimits) {
  EXPECT_LT(internal_fresnel_moments(1.0 + 1e-9).two_c1, 1e-6);
  EXPECT_LT(internal_fresnel_moments(1.0 + 1e-9).three_c2, 1e-6);
  // What leaves does so within the critical angle: 2 int mu dmu over it is 1/eta^2, and 1.5 times that for
  // the other moment.
  EXPECT_NEAR(internal_fresnel_moments(1000.0).two_c1, 1.0, 1e-6);
  EXPECT_NEAR(internal_fresnel_moments(1000.0).three_c2, 1.0, 1.5e-6);
}

// Rd = a'/2 (1 + exp(-(4/3) A sqrt(3 (1 - a')))) exp(-sqrt(3 (1 - a'))), A and Fdr as in Jensen et al. 2001.
TEST(ClassicalDipole, TotalIsTheClosedForm) {
  for (const Medium& medium : {kSkin1Green, kMarbleGreen, Medium{2.0, 0.1, 1.4}, Medium{0.0, 1.0, 1.3}}) {
    const double fdr = -1.440 / (medium.eta * medium.eta) + 0.710 / medium.eta + 0.668 + 0.0636 * medium.eta;
    const double a = (1.0 + fdr) / (1.0 - fdr);
    const double root = std::sqrt(3.0 * (1.0 - medium.reduced_albedo()));
    EXPECT_NEAR(classical_dipole(medium).albedo(),
                0.5 * medium.reduced_albedo() * (1.0 + std::exp(-4.0 / 3.0 * a * root)) * std::exp(-root),
                1e-14);
  }
}

// Without absorption a' = 1, and all comes back: for the better dipole C_E + 2 A C_phi = 1.
TEST(Dipoles, KeepEnergyWithoutAbsorption) {
  EXPECT_NEAR(classical_dipole({0.0, 2.0, 1.4}).albedo(), 1.0, 1e-14);
  EXPECT_NEAR(better_dipole({0.0, 2.0, 1.4}).albedo(), 1.0, 1e-13);
  // And the limit is reached smoothly.
  EXPECT_NEAR(better_dipole({1e-14, 2.0, 1.4}).albedo(), 1.0, 1e-6);
}

TEST(Multipole, IsThatOfTheTable) {
  const auto back = [&](double thickness_mm) {
    return multipole(kSkin1Green, thickness_mm, SlabSide::lit).albedo();
  };
  EXPECT_NEAR(back(1.0), .208822, 0.5001e-6);
  EXPECT_NEAR(back(2.0), .223054, 0.5001e-6);
  EXPECT_NEAR(back(5.0), .227278, 0.5001e-6);
  EXPECT_NEAR(classical_dipole(kSkin1Green).albedo(), .2273312, 0.5001e-7);
  EXPECT_NEAR(back(1e3), classical_dipole(kSkin1Green).albedo(), 1e-14);
  EXPECT_NEAR(multipole(kSkin1Green, 5.0, SlabSide::far).albedo(), .0230814, 0.5001e-7);
  EXPECT_NEAR(multipole(kMarbleGreen, 1.0, SlabSide::lit).albedo(), .52907, 0.5001e-5);
}

// A slab loses what it absorbs: sigma_a times its fluence, which hardly changes while sigma_a is small. So
// twice the absorption loses twice as much, but for a relative s_tr^2 d^2 of 1e-4 * 3 * 25 = 1 %.
TEST(Multipole, LosesWhatItAbsorbs) {
  const auto lost = [](double sigma_a) {
    const Medium medium{sigma_a, 1.0, 1.4};
    // The source holds a', as single scattering has already been taken away.
    return medium.reduced_albedo() - multipole(medium, 5.0, SlabSide::lit).albedo() -
           multipole(medium, 5.0, SlabSide::far).albedo();
  };
  EXPECT_GT(lost(1e-4), 0.0);
  EXPECT_NEAR(lost(2e-4) / lost(1e-4), 2.0, 0.02);
}

std::vector<ImageSources> all_kinds() {
  return {classical_dipole(kSkin1Green),
          classical_dipole(kMarbleGreen),
          classical_dipole({0.0, 1.0, 1.3}),
          better_dipole(kSkin1Green),
          better_dipole(kMarbleGreen),
          better_dipole({0.0, 1.0, 1.5}),
          better_dipole({1.0, 0.1, 1.4}),
          multipole(kSkin1Green, 1.0, SlabSide::lit),
          multipole(kSkin1Green, 1.0, SlabSide::far),
          multipole(kMarbleGreen, 0.5, SlabSide::far)};
}

// The five-point difference of F. F is analytic within d = sqrt(r^2 + z^2) of r, where it is at most some
// |F(0)|; with a step of d/300 Cauchy's bound leaves (4 / 5!) 5! (1/300)^4 |F| / d = 5e-10 |F| / d, and
// rounding of F 300 times 1e-15 of it.
TEST(ImageSources, DerivativeOfTheAntiderivativeIsRTimesTheProfile) {
  for (const ImageSources& profile : all_kinds()) {
    const double z = profile.shortest_length_mm();
    for (const double r : {0.05, 0.3, 1.0, 2.0, 7.0}) {
      const double d = std::hypot(r, z);
      const double h = d / 300.0;
      const auto f = [&](double at) { return profile.antiderivative(std::abs(at)); };
      const double slope = (8.0 * (f(r + h) - f(r - h)) - (f(r + 2.0 * h) - f(r - 2.0 * h))) / (12.0 * h);
      EXPECT_NEAR(slope, r * profile.value(r), 1e-9 * std::abs(profile.antiderivative(0.0)) / d) << r;
    }
  }
}

// 2 pi int r f dr by double-exponential quadrature of f itself.
TEST(ImageSources, AlbedoIsTheIntegral) {
  for (const ImageSources& profile : all_kinds()) {
    if (profile.s_tr_per_mm() == 0.0) continue;  // falls off as a power: not for this rule
    boost::math::quadrature::exp_sinh<double> rule;
    const double integral = 2.0 * kPi * rule.integrate([&](double r) { return r * profile.value(r); }, 1e-12);
    EXPECT_NEAR(integral, profile.albedo(), 1e-10);
    EXPECT_NEAR(profile.antiderivative(60.0 / profile.s_tr_per_mm()), 0.0, 1e-24);
  }
}

// To 1e-8, far above what the quadrature leaves.
TEST(ImageSources, AlbedoIsTheIntegralForEveryMaterial) {
  boost::math::quadrature::exp_sinh<double> rule;
  for (const Material& m : materials()) {
    for (const double eta : {1.3, 1.5}) {
      for (int c = 0; c < 3; ++c) {
        Medium medium = m.channel(c);
        medium.eta = eta;
        const double slab_mm = 3.0 * medium.mean_free_path_mm();
        for (const ImageSources& profile :
             {classical_dipole(medium), better_dipole(medium), multipole(medium, slab_mm, SlabSide::lit),
              multipole(medium, slab_mm, SlabSide::far)}) {
          const double integral =
              2.0 * kPi * rule.integrate([&](double r) { return r * profile.value(r); }, 1e-12);
          EXPECT_NEAR(integral, profile.albedo(), 1e-8) << m.name << " " << eta << " " << c;
        }
      }
    }
  }
}

TEST(ImageSources, RefuseWhatHasNoAnswer) {
  const auto refusal = [](const Medium& medium) {
    const auto error = error_of([&] { better_dipole(medium); });
    return error ? std::string(error->what()) : "accepted";
  };
  EXPECT_EQ(refusal({-0.1, 1.0, 1.3}), "sigma_a (1/mm) is -0.1: it must be 0 or more, and finite");
  EXPECT_EQ(refusal({0.1, -1.0, 1.3}), "sigma_s' (1/mm) is -1: it must be above 0, and finite");
  EXPECT_EQ(refusal({0.1, 0.0, 1.3}), "sigma_s' (1/mm) is 0: it must be above 0, and finite");
  EXPECT_EQ(refusal({0.1, 1.0, 1.0}), "eta is 1: it must be above 1, and finite");
  EXPECT_EQ(refusal({0.1, 1.0, std::nan("")}), "eta is nan: it must be above 1, and finite");
  const double l = kSkin1Green.mean_free_path_mm();
  for (const double thickness : {0.5 * l, l, -1.0, 0.0}) {
    const auto error = error_of([&] { multipole(kSkin1Green, thickness, SlabSide::lit); });
    ASSERT_TRUE(error) << thickness;
    EXPECT_EQ(error->kind(), ErrorKind::input);
    EXPECT_NE(std::string(error->what()).find("no thicker than its mean free path"), std::string::npos);
  }
  EXPECT_GT(multipole(kSkin1Green, 1.001 * l, SlabSide::far).albedo(), 0.0);
  const auto error = error_of([] { multipole({0.0, 1.0, 1.3}, 2.0, SlabSide::lit); });
  ASSERT_TRUE(error);
  EXPECT_NE(std::string(error->what()).find("absorbs so little"), std::string::npos);
}

}  // namespace
}  // namespace truescatter
