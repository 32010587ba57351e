#include "truth/needle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/sampling.h"
#include "truth/brute.h"
#include "truth/exact.h"
#include "truth/fast.h"

namespace truescatter {
namespace {

using test::random_vec;
using test::uniform;

// A triangle of this height over its longest edge, somewhere in space.
SurfaceTriangle random_needle(std::mt19937_64& generator, double length, double height) {
  const Vec3d along = random_vec(generator, 1.0).normalized();
  const Vec3d across = random_vec(generator, 1.0).cross(along).normalized();
  const Vec3d start = random_vec(generator, 0.5);
  SurfaceTriangle t;
  t.corners_mm = {start, start + length * along,
                  start + uniform(generator, 0.0, 1.0) * length * along + height * across};
  for (Vec3d& value : t.irradiance) value = random_vec(generator, 1.0).cwiseAbs();
  return t;
}

// Against plain quadrature: both are off by rounding, and with a cut-off by what needle.h states.
TEST(Needle, EqualsPlainQuadrature) {
  std::mt19937_64 generator(21);
  for (int i = 0; i < 120; ++i) {
    const double s = std::exp(uniform(generator, std::log(0.2), std::log(2.0)));
    const double height = s * std::pow(10.0, uniform(generator, -9.0, -2.0));
    Surface surface;
    surface.triangles.push_back(random_needle(generator, uniform(generator, 0.1, 6.0), height));
    const SurfaceTriangle& t = surface.triangles[0];
    Vec3d b = random_vec(generator, 1.0).cwiseAbs();
    b /= b.sum();
    Vec3d point = b[0] * t.corners_mm[0] + b[1] * t.corners_mm[1] + b[2] * t.corners_mm[2];
    if (i % 3 == 0) point += random_vec(generator, s);
    TruthLayer layer{s};
    if (i % 2 == 0) layer.r_max_mm = uniform(generator, 0.1, 3.0) * s;
    const double at_ends = i % 2 == 0 ? 1e-3 * std::pow(height / s, 3) : 0.0;
    const Vec4d expected = BruteEngine(surface, 1e-13).convolve({point, 0}, layer);
    EXPECT_LE((convolve_needle(t, point, layer) - expected).cwiseAbs().maxCoeff(), 2e-13 + at_ends)
        << "height/s " << height / s << " r_max/s " << layer.r_max_mm / s;
  }
}

// Where the engines pass from the boundary formula to the quadrature, the value does not jump. The formula is
// off by some 1e-15 s / height there.
TEST(Needle, MeetsTheBoundaryFormula) {
  std::mt19937_64 generator(23);
  for (const double r_max : {std::numeric_limits<double>::infinity(), 1.3}) {
    const TruthLayer layer{1.0, r_max};
    const double limit = std::isfinite(r_max) ? 1e-3 : 1e-2;
    for (int i = 0; i < 40; ++i) {
      const SurfaceTriangle above = random_needle(generator, 3.0, limit * (1.0 + 1e-6));
      ASSERT_FALSE(is_needle(TriangleFrame(above), layer));
      const Vec3d point = above.centroid_mm();
      EXPECT_LE((convolve_triangle_exact(above, point, layer) - convolve_needle(above, point, layer))
                    .cwiseAbs()
                    .maxCoeff(),
                1e-14 / limit);
    }
  }
}

// A step edge, as a ramp of width w between two half-planes: (1 + erf(u / (s sqrt 2))) / 2, from which the
// ramp differs by at most w^2/24 times 0.25 / s^2. The formula alone would be off by 6e-16 s / w.
TEST(Needle, AStepCanBeAThinRamp) {
  const double s = 1.0;
  const Vec3d turned = Vec3d(0.0, 0.3, 0.4).normalized();  // the plane of x and this
  for (const double w : {1e-4, 1e-6, 1e-9, 1e-12}) {
    Surface surface;
    const auto add = [&](double x0, double x1, double at_x0, double at_x1) {
      const auto corner = [&](double x, double y) { return Vec3d(x * Vec3d::UnitX() + y * turned); };
      const Vec3d light0 = Vec3d::Constant(at_x0);
      const Vec3d light1 = Vec3d::Constant(at_x1);
      surface.triangles.push_back(
          {{corner(x0, -14), corner(x1, -14), corner(x1, 14)}, {light0, light1, light1}, 0});
      surface.triangles.push_back(
          {{corner(x0, -14), corner(x1, 14), corner(x0, 14)}, {light0, light1, light0}, 0});
    };
    add(-14, -0.5 * w, 1, 1);
    add(-0.5 * w, 0.5 * w, 1, 0);
    add(0.5 * w, 14, 0, 0);
    std::vector<SurfacePoint> points;
    for (const double u : {-1.5, -0.2, 0.0, 0.7}) points.push_back({Vec3d(-u, 0, 0) + 0.3 * turned, 0});
    const std::vector<TruthLayer> layers = {{s}};
    const TruthValues exact = ExactEngine(surface).convolve(points, layers);
    const TruthValues fast = FastEngine(surface, 1e-6).convolve(points, layers);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double u = -points[i].position_mm.x();
      const double expected = 0.5 * (1.0 + std::erf(u / (s * std::sqrt(2.0))));
      EXPECT_NEAR(exact[0][i][0], expected, 1e-13 + w * w / 24.0 * 0.25) << "w " << w << " u " << u;
      EXPECT_NEAR(exact[0][i][3], 1.0, 1e-13);
      EXPECT_NEAR(fast[0][i][0], expected, 1e-6);
    }
  }
}

}  // namespace
}  // namespace truescatter
