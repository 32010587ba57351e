// Polygons of a plane under light that is linear on the plane, against integrals over strips.
//
// With x the offset from the foot of the perpendicular in units of s, phi the normal density and Phi its
// integral, Green's theorem gives, for the counter-clockwise boundary and a point at height h,
//   int G I dA = -exp(-h^2 / 2 s^2) sum over edges int phi(x) [(i0 + gx x) Phi(y) - gy phi(y)] dx:
// one smooth integral along each edge, by Gauss-Legendre with 16 nodes on panels of s/4, which leaves
// (1/4)^32 / 32! of it. Neither Owen's T nor the angles of the engines' formula occur in it.
#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "support/sampling.h"
#include "truth/exact.h"
#include "truth/fast.h"

namespace truescatter {
namespace {

using test::uniform;

double density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi); }
double distribution(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

// Irradiance i0 + slope.x of each channel at x in the plane.
struct LinearLight {
  Vec3d i0;
  Vec3d slope_x;
  Vec3d slope_y;
  Vec3d at(const Vec2d& x) const { return i0 + x.x() * slope_x + x.y() * slope_y; }
};

// (M_r, M_g, M_b, m) of the polygon, seen from `height` above the plane's point `foot`.
Vec4d by_strips(const std::vector<Vec2d>& polygon, const LinearLight& light, const Vec2d& foot, double height,
                double s) {
  using Gauss = boost::math::quadrature::gauss<double, 16>;
  const Vec3d at_foot = light.at(foot);
  Vec4d sum = Vec4d::Zero();
  for (std::size_t e = 0; e < polygon.size(); ++e) {
    const Vec2d a = (polygon[e] - foot) / s;
    const Vec2d b = (polygon[(e + 1) % polygon.size()] - foot) / s;
    const int panels = 1 + static_cast<int>(4.0 * (b - a).norm());
    for (int i = 0; i < panels; ++i) {
      for (std::size_t k = 0; k < Gauss::abscissa().size(); ++k) {
        for (const double sign : {-1.0, 1.0}) {
          const double t = (i + 0.5 + 0.5 * sign * Gauss::abscissa()[k]) / panels;
          const Vec2d x = a + t * (b - a);
          const double weight = -0.5 * Gauss::weights()[k] / panels * (b.x() - a.x()) * density(x.x());
          sum.head<3>() += weight * ((at_foot + s * x.x() * light.slope_x) * distribution(x.y()) -
                                     s * light.slope_y * density(x.y()));
          sum[3] += weight * distribution(x.y());
        }
      }
    }
  }
  return sum * std::exp(-0.5 * (height / s) * (height / s));
}

// A polygon that sees all of itself from `middle`, as a fan of triangles there; each cut in four `cuts`
// times.
struct Scene {
  std::vector<Vec2d> polygon;
  Surface surface;
};

Scene star(std::mt19937_64& generator, int corners, double radius, double roughness, const LinearLight& light,
           const std::array<Vec3d, 3>& frame, int cuts) {
  Scene scene;
  const Vec2d middle(uniform(generator) - 0.5, uniform(generator) - 0.5);
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * kPi * (i + 0.4 * uniform(generator)) / corners;
    const double r = radius * (1.0 - roughness * uniform(generator));
    scene.polygon.emplace_back(middle + r * Vec2d(std::cos(angle), std::sin(angle)));
  }
  const auto add = [&](const auto& self, const Vec2d& a, const Vec2d& b, const Vec2d& c, int level) -> void {
    if (level > 0) {
      const Vec2d ab = 0.5 * (a + b);
      const Vec2d bc = 0.5 * (b + c);
      const Vec2d ca = 0.5 * (c + a);
      self(self, a, ab, ca, level - 1);
      self(self, ab, b, bc, level - 1);
      self(self, ca, bc, c, level - 1);
      self(self, ab, bc, ca, level - 1);
      return;
    }
    SurfaceTriangle triangle;
    const std::array<Vec2d, 3> corner = {a, b, c};
    for (std::size_t i = 0; i < 3; ++i) {
      triangle.corners_mm[i] = frame[0] + corner[i].x() * frame[1] + corner[i].y() * frame[2];
      triangle.irradiance[i] = light.at(corner[i]);
    }
    scene.surface.triangles.push_back(triangle);
  };
  for (std::size_t i = 0; i < scene.polygon.size(); ++i)
    add(add, middle, scene.polygon[i], scene.polygon[(i + 1) % scene.polygon.size()], cuts);
  return scene;
}

// Light of at most about 1; the frame is at most 3 mm off the origin, so that positions round by 4e-16 mm.
TEST(PolygonClosedForm, LinearLightOnStars) {
  std::mt19937_64 generator(5);
  double worst = 0.0;
  double worst_relative = 0.0;
  for (const double s : {0.3, 1.0, 2.2}) {
    for (int trial = 0; trial < 12; ++trial) {
      const Vec3d tilt = Vec3d(uniform(generator), uniform(generator), 0.2 + uniform(generator)).normalized();
      const Vec3d u = tilt.unitOrthogonal();
      const std::array<Vec3d, 3> frame = {Vec3d(1.0, -2.0, 1.5), u, tilt.cross(u)};
      const LinearLight light{Vec3d(0.5, 0.6, 0.4), Vec3d(0.05, -0.04, 0.1), Vec3d(0.02, 0.07, -0.06)};
      const Scene scene = star(generator, 3 + trial, trial % 2 == 0 ? 4.0 : 1.2, trial % 3 == 0 ? 0.7 : 0.2,
                               light, frame, trial % 3);
      const ExactEngine exact(scene.surface);
      std::vector<std::pair<Vec2d, double>> points;
      for (int i = 0; i < 6; ++i)
        points.emplace_back(4.0 * Vec2d(uniform(generator) - 0.5, uniform(generator) - 0.5), 0.4 * i * s);
      points.emplace_back(scene.polygon[0], 0.0);
      points.emplace_back(0.5 * (scene.polygon[1] + scene.polygon[2]), 0.0);
      points.emplace_back(scene.polygon[1] + 0.1 * (scene.polygon[1] - scene.polygon[2]), 0.0);
      for (const auto& [foot, height] : points) {
        const Vec3d at = frame[0] + foot.x() * frame[1] + foot.y() * frame[2] + height * tilt;
        const Vec4d expected = by_strips(scene.polygon, light, foot, height, s);
        const Vec4d found = exact.convolve({at, 0}, {s});
        worst = std::max(worst, (found - expected).cwiseAbs().maxCoeff());
        EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-11) << "s " << s << " star " << trial;
        if (!(expected[3] > 1e-3)) continue;
        const double relative = std::max(std::abs(found[3] / expected[3] - 1.0),
                                         (found / found[3] - expected / expected[3]).cwiseAbs().maxCoeff());
        worst_relative = std::max(worst_relative, relative);
        EXPECT_LE(relative, 1e-11) << "s " << s << " star " << trial;
      }
    }
  }
  RecordProperty("worst", std::to_string(worst));
  std::printf("polygons: off by at most %.1e of the light, %.1e relative\n", worst, worst_relative);
}

TEST(PolygonClosedForm, FastEngineKeepsItsTolerance) {
  std::mt19937_64 generator(6);
  const LinearLight light{Vec3d(0.5, 0.6, 0.4), Vec3d(0.05, -0.04, 0.1), Vec3d(0.02, 0.07, -0.06)};
  const std::array<Vec3d, 3> frame = {Vec3d::Zero(), Vec3d::UnitX(), Vec3d::UnitY()};
  for (int trial = 0; trial < 6; ++trial) {
    const Scene scene = star(generator, 7, 4.0, 0.5, light, frame, trial);
    const double unit = scene.surface.largest_irradiance();
    const std::vector<TruthLayer> layers = {{0.1}, {0.4}, {1.3}};
    std::vector<SurfacePoint> points;
    for (int i = 0; i < 40; ++i)
      points.push_back({5.0 * Vec3d(uniform(generator) - 0.5, uniform(generator) - 0.5, 0.0), 0});
    for (const double tolerance : {1e-4, 1e-6, 1e-9}) {
      const TruthValues found = FastEngine(scene.surface, tolerance).convolve(points, layers);
      for (std::size_t l = 0; l < layers.size(); ++l) {
        for (std::size_t i = 0; i < points.size(); ++i) {
          const Vec4d expected =
              by_strips(scene.polygon, light, points[i].position_mm.head<2>(), 0.0, layers[l].std_dev_mm);
          const Vec4d difference = (found[l][i] - expected).cwiseAbs();
          EXPECT_LE(difference.head<3>().maxCoeff(), tolerance * unit);
          EXPECT_LE(difference[3], tolerance);
        }
      }
    }
  }
}

}  // namespace
}  // namespace truescatter
