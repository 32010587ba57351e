#include "truth/radial_exact.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <random>

#include "profile/gaussian_mixture.h"
#include "profile/image_sources.h"
#include "support/sampling.h"
#include "truth/exact.h"

namespace truescatter {
namespace {

using test::random_triangle;
using test::random_vec;
using test::uniform;

Vec3d point_on(const SurfaceTriangle& triangle, Vec3d b) {
  b /= b.sum();
  return b[0] * triangle.corners_mm[0] + b[1] * triangle.corners_mm[1] + b[2] * triangle.corners_mm[2];
}

RadialKernel kernel_of(const ImageSources& profile,
                       double r_max_mm = std::numeric_limits<double>::infinity()) {
  return {[profile](double r) { return profile.antiderivative(r); }, profile.shortest_length_mm(), r_max_mm};
}

RadialKernel gaussian(double s, double r_max_mm = std::numeric_limits<double>::infinity()) {
  return {[s](double r) { return -std::exp(-0.5 * r * r / (s * s)) / (2.0 * kPi); }, s, r_max_mm};
}

// Plain quadrature of f over triangles: Gauss-Legendre on a square that collapses into a corner, 7 x 7
// against 10 x 10 nodes, cut in four until they agree to 1e-12 of the largest value for each mm^2.
class Plain {
 public:
  Plain(const ImageSources& profile, const SurfaceTriangle& triangle, const Vec3d& point)
      : profile_(profile), triangle_(triangle), point_(point) {}

  Vec4d value() const { return integral({Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()}, 0); }

 private:
  using Part = std::array<Vec3d, 3>;  // barycentric

  Vec4d integral(const Part& part, int depth) const {
    const Vec4d coarse = rule<7>(part);
    const Vec4d fine = rule<10>(part);
    const double share = std::abs(part[0].dot(part[1].cross(part[2])));
    if ((fine - coarse).cwiseAbs().maxCoeff() <= 1e-12 * share * triangle_.area_mm2()) return fine;
    EXPECT_LT(depth, 30);
    if (depth >= 30) return fine;
    const Vec3d ab = 0.5 * (part[0] + part[1]);
    const Vec3d bc = 0.5 * (part[1] + part[2]);
    const Vec3d ca = 0.5 * (part[2] + part[0]);
    return integral({part[0], ab, ca}, depth + 1) + integral({ab, part[1], bc}, depth + 1) +
           integral({ca, bc, part[2]}, depth + 1) + integral({ab, bc, ca}, depth + 1);
  }

  template <unsigned N>
  Vec4d rule(const Part& part) const {
    using Gauss = boost::math::quadrature::gauss<double, N>;
    const double share = std::abs(part[0].dot(part[1].cross(part[2])));
    Vec4d sum = Vec4d::Zero();
    const auto along = [&](double u, double weight) {
      for (unsigned j = 0; j < Gauss::abscissa().size(); ++j) {
        for (const double sign : {-1.0, 1.0}) {
          const double node = Gauss::abscissa()[j];
          if (node == 0.0 && sign > 0.0) continue;
          const double v = 0.5 * (1.0 + sign * node);
          const Vec3d b = part[0] + u * ((1.0 - v) * (part[1] - part[0]) + v * (part[2] - part[0]));
          sum += weight * 0.5 * Gauss::weights()[j] * 2.0 * share * triangle_.area_mm2() * u * at(b);
        }
      }
    };
    for (unsigned i = 0; i < Gauss::abscissa().size(); ++i) {
      const double node = Gauss::abscissa()[i];
      along(0.5 * (1.0 + node), 0.5 * Gauss::weights()[i]);
      if (node > 0.0) along(0.5 * (1.0 - node), 0.5 * Gauss::weights()[i]);
    }
    return sum;
  }

  Vec4d at(const Vec3d& b) const {
    Vec3d x = Vec3d::Zero();
    Vec4d light(0.0, 0.0, 0.0, 1.0);
    for (std::size_t c = 0; c < 3; ++c) {
      x += b[static_cast<Eigen::Index>(c)] * triangle_.corners_mm[c];
      light.head<3>() += b[static_cast<Eigen::Index>(c)] * triangle_.irradiance[c];
    }
    return profile_.value((x - point_).norm()) * light;
  }

  const ImageSources& profile_;
  const SurfaceTriangle& triangle_;
  Vec3d point_;
};

std::vector<ImageSources> profiles() {
  return {classical_dipole({0.17, 0.88, 1.3}), better_dipole({0.032, 0.74, 1.3}),
          better_dipole({0.0041, 2.62, 1.5}), multipole({0.17, 0.88, 1.3}, 2.0, SlabSide::lit),
          multipole({0.17, 0.88, 1.3}, 2.0, SlabSide::far)};
}

// Above the plane, within the triangle, on an edge, at a corner, in the plane outside.
TEST(RadialExact, IsTheIntegralOverATriangle) {
  std::mt19937_64 generator(7);
  for (int i = 0; i < 30; ++i) {
    const ImageSources profile = profiles()[static_cast<std::size_t>(i / 5) % 5];
    const SurfaceTriangle triangle = random_triangle(generator, i % 2 == 0 ? 1.0 : 4.0);
    Vec3d b = random_vec(generator, 1.0).cwiseAbs();
    if (i % 5 == 2) b[i % 3] = 0.0;
    if (i % 5 == 3) b = Vec3d::Unit(i % 3);
    if (i % 5 == 4) b = Vec3d(1.0, 1.0, -0.7);
    const Vec3d point = i % 5 == 0 ? random_vec(generator, 3.0) : point_on(triangle, b);
    const RadialValue found =
        convolve_triangle_radial(triangle, point, kernel_of(profile), 1e-13, Vec4d::Ones());
    const Vec4d expected = Plain(profile, triangle, point).value();
    // The quadrature allows itself 1e-12 for each of at most 100 mm^2, in differences that overrate it.
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(found.value[k], expected[k], 1e-11 + found.error[k]) << i;
    EXPECT_LT(found.error.maxCoeff(), 1e-11) << i;
  }
}

// A Gaussian's own F: the exact engine's closed form, on soups that are seen from within, edges and corners
// included, cut off and not.
TEST(RadialExact, OfAGaussianIsTheExactEngines) {
  std::mt19937_64 generator(13);
  Surface surface;
  for (int i = 0; i < 10; ++i) surface.triangles.push_back(random_triangle(generator, 2.0));
  const ExactEngine exact(surface);
  const RadialExactEngine radial(surface);
  for (int i = 0; i < 30; ++i) {
    const SurfaceTriangle& triangle = surface.triangles[static_cast<std::size_t>(i) % 10];
    Vec3d b = random_vec(generator, 1.0).cwiseAbs();
    if (i % 3 == 1) b[i % 9 / 3] = 0.0;
    if (i % 6 == 2) b = Vec3d::Unit(i % 3);
    const Vec3d point = i % 4 == 3 ? random_vec(generator, 2.0) : point_on(triangle, b);
    const double s = std::exp(uniform(generator, std::log(0.01), std::log(3.0)));
    const double to_corner = (triangle.corners_mm[static_cast<std::size_t>(i) % 3] - point).norm();
    for (const double r_max :
         {std::numeric_limits<double>::infinity(), 2.0 * s, std::max(0.1 * s, to_corner)}) {
      const RadialValue found = radial.convolve({point, 0}, gaussian(s, r_max));
      const Vec4d expected = exact.convolve({point, 0}, {s, r_max});
      EXPECT_LE((found.value - expected).cwiseAbs().maxCoeff(), 1e-11)
          << i << " s " << s << " r_max " << r_max;
      EXPECT_LE(found.error.maxCoeff(), 1e-11) << i;
    }
  }
}

// A large square under irradiance 1 sends back the albedo, less what lies beyond it: for x = y = 0 and half
// the side L at most -2 pi F(L). Cut off, and from height h, it sends back 2 pi (F(r_max) - F(h)).
TEST(RadialExact, OfAPlaneIsTheAlbedo) {
  const Vec3d one = Vec3d::Ones();
  const double size = 400.0;
  Surface surface;
  surface.triangles.push_back(
      {{Vec3d(-size, -size, 0), Vec3d(size, -size, 0), Vec3d(size, size, 0)}, {one, one, one}, 0});
  surface.triangles.push_back(
      {{Vec3d(-size, -size, 0), Vec3d(size, size, 0), Vec3d(-size, size, 0)}, {one, one, one}, 0});
  const RadialExactEngine engine(surface);
  for (const ImageSources& profile : profiles()) {
    const double beyond = 2.0 * kPi * std::abs(profile.antiderivative(size));
    for (const Vec3d& point : {Vec3d(0, 0, 0), Vec3d(1.23, -0.4, 0)}) {
      const RadialValue found = engine.convolve({point, 0}, kernel_of(profile));
      EXPECT_NEAR(found.value[0], profile.albedo(), 2.0 * beyond + 1e-11);
      EXPECT_NEAR(found.value[3], profile.albedo(), 2.0 * beyond + 1e-11);
    }
    for (const double h : {0.0, 0.3}) {
      const RadialValue found = engine.convolve({Vec3d(3.1, 0.2, h), 0}, kernel_of(profile, 2.5));
      EXPECT_NEAR(found.value[3], 2.0 * kPi * (profile.antiderivative(2.5) - profile.antiderivative(h)),
                  1e-11);
    }
    EXPECT_EQ(engine.convolve({Vec3d(0, 0, 2.6), 0}, kernel_of(profile, 2.5)).value, Vec4d::Zero());
  }
}

// A mixture of Gaussians stands for the profile to its bound. A shell around a point holds no more of a
// triangle than of a plane, so over these the bound counts ten times.
TEST(RadialExact, IsWhatAMixtureOfGaussiansConvergesTo) {
  std::mt19937_64 generator(23);
  Surface surface;
  for (int i = 0; i < 10; ++i) surface.triangles.push_back(random_triangle(generator, 3.0));
  const ExactEngine gaussians(surface);
  const RadialExactEngine radial(surface);
  for (const ImageSources& profile : profiles()) {
    for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
      const GaussianMixture mixture = gaussian_mixture({profile, profile, profile}, tolerance);
      for (const std::size_t t : {std::size_t{0}, std::size_t{7}}) {
        const Vec3d point = point_on(surface.triangles[t], Vec3d(0.2, 0.3, 0.5));
        Vec4d sum = Vec4d::Zero();
        for (const GaussianLevel& level : mixture.levels)
          sum += level.weight[0] * gaussians.convolve({point, 0}, {level.std_dev_mm()});
        const Vec4d exact = radial.convolve({point, 0}, kernel_of(profile)).value;
        EXPECT_LE((sum - exact).cwiseAbs().maxCoeff(), 10.0 * mixture.error_bound[0] + 1e-12) << tolerance;
      }
    }
  }
}

// On a needle, where the formula loses digits, the error says so.
TEST(RadialExact, OwnsUpToWhatNeedlesCost) {
  SurfaceTriangle needle;
  needle.corners_mm = {Vec3d(-2, 0, 0), Vec3d(2, 0, 0), Vec3d(0.3, 1e-5, 0)};
  needle.irradiance = {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};
  const ImageSources profile = classical_dipole({0.17, 0.88, 1.3});
  const Vec3d point(0.1, 1e-6, 0.2);
  const RadialValue found = convolve_triangle_radial(needle, point, kernel_of(profile), 1e-13, Vec4d::Ones());
  const Vec4d expected = Plain(profile, needle, point).value();
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(found.value[k], expected[k], found.error[k] + 1e-15);
  EXPECT_LT(found.error.maxCoeff(), 1e-8);
}

}  // namespace
}  // namespace truescatter
