#include "experiment/profile_model.h"

#include <gtest/gtest.h>

#include "support/error_of.h"

namespace truescatter::test {
namespace {

ProfileModelSpec spec_of(const std::string& model, const std::string& material) {
  ProfileModelSpec spec;
  spec.model = model;
  spec.material = material;
  spec.where = {"e.toml", 3, 9};
  spec.material_where = {"e.toml", 4, 12};
  return spec;
}

std::filesystem::path no_file(const std::string& path, const SourceLocation&) {
  throw std::runtime_error("no file is asked for: " + path);
}

ProfileModel model_of(const ProfileModelSpec& spec, const std::string& name) {
  return make_profile_model(make_diffusion_profile(spec, no_file), name);
}

// Albedos as published beside the materials (by quadrature, four digits or six): half of the last digit, and
// 2e-4 more for the better dipole's, which took polynomial moments.
TEST(ProfileModel, HasThePublishedAlbedo) {
  const ProfileModel classical = model_of(spec_of("classical-dipole", "skin1"), "p");
  EXPECT_LE((classical.albedo - Vec3d(0.4360, 0.2273, 0.1310)).cwiseAbs().maxCoeff(), 0.5e-4);
  const ProfileModel better = model_of(spec_of("better-dipole", "skin1"), "p");
  EXPECT_LE((better.albedo - Vec3d(0.4050, 0.1629, 0.0702)).cwiseAbs().maxCoeff(), 2.5e-4);
  ProfileModelSpec slab = spec_of("multipole", "skin1");
  slab.thickness_mm = 2.0;
  EXPECT_NEAR(model_of(slab, "p").albedo[1], 0.223054, 0.5e-6);
}

// The weights of the mixture sum to its albedo, and its bound is within the tolerance.
TEST(ProfileModel, IsNoFartherFromItsMixtureThanTheBound) {
  for (const char* model : {"classical-dipole", "better-dipole"}) {
    for (const double tolerance : {1e-3, 1e-6}) {
      ProfileModelSpec spec = spec_of(model, "skin2");
      spec.tolerance = tolerance;
      const ProfileModel made = model_of(spec, "p");
      const Vec3d off = (made.mixture.total_weight() - made.albedo).cwiseAbs();
      EXPECT_TRUE((off.array() <= made.error_bound.array()).all()) << model << " " << off.transpose();
      EXPECT_LE(made.error_bound.maxCoeff(), tolerance) << model;
    }
  }
}

TEST(ProfileModel, SaysWhatItIs) {
  EXPECT_EQ(model_of(spec_of("better-dipole", "skin2"), "p").title, "better dipole of skin2");
  ProfileModelSpec slab = spec_of("multipole", "");
  slab.sigma_a_per_mm = Vec3d(0.5, 0.25, 0.5);
  slab.sigma_s_prime_per_mm = Vec3d::Constant(2.0);
  slab.thickness_mm = 1.5;
  EXPECT_EQ(model_of(slab, "p").title,
            "multipole of sigma_a [0.5, 0.25, 0.5], sigma_s' 2 1/mm, eta 1.3, a slab of 1.5 mm");
}

TEST(ProfileModel, RefusesWhatHasNoAnswerAtItsLine) {
  const auto unknown = error_of([] { model_of(spec_of("classical-dipole", "chalk"), "p"); });
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->kind(), ErrorKind::input);
  EXPECT_TRUE(std::string(unknown->what())
                  .starts_with("e.toml:4:12: there is no material 'chalk'; there are: marble, skin1, "))
      << unknown->what();
  ProfileModelSpec thin = spec_of("multipole", "skin1");
  thin.thickness_mm = 0.5;
  const auto slab = error_of([&] { model_of(thin, "p"); });
  ASSERT_TRUE(slab);
  EXPECT_EQ(slab->kind(), ErrorKind::input);
  EXPECT_TRUE(std::string(slab->what()).starts_with("e.toml:3:9: the slab is 0.5 mm thick: "))
      << slab->what();
}

}  // namespace
}  // namespace truescatter::test
