// Closed forms of the Gaussian convolution. G = exp(-d^2 / 2 s^2) / (2 pi s^2), Euclidean distance.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "truth/exact.h"

namespace truescatter {
namespace {

// The planes end 12 s away from every point: what is missing is below exp(-12^2 / 2) = 5e-32.
constexpr double kExtentStdDevs = 14.0;
// Exact to rounding. Sums of some hundred terms of size <= 1 with 1e-16 each.
constexpr double kRounding = 1e-11;

// Absolute, in units of the light, and of a value above 1e-3 also of the value.
void expect_close(double value, double expected) {
  EXPECT_NEAR(value, expected, kRounding * (expected > 1e-3 ? expected : 1.0));
}

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

// The rectangle o + [u0, u1] a + [v0, v1] b in cells, each cut into two triangles.
void add_rectangle(Surface& surface, const Vec3d& o, const Vec3d& a, const Vec3d& b, double u0, double u1,
                   double v0, double v1, int cells, double irradiance) {
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const auto corner = [&](int di, int dj) {
        return Vec3d(o + a * (u0 + (u1 - u0) * (i + di) / cells) + b * (v0 + (v1 - v0) * (j + dj) / cells));
      };
      const Vec3d value = Vec3d(1.0, 0.5, 0.25) * irradiance;
      surface.triangles.push_back({{corner(0, 0), corner(1, 0), corner(1, 1)}, {value, value, value}, 0});
      surface.triangles.push_back({{corner(0, 0), corner(1, 1), corner(0, 1)}, {value, value, value}, 0});
    }
  }
}

TEST(PlaneClosedForm, StepEdge) {
  for (const double s : {0.08, 0.7, 2.7}) {
    const double extent = kExtentStdDevs * s;
    Surface surface;
    add_rectangle(surface, Vec3d::Zero(), Vec3d::UnitX(), Vec3d::UnitY(), -extent, 0.0, -extent, extent, 7,
                  1.0);
    add_rectangle(surface, Vec3d::Zero(), Vec3d::UnitX(), Vec3d::UnitY(), 0.0, extent, -extent, extent, 5,
                  0.0);
    const ExactEngine engine(surface);
    for (const double u : {-1.7, -0.3, 0.0, 1e-9, 0.4, 1.9}) {
      for (const double v : {0.0, 0.37}) {
        const Vec4d value = engine.convolve({Vec3d(u * s, v * s, 0.0), 0}, {s});
        // The lit half-plane lies at signed distance -u s: (1 + erf(-u / sqrt 2)) / 2.
        SCOPED_TRACE(testing::Message() << "s " << s << " u " << u);
        expect_close(value[0], normal_cdf(-u));
        expect_close(value[1], 0.5 * normal_cdf(-u));
        expect_close(value[3], 1.0);
      }
    }
  }
}

TEST(PlaneClosedForm, LinearIrradianceIsReproduced) {
  const double s = 1.3;
  const double extent = kExtentStdDevs * s;
  Surface surface;
  add_rectangle(surface, Vec3d::Zero(), Vec3d::UnitX(), Vec3d::UnitY(), -extent, extent, -extent, extent, 9,
                0.0);
  for (SurfaceTriangle& triangle : surface.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d& x = triangle.corners_mm[c];
      triangle.irradiance[c] = Vec3d(1.0 + 0.02 * x.x(), 1.0 - 0.03 * x.y(), 1.0 + 0.01 * (x.x() + x.y()));
    }
  }
  // The Gaussian is even, so a linear function is its own convolution.
  const Vec3d p(0.31, -0.72, 0.0);
  const Vec4d value = ExactEngine(surface).convolve({p, 0}, {s});
  expect_close(value[0], 1.0 + 0.02 * p.x());
  expect_close(value[1], 1.0 - 0.03 * p.y());
  expect_close(value[2], 1.0 + 0.01 * (p.x() + p.y()));
}

TEST(WedgeClosedForm, TwoHalfPlanes) {
  const double s = 0.9;
  const double extent = kExtentStdDevs * s;
  for (const double dihedral_deg : {20.0, 60.0, 90.0, 135.0, 179.0, 250.0}) {
    const double psi = dihedral_deg * kPi / 180.0;
    Surface surface;
    // Both half-planes end in the y axis; the point lies on the first at distance a from it.
    add_rectangle(surface, Vec3d::Zero(), Vec3d::UnitX(), Vec3d::UnitY(), 0.0, extent, -extent, extent, 6,
                  1.0);
    const Vec3d other(std::cos(psi), 0.0, std::sin(psi));
    add_rectangle(surface, Vec3d::Zero(), other, Vec3d::UnitY(), 0.0, extent, -extent, extent, 6, 0.0);
    const ExactEngine engine(surface);
    for (const double a : {0.0, 1e-6, 0.2, 0.8, 2.5}) {
      const Vec4d value = engine.convolve({Vec3d(a * s, 0.1, 0.0), 0}, {s});
      // Own half-plane: Phi(a). The other is seen from height a sin(psi), foot at a cos(psi) inside it:
      // exp(-(a sin psi)^2 / 2) Phi(a cos psi).
      const double own = normal_cdf(a);
      const double seen =
          std::exp(-0.5 * a * a * std::sin(psi) * std::sin(psi)) * normal_cdf(a * std::cos(psi));
      SCOPED_TRACE(testing::Message() << dihedral_deg << " deg, a " << a);
      expect_close(value[0], own);
      expect_close(value[3], own + seen);
    }
  }
}

TEST(PlaneClosedForm, CutOffKeepsTheDisc) {
  const double s = 1.5166;
  const double r_max = 4.5;
  Surface surface;
  add_rectangle(surface, Vec3d::Zero(), Vec3d::UnitX(), Vec3d::UnitY(), -20.0, 20.0, -20.0, 20.0, 23, 1.0);
  const ExactEngine engine(surface);
  for (const double h : {0.0, 0.6, 3.0, 4.49}) {
    const Vec4d value = engine.convolve({Vec3d(0.123, -0.456, h), 0}, {s, r_max});
    // In polar coordinates: integral of G from r = h to r_max.
    const double expected = std::exp(-h * h / (2 * s * s)) - std::exp(-r_max * r_max / (2 * s * s));
    expect_close(value[3], expected);
    expect_close(value[0], expected);
  }
}

TEST(PlaneClosedForm, CutOffHalfPlane) {
  const double s = 1.0;
  const double r_max = 2.0;
  const double u = 0.7;  // the half-plane x < u, seen from the origin
  Surface surface;
  add_rectangle(surface, Vec3d::Zero(), Vec3d::UnitX(), Vec3d::UnitY(), -10.0, u, -10.0, 10.0, 11, 1.0);
  const Vec4d value = ExactEngine(surface).convolve({Vec3d::Zero(), 0}, {s, r_max});
  // Chords: integral over x of phi(x) erf(sqrt(r_max^2 - x^2) / sqrt 2). With x = r_max sin(a) the integrand
  // is smooth at the disc's edge and Simpson's rule with 20000 intervals is at rounding.
  const int n = 20000;
  const double a0 = -0.5 * kPi;
  const double a1 = std::asin(u / r_max);
  double sum = 0.0;
  for (int i = 0; i <= n; ++i) {
    const double a = a0 + (a1 - a0) * i / n;
    const double x = r_max * std::sin(a);
    const double f = std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi) *
                     std::erf(r_max * std::cos(a) / std::sqrt(2.0)) * r_max * std::cos(a);
    sum += f * (i == 0 || i == n ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0));
  }
  expect_close(value[3], sum * (a1 - a0) / (3.0 * n));
}

}  // namespace
}  // namespace truescatter
