#include "composite/compositor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "gpu/context.h"

namespace truescatter {
namespace {

const gpu::Context& context() {
  static const gpu::Context shared;
  return shared;
}

const Compositor& compositor() {
  static const Compositor shared(context(), {});
  return shared;
}

CompositorSettings with_curve(ToneCurve curve) { return {kSkinF0, BeckmannEncoding::logarithm, curve}; }

Image random_image(int width, int height, int channels, double low, double high, unsigned seed) {
  std::mt19937 generator(seed);
  Image image(width, height, channels);
  for (float& value : image.data())
    value = static_cast<float>(low + (high - low) * (generator() / 4294967296.0));
  return image;
}

// Pixels of as many surfaces at random: points in front of the eye, unit normals, gloss, light.
struct RandomView {
  static constexpr int kSize = 48;
  Image position = random_image(kSize, kSize, 4, -60.0, 60.0, 1);
  Image normal = random_image(kSize, kSize, 3, -1.0, 1.0, 2);
  Image gloss = random_image(kSize, kSize, 2, 0.1, 1.0, 3);
  Image light = random_image(kSize, kSize, 3, 0.0, 2.0, 4);
  Mat4d world_to_view = Mat4d::Identity();

  RandomView() {
    world_to_view.topLeftCorner<3, 3>() =
        Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()).toRotationMatrix();
    world_to_view.topRightCorner<3, 1>() = Vec3d(5.0, -3.0, -20.0);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        position.at(x, y, 2) -= 300.0F;
        position.at(x, y, 3) = 1.0F;
        normal.set_rgb(x, y, normal.rgb(x, y).normalized());
      }
    }
  }
  SpecularInputs inputs(const std::vector<SeenLight>& lights) const {
    return {world_to_view, position, normal, gloss, lights};
  }
  Vec3d view_direction(int x, int y) const { return -position.rgb(x, y).normalized(); }
};

// The closed form of the lobe behind every pixel, `to_light(x, y)` in view space.
template <typename ToLight>
void expect_lobe(const RandomView& view, const Light& light, BeckmannEncoding encoding, double allowed,
                 const ToLight& to_light) {
  const std::vector<SeenLight> lights = {{light, view.light}};
  const Compositor encoded(context(), {kSkinF0, encoding});
  const Image drawn = encoded.specular_light(view.inputs(lights));
  int lit = 0;
  for (int y = 0; y < RandomView::kSize; ++y) {
    for (int x = 0; x < RandomView::kSize; ++x) {
      const double f = kelemen_specular(view.normal.rgb(x, y), to_light(x, y), view.view_direction(x, y),
                                        view.gloss.at(x, y, 1), kSkinF0);
      const Vec3d expected = kPi * view.gloss.at(x, y, 0) * f * view.light.rgb(x, y);
      const Vec3d found = drawn.rgb(x, y);
      ASSERT_TRUE(found.allFinite());
      ASSERT_LE((found - expected).cwiseAbs().maxCoeff(), allowed * expected.maxCoeff() + 1e-6)
          << x << " " << y;
      if (expected.maxCoeff() > 1e-3) ++lit;
    }
  }
  EXPECT_GT(lit, 100);
}

// The table is within 0.3 % (beckmann_test.cpp). A single float's h.h, where light comes against the view,
// and ln D near -20 add a few 1e-5.
TEST(SpecularLight, IsTheClosedFormOfADirectionalLight) {
  const RandomView view;
  Light light;
  light.direction = Vec3d(0.3, 0.4, 0.866).normalized();
  expect_lobe(view, light, BeckmannEncoding::logarithm, 3.5e-3,
              [&](int, int) -> Vec3d { return view.world_to_view.topLeftCorner<3, 3>() * light.direction; });
}

TEST(SpecularLight, IsTheClosedFormOfAPointLight) {
  const RandomView view;
  Light light;
  light.kind = LightKind::point;
  light.position_mm = Vec3d(40.0, -20.0, 150.0);
  const Vec4d at = view.world_to_view * Vec4d(40.0, -20.0, 150.0, 1.0);
  expect_lobe(view, light, BeckmannEncoding::logarithm, 3.5e-3,
              [&](int x, int y) -> Vec3d { return (at.head<3>() - view.position.rgb(x, y)).normalized(); });
}

TEST(SpecularLight, OfSeveralLightsIsTheirSum) {
  const RandomView view;
  Light one;
  one.direction = Vec3d(0.0, 0.6, 0.8);
  Light other;
  other.kind = LightKind::point;
  other.position_mm = Vec3d(0.0, 200.0, 100.0);
  const Image first = compositor().specular_light(view.inputs({{one, view.light}}));
  const Image second = compositor().specular_light(view.inputs({{other, view.light}}));
  const Image both = compositor().specular_light(view.inputs({{one, view.light}, {other, view.light}}));
  for (std::size_t i = 0; i < both.data().size(); ++i)
    ASSERT_FLOAT_EQ(both.data()[i], first.data()[i] + second.data()[i]);
}

TEST(SpecularLight, IsZeroOffSkinBehindTheSurfaceAndWhereNothingIsSeen) {
  RandomView view;
  Light light;
  for (int y = 0; y < RandomView::kSize; ++y) {
    for (int x = 0; x < RandomView::kSize; ++x) {
      if (x % 3 == 0) view.gloss.at(x, y, 0) = 0.0F;
      if (x % 3 == 1) view.position.at(x, y, 3) = 0.0F;
      if (x % 3 == 2) {
        // The light's side of the normal is turned away, by nothing at least.
        const Vec3d l = view.world_to_view.topLeftCorner<3, 3>() * light.direction;
        const Vec3d n = view.normal.rgb(x, y);
        const Vec3d turned = y % 2 == 0 ? Vec3d(n - std::max(0.0, n.dot(l)) * 1.01 * l) : Vec3d(-l);
        view.normal.set_rgb(x, y, turned.normalized());
      }
    }
  }
  const Image drawn = compositor().specular_light(view.inputs({{light, view.light}}));
  for (const float value : drawn.data()) ASSERT_EQ(value, 0.0F);
}

TEST(SpecularLight, IsFiniteAtGrazingAngles) {
  RandomView view;
  Light light;
  const Vec3d l = view.world_to_view.topLeftCorner<3, 3>() * light.direction;
  for (int y = 0; y < RandomView::kSize; ++y) {
    for (int x = 0; x < RandomView::kSize; ++x) {
      const Vec3d v = view.view_direction(x, y);
      // Across the view, across the light, and both looked along.
      Vec3d n = x % 3 == 0 ? v.cross(l) : x % 3 == 1 ? Vec3d(l - l.dot(v) * v) : Vec3d(v - v.dot(l) * l);
      view.normal.set_rgb(x, y, (n + 1e-6 * (y - 24) * v).normalized());
      view.gloss.at(x, y, 1) = y % 2 == 0 ? 0.1F : 1.0F;
      if (y == 0) {
        const Vec3d against = -300.0 * -l;  // the eye looks straight into the light
        for (int c = 0; c < 3; ++c) view.position.at(x, y, c) = static_cast<float>(against[c]);
      }
    }
  }
  const Image lamp = compositor().specular_light(view.inputs({{light, view.light}}));
  for (const float value : lamp.data()) ASSERT_TRUE(std::isfinite(value) && value >= 0.0F);
  Light everywhere;
  everywhere.kind = LightKind::environment;
  everywhere.environment[0] = Vec3d::Ones();
  const Image sky = compositor().specular_light(view.inputs({{everywhere, view.light}}));
  for (const float value : sky.data()) ASSERT_TRUE(std::isfinite(value) && value >= 0.0F);
}

// Nine terms against the integral over directions: the tables miss the lobe's moments by 6e-4 between their
// values, and by 2e-3 of a steep lobe along the roughness; the quadrature of 300 x 600 directions is good to
// 1e-3.
TEST(SpecularLight, OfAnEnvironmentIsItsIntegral) {
  const RandomView view;
  Light light;
  light.kind = LightKind::environment;
  std::mt19937 generator(7);
  for (std::size_t i = 0; i < 9; ++i) {
    for (int c = 0; c < 3; ++c)
      light.environment[i][c] = (generator() / 4294967296.0 - 0.5) + (i == 0 ? 4.0 : 0.0);
  }
  light.color = Vec3d(1.0, 0.5, 2.0);
  const Image drawn = compositor().specular_light(view.inputs({{light, view.light}}));
  const Mat3d to_world = view.world_to_view.topLeftCorner<3, 3>().transpose();
  int compared = 0;
  for (int y = 0; y < RandomView::kSize; y += 9) {
    for (int x = 0; x < RandomView::kSize; x += 5) {
      const Vec3d n = to_world * view.normal.rgb(x, y);
      const Vec3d v = to_world * view.view_direction(x, y);
      const double m = view.gloss.at(x, y, 1);
      if (n.dot(v) < 0.05 || m < 0.2) continue;
      ++compared;
      const Mat3d frame = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), n).toRotationMatrix();
      constexpr int kSteps = 300;
      Vec3d sum = Vec3d::Zero();
      for (int i = 0; i < kSteps; ++i) {
        const double c = (i + 0.5) / kSteps;
        const double s = std::sqrt(1.0 - c * c);
        for (int j = 0; j < 2 * kSteps; ++j) {
          const double phi = kPi * (j + 0.5) / kSteps;
          const Vec3d w = frame * Vec3d(s * std::cos(phi), s * std::sin(phi), c);
          sum += kelemen_specular(n, w, v, m, kSkinF0) * c * radiance(light.environment, w);
        }
      }
      sum *= kPi / (double(kSteps) * kSteps);
      const Vec3d expected =
          kPi * view.gloss.at(x, y, 0) * sum.cwiseProduct(light.color).cwiseProduct(view.light.rgb(x, y));
      EXPECT_LE((drawn.rgb(x, y) - expected).cwiseAbs().maxCoeff(), 5e-3 * expected.maxCoeff())
          << x << " " << y;
    }
  }
  EXPECT_GT(compared, 10);
}

class ToneCurves : public testing::TestWithParam<ToneCurve> {};

// Single precision: some ten operations of values around 1, 1e-6.
TEST_P(ToneCurves, WithoutSpecularLightAndAlbedoOneShowTheExitance) {
  const Image exitance = random_image(40, 30, 3, -0.1, 3.0, 5);
  const Image white(40, 30, 3, 1.0F);
  const Image dark(40, 30, 3);
  const Image shown = Compositor(context(), with_curve(GetParam())).picture({white, dark, 0.7}, exitance);
  for (std::size_t i = 0; i < shown.data().size(); ++i)
    ASSERT_NEAR(shown.data()[i], tone(GetParam(), 0.7 * exitance.data()[i]), 1e-6);
}

TEST_P(ToneCurves, AddSpecularLightToTheExitanceTimesAlbedo) {
  const Image exitance = random_image(40, 30, 3, 0.0, 1.0, 5);
  const Image albedo = random_image(40, 30, 3, 0.0, 1.0, 6);
  const Image specular = random_image(40, 30, 3, 0.0, 1.0, 7);
  const Image shown =
      Compositor(context(), with_curve(GetParam())).picture({albedo, specular, 1.3}, exitance);
  for (std::size_t i = 0; i < shown.data().size(); ++i) {
    const double light = 1.3 * (double(exitance.data()[i]) * albedo.data()[i] + specular.data()[i]);
    ASSERT_NEAR(shown.data()[i], tone(GetParam(), light), 2e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Both, ToneCurves, testing::Values(ToneCurve::linear, ToneCurve::filmic));

TEST(ToneCurve, ClipsAndGrows) {
  for (const ToneCurve curve : {ToneCurve::linear, ToneCurve::filmic}) {
    EXPECT_EQ(tone(curve, -1.0), 0.0);
    EXPECT_EQ(tone(curve, 0.0), 0.0);
    EXPECT_EQ(tone(curve, 20.0), 1.0);
    for (double x = 0.0; x < 9.0; x += 0.01) EXPECT_LE(tone(curve, x), tone(curve, x + 0.01));
  }
}

}  // namespace
}  // namespace truescatter
