#include "irradiance/environment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "irradiance/shading_mesh.h"
#include "scene/builtin.h"
#include "support/error_of.h"
#include "support/random.h"

namespace truescatter {
namespace {

EnvironmentSh builtin(std::string_view name, double rotation_deg = 0.0) {
  return project_environment(builtin_environment_map(name), rotation_deg);
}

Light environment_light(const EnvironmentSh& environment, bool occlusion, int rays = 1024) {
  Light light;
  light.kind = LightKind::environment;
  light.environment = environment;
  light.shadows = occlusion;
  light.occlusion_rays = rays;
  return light;
}

Vec3d random_direction(std::mt19937_64& generator) {
  const double z = test::uniform(generator, -1.0, 1.0);
  const double phi = test::uniform(generator, 0.0, 2.0 * kPi);
  const double radius = std::sqrt(1.0 - z * z);
  return {radius * std::cos(phi), radius * std::sin(phi), z};
}

// The integral over the hemisphere around z: Gauss-Legendre would do with less, but the midpoint rule in
// cos(theta) and phi needs no tables: second order in cos(theta), exact in phi for low waves.
template <typename F>
double over_upper_hemisphere(const F& f) {
  constexpr int kSteps = 2000;
  constexpr int kTurns = 16;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double z = (i + 0.5) / kSteps;
    for (int k = 0; k < kTurns; ++k) {
      const double phi = 2.0 * kPi * k / kTurns;
      const double radius = std::sqrt(1.0 - z * z);
      sum += f(Vec3d(radius * std::cos(phi), radius * std::sin(phi), z));
    }
  }
  return sum * 2.0 * kPi / (kSteps * kTurns);
}

TEST(SphericalHarmonics, AreOrthonormal) {
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t j = 0; j < 9; ++j) {
      const auto product = [&](const Vec3d& d) {
        return spherical_harmonics(d)[i] * spherical_harmonics(d)[j];
      };
      const double integral =
          over_upper_hemisphere(product) + over_upper_hemisphere([&](const Vec3d& d) { return product(-d); });
      // Midpoint in z: |f''| / 24 / 2000^2, with polynomials of degree 4 whose f'' is below 40.
      EXPECT_NEAR(integral, i == j ? 1.0 : 0.0, 1e-6 * 2.0 * kPi) << i << ", " << j;
    }
  }
  // Their order: l (l + 1) + m, and equation 7 at two directions worked out by hand.
  EXPECT_NEAR(spherical_harmonics(Vec3d::UnitX())[3], std::sqrt(3.0 / (4.0 * kPi)), 1e-12);
  EXPECT_NEAR(spherical_harmonics(Vec3d(0.6, 0.0, 0.8))[6], std::sqrt(5.0 / (16.0 * kPi)) * 0.92, 1e-12);
}

TEST(Environment, AMapOfOneTermGivesItsCoefficientBack) {
  // L = y_i, made a map by the stated convention: column u looks along longitude 2 pi (u - 1/2), from +z
  // towards -x.
  for (std::size_t i = 0; i < 9; ++i) {
    Image map(256, 128, 3);
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 256; ++x) {
        const double polar = kPi * (y + 0.5) / 128;
        const double longitude = 2.0 * kPi * ((x + 0.5) / 256 - 0.5);
        const Vec3d d(-std::sin(polar) * std::sin(longitude), std::cos(polar),
                      std::sin(polar) * std::cos(longitude));
        map.set_rgb(x, y, spherical_harmonics(d)[i] * Vec3d(1.0, 2.0, -3.0));
      }
    }
    const EnvironmentSh environment = project_environment(map, 0.0);
    for (std::size_t j = 0; j < 9; ++j) {
      // Pixels of 0.0245: the midpoint rule is off by 0.0245^2 / 24 times a second derivative below 40 that
      // is integrated over the sphere; times 3.
      EXPECT_LT((environment[j] - (i == j ? 1.0 : 0.0) * Vec3d(1.0, 2.0, -3.0)).norm(), 0.01) << i << j;
    }
  }
}

TEST(Environment, TurnsAboutTheVertical) {
  // The key of side-key stands at +x, +y, +z; turned by 90 degrees, from +z towards +x, what was at +z is at
  // +x and what was at +x is at -z.
  const EnvironmentSh before = builtin("side-key");
  const EnvironmentSh after = builtin("side-key", 90.0);
  std::mt19937_64 generator(5);
  for (int i = 0; i < 20; ++i) {
    const Vec3d d = random_direction(generator);
    EXPECT_LT((radiance(after, Vec3d(d.z(), d.y(), -d.x())) - radiance(before, d)).norm(), 1e-12);
  }
  EXPECT_GT(radiance(before, Vec3d::UnitX()).x(), 3.0 * radiance(before, -Vec3d::UnitX()).x());
}

TEST(Environment, UnknownBuiltinNamesThePlace) {
  const auto error = test::error_of([] { builtin_environment_map("studio", {"e.toml", 7, 4}); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind(), ErrorKind::input);
  EXPECT_EQ(std::string(error->what()),
            "e.toml:7:4: \"studio\" is not a built-in environment: uniform, overcast, sky-ground, side-key, "
            "sunset");
}

TEST(EnvironmentIrradiance, UnoccludedIsTheIntegralOfTheNineTermLight) {
  std::mt19937_64 generator(3);
  for (const BuiltinEnvironment& builtin_environment : builtin_environments()) {
    const EnvironmentSh environment = builtin(builtin_environment.name);
    const EnvironmentIrradiance irradiance(environment, 0);
    const Vec3d bound = irradiance.largest_possible();
    for (int i = 0; i < 10; ++i) {
      const Vec3d normal = random_direction(generator);
      const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), normal);
      Vec3d expected;
      for (Eigen::Index c = 0; c < 3; ++c) {
        expected[c] =
            over_upper_hemisphere([&](const Vec3d& d) { return d.z() * radiance(environment, turn * d)[c]; });
      }
      // The midpoint rule as above, for a radiance below 1.
      EXPECT_LT((irradiance.unoccluded(normal) - expected.cwiseMax(0.0)).cwiseAbs().maxCoeff(), 1e-5)
          << builtin_environment.name;
      EXPECT_GE((bound - irradiance.unoccluded(normal)).minCoeff(), 0.0) << builtin_environment.name;
    }
  }
  // The unit: a surface under the uniform environment has irradiance 1. The map's pixels sum to the sphere
  // exactly; the terms beyond the first are the midpoint's error over pixels of 0.0245.
  const Vec3d uniform = EnvironmentIrradiance(builtin("uniform"), 0).unoccluded(Vec3d(0.6, 0.0, 0.8));
  EXPECT_NEAR(uniform.x(), 1.0, 1e-3);
}

// The inside of a box without a lid: floor at z = 0, half as wide as `half`, `height` deep. Vertex 0 is the
// floor's middle.
Mesh open_box(double half, double height) {
  Mesh mesh;
  mesh.positions_mm.push_back(Vec3d::Zero());
  const std::array<Vec2d, 4> corners{Vec2d(-half, -half), Vec2d(half, -half), Vec2d(half, half),
                                     Vec2d(-half, half)};
  for (const Vec2d& c : corners) mesh.positions_mm.emplace_back(c.x(), c.y(), 0.0);
  for (const Vec2d& c : corners) mesh.positions_mm.emplace_back(c.x(), c.y(), height);
  for (int i = 0; i < 4; ++i) {
    const int next = (i + 1) % 4;
    mesh.triangles.push_back({0, 1 + i, 1 + next});
    mesh.triangles.push_back({1 + next, 1 + i, 5 + i});
    mesh.triangles.push_back({1 + next, 5 + i, 5 + next});
  }
  set_angle_weighted_normals(mesh, 30.0);
  return mesh;
}

// The error of the sum over directions: each stands for a cell of 4 pi / rays, and one that the border of
// what is seen crosses counts whole or not at all: off by up to half, evenly, an RMS of 1 / sqrt(12). With b
// cells along the border, as if by chance: sqrt(b / 12) cells. The border is `border_rad` long, and crosses a
// cell in each of its diameters.
double ray_error(int rays, double border_rad) {
  const double cell = 4.0 * kPi / rays;
  const double diameter = std::sqrt(4.0 * cell / kPi);
  return std::sqrt(border_rad / diameter / 12.0) * cell;
}

TEST(EnvironmentIrradiance, OcclusionInAHalfOpenBoxIsItsClosedForm) {
  // From the floor's middle the opening is a square of half width a at height c, and g_i = integral over it
  // of cos(theta) y_i dw with dw = c / r^3 dx dy, cos(theta) = c / r. For i = 0 that is pi y_0 times the
  // configuration factor of four rectangles over their common corner, each, with X = a / c,
  //   (1 / 2 pi) 2 X / sqrt(1 + X^2) atan(X / sqrt(1 + X^2))
  // For the others the smooth integrand is summed by Simpson's rule, 200 x 200, good to 1e-9; i = 0 tests it.
  constexpr double kHalf = 10.0;
  constexpr double kHeight = 20.0;
  constexpr int kSteps = 200;
  ShBasis expected{};
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const auto weight = [](int k) { return k == 0 || k == kSteps ? 1.0 : k % 2 == 1 ? 4.0 : 2.0; };
      const Vec3d to(kHalf * (2.0 * i / kSteps - 1.0), kHalf * (2.0 * j / kSteps - 1.0), kHeight);
      const double r2 = to.squaredNorm();
      const double share = weight(i) * weight(j) / 9.0 * std::pow(2.0 * kHalf / kSteps, 2);
      const ShBasis basis = spherical_harmonics(to.normalized());
      for (std::size_t k = 0; k < 9; ++k) expected[k] += share * kHeight * kHeight / (r2 * r2) * basis[k];
    }
  }
  const double x = kHalf / kHeight;
  const double root = std::sqrt(1.0 + x * x);
  const double factor = 4.0 / (2.0 * kPi) * 2.0 * x / root * std::atan(x / root);
  ASSERT_NEAR(expected[0], kPi * 0.5 / std::sqrt(kPi) * factor, 1e-8);

  const Mesh box = open_box(kHalf, kHeight);
  // The opening's edges, each seen under 2 atan(a / sqrt(c^2 + a^2)).
  const double border_rad = 4.0 * 2.0 * std::atan(kHalf / std::hypot(kHalf, kHeight));
  for (const int rays : {1024, 16384, 65536}) {
    for (std::size_t i = 0; i < 9; ++i) {
      // A light of the i-th term alone shows g_i; where it is negative its negative light does.
      EnvironmentSh environment = dark_environment();
      environment[i].setConstant(expected[i] < 0.0 ? -1.0 : 1.0);
      const Lighting lighting(box, {environment_light(environment, true, rays)});
      const double g = lighting.irradiance({0, Vec3d(1.0, 0.0, 0.0)}).x();
      // |y_i| is at most sqrt(5 / 4 pi) = 0.63 (i = 6) or 0.55 and 0.49, the cosine 1 at most. The ray starts
      // 1e-4 of the box's 20 mm above the floor, which moves the opening's edges by 1e-4.
      EXPECT_NEAR(g, std::abs(expected[i]), 0.63 * (4.0 * ray_error(rays, border_rad) + 1e-4 * border_rad))
          << "term " << i << ", " << rays << " rays";
    }
  }
}

TEST(EnvironmentIrradiance, EqualsAMonteCarloIntegralOfTheSameLight) {
  // In the corner of two half squares that meet at 70 degrees (seen from their inside): every point has a
  // part of its sky hidden. The integral by random directions, evenly over the cosine, of pi L V.
  const Mesh wedge = make_builtin("wedge", {{"dihedral_deg", 290.0}, {"edge_mm", 10.0}});
  const EnvironmentSh environment = builtin("sky-ground");
  constexpr int kRays = 16384;
  constexpr int kDraws = 20000;
  const Lighting lighting(wedge, {environment_light(environment, true, kRays)});
  const Lighting open(wedge, {environment_light(environment, false)});
  const ShadowScene shadows(wedge);
  std::mt19937_64 generator(11);
  double squares = 0.0;
  double hidden = 0.0;
  constexpr int kPoints = 40;
  for (int i = 0; i < kPoints; ++i) {
    const MeshPoint point{generator() % wedge.triangle_count(), test::random_barycentric(generator)};
    const Vec3d normal = interpolated_normal(wedge, point);
    const Vec3d origin = position_mm(wedge, point) + shadows.offset_mm(point.triangle) * normal;
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), normal);
    Vec3d sum = Vec3d::Zero();
    Vec3d sum2 = Vec3d::Zero();
    for (int k = 0; k < kDraws; ++k) {
      const double sine = std::sqrt(test::uniform(generator));
      const double phi = test::uniform(generator, 0.0, 2.0 * kPi);
      const Vec3d d = turn * Vec3d(sine * std::cos(phi), sine * std::sin(phi), std::sqrt(1.0 - sine * sine));
      if (shadows.occluded(origin, d, std::numeric_limits<double>::infinity())) continue;
      const Vec3d value = kPi * radiance(environment, d);
      sum += value;
      sum2 += value.cwiseAbs2();
    }
    const Vec3d mean = sum / kDraws;
    const Vec3d variance = (sum2 / kDraws - mean.cwiseAbs2()) / kDraws;
    const Vec3d irradiance = lighting.irradiance(point);
    // The border of the hidden part is at most two great half circles; the radiance is below 0.55.
    const double rays = 0.55 * ray_error(kRays, 2.0 * kPi);
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double error_bar = std::sqrt(variance[c] + rays * rays);
      EXPECT_NEAR(irradiance[c], mean[c], 4.5 * error_bar) << "point " << i << ", channel " << c;
    }
    squares += std::pow(irradiance.x() - mean.x(), 2) / (variance.x() + rays * rays);
    hidden += open.irradiance(point).x() - irradiance.x();
  }
  // Not by too wide an error bar: the mean of 40 squares of standard normals is 1 +- sqrt(2 / 40); were the
  // bars those of the rays alone it would be less.
  EXPECT_LT(squares / kPoints, 1.0 + 4.0 * std::sqrt(2.0 / kPoints));
  EXPECT_GT(hidden / kPoints, 0.02);  // and something was hidden
}

TEST(EnvironmentIrradiance, IsRefinedIntoTheShadingMeshLikeAnyLight) {
  // The back card sees less where the front card is above it. Every midpoint and centroid is within 2 % of
  // the largest possible irradiance, and smooth in between; a direction that is newly hidden is 0.4 % of it.
  const Mesh cards = make_builtin("cards", {{"edge_mm", 10.0}});
  const Lighting lighting(cards, {environment_light(builtin("uniform"), true)});
  const ShadingMesh shading = make_shading_mesh(cards, lighting, {}, {0.02, 0.4});
  EXPECT_GT(shading.triangles.size(), cards.triangle_count());
  const ShadingResidual residual = measure_residual(shading, lighting, 2000, 1);
  EXPECT_LT(residual.p99, 0.03);
  double darkest = 1.0;
  for (const ShadingTriangle& t : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_GE(t.irradiance[c].minCoeff(), 0.0);
      darkest = std::min(darkest, t.irradiance[c].x());
    }
  }
  // In the middle of the covered half, 15 mm in from the edge under a card 20 mm up: less than half is left.
  EXPECT_LT(darkest, 0.5);
  const ShadingMesh unoccluded = make_shading_mesh(
      cards, Lighting(cards, {environment_light(builtin("uniform"), false)}), {}, {0.02, 0.4});
  EXPECT_EQ(unoccluded.triangles.size(),
            cards.triangle_count());  // flat cards under one light: nothing to split
}

TEST(EnvironmentIrradiance, IsAddedToOtherLightsAndTakesTheirColour) {
  const Mesh plane = make_builtin("plane");
  Light red = environment_light(builtin("uniform"), true);
  red.color = Vec3d(1.0, 0.0, 0.0);
  Light lamp;
  lamp.direction = Vec3d::UnitZ();
  const MeshPoint point{5, Vec3d(0.2, 0.3, 0.5)};
  const Vec3d both = Lighting(plane, {red, lamp}).irradiance(point);
  EXPECT_NEAR(both.x(), 2.0, 1e-3);  // the map's pixels, as above
  EXPECT_NEAR(both.y(), 1.0, 1e-12);
}

}  // namespace
}  // namespace truescatter
