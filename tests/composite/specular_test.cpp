#include "composite/specular.h"

#include <gtest/gtest.h>

#include <cmath>

namespace truescatter {
namespace {

const Vec3d kNormal = Vec3d::UnitZ();

Vec3d leaning(double cosine, double phi = 0.0) {
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

// The moments once more, by the midpoint rule over directions of light: nothing is drawn from the lobe.
SpecularMoments by_direction(double n_v, double m, double f0, int steps) {
  const Vec3d view = leaning(n_v);
  SpecularMoments sum;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < 2 * steps; ++j) {
      const Vec3d light = leaning((i + 0.5) / steps, kPi * (j + 0.5) / steps);
      const double solid_angle = kPi / (double(steps) * steps);
      const double weight = kelemen_specular(kNormal, light, view, m, f0) * light.z() * solid_angle;
      sum.albedo += weight;
      sum.x += weight * light.x();
      sum.n += weight * light.z();
      sum.xx += weight * light.x() * light.x();
      sum.nn += weight * light.z() * light.z();
      sum.xn += weight * light.x() * light.z();
    }
  }
  return sum;
}

TEST(Fresnel, IsF0AtNormalIncidenceAndOneAtGrazing) {
  EXPECT_DOUBLE_EQ(schlick_fresnel(1.0, 0.028), 0.028);
  EXPECT_DOUBLE_EQ(schlick_fresnel(0.0, 0.028), 1.0);
}

TEST(KelemenSpecular, IsReciprocal) {
  for (const double m : {0.1, 0.3, 1.0}) {
    const Vec3d a = leaning(0.8, 0.3);
    const Vec3d b = leaning(0.4, 2.0);
    EXPECT_DOUBLE_EQ(kelemen_specular(kNormal, a, b, m, 0.028), kelemen_specular(kNormal, b, a, m, 0.028));
  }
}

TEST(KelemenSpecular, IsZeroWhereLightIsBelowTheSurface) {
  for (const double n_l : {0.0, -1e-6, -0.5, -1.0})
    EXPECT_EQ(kelemen_specular(kNormal, leaning(n_l), leaning(0.9), 0.3, 0.028), 0.0) << n_l;
}

TEST(KelemenSpecular, IsFiniteAtGrazingAngles) {
  for (const double n_l : {1e-12, 1e-3, 1.0}) {
    for (const double n_v : {-0.2, 0.0, 1e-12, 1e-3, 1.0}) {
      for (const double phi : {0.0, 1.0, kPi}) {
        const double f = kelemen_specular(kNormal, leaning(n_l, phi), leaning(n_v), 0.1, 0.028);
        EXPECT_TRUE(std::isfinite(f) && f >= 0.0) << n_l << " " << n_v << " " << phi;
      }
    }
  }
}

// Both sums meet kinks where N.L = 0 and, seen at grazing angles, light that varies fast: their errors fall
// with the square of the steps. Halving the second's changes it by 3e-4 of the lobe at most, so it is good to
// 1e-4, and the first at four times its 96 steps to a sixteenth of 5e-4.
TEST(SpecularMoments, AreThoseOfTheLobe) {
  for (const double m : {0.2, 0.4, 1.0}) {
    for (const double n_v : {0.02, 0.3, 0.7, 1.0}) {
      const SpecularMoments a = specular_moments(n_v, m, 0.028, 384);
      const SpecularMoments b = by_direction(n_v, m, 0.028, 1200);
      const double allowed = 3e-4 * std::max(b.albedo, 0.1);
      EXPECT_NEAR(a.albedo, b.albedo, allowed) << m << " " << n_v;
      EXPECT_NEAR(a.x, b.x, allowed) << m << " " << n_v;
      EXPECT_NEAR(a.n, b.n, allowed) << m << " " << n_v;
      EXPECT_NEAR(a.xx, b.xx, allowed) << m << " " << n_v;
      EXPECT_NEAR(a.nn, b.nn, allowed) << m << " " << n_v;
      EXPECT_NEAR(a.xn, b.xn, allowed) << m << " " << n_v;
      EXPECT_NEAR(specular_moments(n_v, m, 0.028).albedo, a.albedo, 5e-4) << m << " " << n_v;
    }
  }
}

// No more light leaves than comes: at every roughness and angle, and even if facets reflected nearly all.
TEST(SpecularMoments, ReflectLessThanComes) {
  for (int i = 0; i <= 18; ++i) {
    const double m = 0.1 + 0.05 * i;
    for (int j = 0; j <= 100; ++j) {
      const double n_v = j / 100.0;
      EXPECT_LT(specular_moments(n_v, m, kSkinF0).albedo, 1.0) << m << " " << n_v;
      EXPECT_GT(specular_moments(n_v, m, kSkinF0).albedo, 0.0) << m << " " << n_v;
    }
    EXPECT_LT(by_direction(0.01, m, kSkinF0, 150).albedo, 1.0) << m;
  }
}

// Smooth and seen along the normal, the lobe reflects what its facets do.
TEST(SpecularMoments, OfAMirrorAreFresnels) {
  EXPECT_NEAR(specular_moments(1.0, 0.1, 0.028).albedo, 0.028, 0.028 * 0.02);
}

}  // namespace
}  // namespace truescatter
