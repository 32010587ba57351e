// Test vectors marked (table) are those of the project's notes on profiles, by quadrature there.
#include "profile/layered.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/exp_sinh.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "core/vec.h"
#include "profile/image_sources.h"
#include "support/error_of.h"
#include "support/media.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

using test::kMarbleGreen;
using test::kSkin1Green;

// r f(r) is good to 1e-14 / l: rounding of k R(k), whose largest value is below 1 / l, summed over harmonics.
void expect_same(const LayeredProfile& layered, const ImageSources& images, double l_mm) {
  for (const double r : {1e-3, 0.03, 0.2, 1.0, 3.0, 9.0}) {
    EXPECT_NEAR(r * layered.value(r * l_mm) * l_mm, r * images.value(r * l_mm) * l_mm, 1e-14 / l_mm) << r;
    EXPECT_NEAR(layered.antiderivative(r * l_mm), images.antiderivative(r * l_mm), 1e-13) << r;
  }
  EXPECT_NEAR(layered.albedo(), images.albedo(), 1e-14);
}

TEST(Layered, OneEndlessLayerIsTheDipole) {
  for (const Medium& medium : {kSkin1Green, kMarbleGreen, Medium{0.0, 1.0, 1.3}})
    expect_same(LayeredProfile({{medium, kInfinity}}), classical_dipole(medium), medium.mean_free_path_mm());
}

TEST(Layered, OneSlabIsTheMultipole) {
  for (const double thickness_mm : {1.0, 2.0, 5.0}) {
    expect_same(LayeredProfile({{kSkin1Green, thickness_mm}}),
                multipole(kSkin1Green, thickness_mm, SlabSide::lit), kSkin1Green.mean_free_path_mm());
  }
  const SlabResponse slab = slab_response({kSkin1Green, 5.0}, 1.0, 1.0, 0.0);
  EXPECT_NEAR(slab.transmit_above, .0230814, 0.5001e-7);  // (table)
  EXPECT_NEAR(slab.transmit_above, multipole(kSkin1Green, 5.0, SlabSide::far).albedo(), 1e-14);
  EXPECT_EQ(slab.reflect_above, slab.reflect_below);
  EXPECT_NEAR(LayeredProfile({{kSkin1Green, 1.0}}).albedo(), .208822, 0.5001e-6);  // (table)
  EXPECT_NEAR(LayeredProfile({{kMarbleGreen, 1.0}}).albedo(), .52907, 0.5001e-5);  // (table)
}

// The transforms by quadrature of the multipole's own profile, a second route: 2 pi int f J_0(k r) r dr over
// 40 l, beyond which exp(-s_tr r) leaves 1e-16, in panels of l / 4 with 8 nodes, each of which spans less
// than an oscillation.
TEST(Layered, ResponseIsTheHankelTransform) {
  const double l = kSkin1Green.mean_free_path_mm();
  for (const SlabSide side : {SlabSide::lit, SlabSide::far}) {
    const ImageSources profile = multipole(kSkin1Green, 2.0, side);
    for (const double k : {0.0, 0.4, 2.0, 7.0}) {
      double sum = 0.0;
      for (int panel = 0; panel < 320; ++panel) {
        sum += boost::math::quadrature::gauss<double, 8>::integrate(
            [&](double r) { return 2.0 * kPi * r * profile.value(r) * boost::math::cyl_bessel_j(0, k * r); },
            panel * l / 8.0, (panel + 1) * l / 8.0);
      }
      const SlabResponse slab = slab_response({kSkin1Green, 2.0}, 1.0, 1.0, k);
      EXPECT_NEAR(side == SlabSide::lit ? slab.reflect_above : slab.transmit_above, sum, 1e-10) << k;
    }
  }
}

// A slab on top of nothing that sends light back is the slab; a top layer that is optically endless hides
// what is below.
TEST(Layered, StacksHaveTheirLimits) {
  const Medium black{50.0, 1e-6, 1.3};
  EXPECT_NEAR(LayeredProfile({{kSkin1Green, 2.0}, {black, kInfinity}}).albedo(),
              slab_response({kSkin1Green, 2.0}, 1.0, 1.3, 0.0).reflect_above, 1e-7);
  // exp(-2 s_tr d) = exp(-2 * 0.73 * 30) is below rounding.
  EXPECT_NEAR(LayeredProfile({{kSkin1Green, 30.0}, {kMarbleGreen, kInfinity}}).albedo(),
              classical_dipole(kSkin1Green).albedo(), 1e-14);
  // Something bright below sends more back than a black thing.
  EXPECT_GT(LayeredProfile({{kSkin1Green, 2.0}, {{0.001, 2.0, 1.3}, kInfinity}}).albedo(),
            LayeredProfile({{kSkin1Green, 2.0}, {black, kInfinity}}).albedo());
}

// The series of bounces between two slabs, summed term by term: R1 + T1 R2 T1' + T1 R2 R1' R2 T1' + ...
TEST(Layered, TwoSlabsAreTheSumOfTheirBounces) {
  const Layer top{{0.16, 32.0, 1.34}, 0.2};
  const Layer bottom{{0.085, 4.5, 1.4}, 1.5};
  const LayeredProfile stack({top, bottom});
  for (const double k : {0.0, 0.5, 5.0}) {
    const SlabResponse one = slab_response(top, 1.0, 1.4, k);
    const SlabResponse two = slab_response(bottom, 1.34, 1.0, k);
    double light = one.reflect_above;
    double between = one.transmit_above * two.reflect_above;
    for (int i = 0; i < 400; ++i) {
      light += between * one.transmit_below;
      between *= one.reflect_below * two.reflect_above;
    }
    EXPECT_NEAR(stack.response(k), light, 1e-13) << k;
  }
}

TEST(Layered, SkinOfThreeLayersHasItsAlbedoAsAnIntegral) {
  boost::math::quadrature::exp_sinh<double> rule;
  for (const auto& channel : layered_materials().front().channels) {
    const LayeredProfile profile(channel);
    const double integral =
        2.0 * kPi * rule.integrate([&](double r) { return r > 200.0 ? 0.0 : r * profile.value(r); }, 1e-10);
    EXPECT_NEAR(integral, profile.albedo(), 1e-8);
    EXPECT_GT(profile.albedo(), 0.05);
    EXPECT_LT(profile.albedo(), 1.0);
    EXPECT_GT(profile.value(0.3), 0.0);
    double last = std::numeric_limits<double>::infinity();
    // As far as f is above rounding, 1e-15 / (l r).
    for (double r = 1e-3; r * profile.value(r) * profile.shortest_length_mm() > 1e-13; r *= 1.2) {
      EXPECT_LT(profile.value(r), last) << r;  // falls all the way
      last = profile.value(r);
    }
  }
}

constexpr const char* kLayersHeader =
    "thickness_mm,sigma_a_r,sigma_a_g,sigma_a_b,sigma_s_prime_r,sigma_s_prime_g,sigma_s_prime_b,eta\n";

TEST(LayersFile, IsRead) {
  const test::TempDir folder;
  const auto channels = read_layers(
      folder.write("l.csv", std::string(kLayersHeader) + "2,0.1,0.2,0.3,1,2,3,1.4\n0,1,1,1,9,8,7,1.3\n"));
  ASSERT_EQ(channels[1].size(), 2u);
  EXPECT_EQ(channels[1][0].thickness_mm, 2.0);
  EXPECT_EQ(channels[1][0].medium.sigma_a_per_mm, 0.2);
  EXPECT_EQ(channels[2][0].medium.sigma_s_prime_per_mm, 3.0);
  EXPECT_EQ(channels[0][0].medium.eta, 1.4);
  EXPECT_EQ(channels[2][1].thickness_mm, kInfinity);
  EXPECT_EQ(channels[2][1].medium.sigma_s_prime_per_mm, 7.0);
}

TEST(LayersFile, IsRefusedAtTheOffendingRow) {
  const test::TempDir folder;
  const auto refusal = [&](const std::string& rows) {
    const auto path = folder.write("l.csv", kLayersHeader + rows);
    const auto error = test::error_of([&] { read_layers(path); });
    return error ? std::string(error->what()).substr(folder.path().string().size() + 1) : "accepted";
  };
  EXPECT_EQ(refusal(""), "l.csv: there is no layer below the header");
  EXPECT_EQ(refusal("-1,1,1,1,1,1,1,1.3\n"), "l.csv:2:1: -1: a thickness must not be negative");
  EXPECT_EQ(refusal("0,1,1,1,1,1,1,1.3\n9,1,1,1,1,1,1,1.3\n"),
            "l.csv:3: the layer above has no end, and layers follow");
  EXPECT_TRUE(refusal("0.3,1,1,1,1,1,1,1.3\n").starts_with("l.csv:2: the layer is 0.3 mm thick"));
  EXPECT_EQ(refusal("9,1,1,1,1,1,1,0.9\n"), "l.csv:2: eta is 0.9: it must be above 1, and finite");
}

TEST(Layered, RefusesWhatHasNoAnswer) {
  const auto refusal = [](std::vector<Layer> layers) {
    const auto error = test::error_of([&] { LayeredProfile profile(layers); });
    return error ? std::string(error->what()) : "accepted";
  };
  EXPECT_EQ(refusal({}), "a stack needs at least one layer");
  EXPECT_NE(refusal({{kSkin1Green, 0.9}}).find("the layer is 0.9 mm thick"), std::string::npos);
  EXPECT_NE(refusal({{kSkin1Green, kInfinity}, {kSkin1Green, 2.0}}).find("layer 1 has no end"),
            std::string::npos);
  EXPECT_NE(refusal({{{-1.0, 1.0, 1.3}, 2.0}}).find("sigma_a"), std::string::npos);
  EXPECT_NE(refusal({{kSkin1Green, std::nan("")}}).find("the layer is nan mm"), std::string::npos);
}

}  // namespace
}  // namespace truescatter
