// A faceted sphere under irradiance Y_l, whose convolution is an eigenvalue times itself on the smooth one.
// With sigma / R = s and k = 1 / s^2:
//   Euclidean  2 k exp(-k) i_l(k), i_l the modified spherical Bessel function
//   geodesic   k int_0^pi exp(-t^2 / 2 s^2) P_l(cos t) sin t dt
// Facets, chords for arcs and light interpolated on them are off by O(h^2), all of them.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/sampling.h"
#include "truth/exact.h"
#include "truth/fast.h"
#include "truth/geodesic_exact.h"
#include "truth/geodesic_fast.h"

namespace truescatter {
namespace {

constexpr double kStdDev = 0.1;  // of the radius, which is 1 mm
const std::vector<int> kDegrees = {0, 1, 2, 4};

double euclidean_eigenvalue(int l, double s) {
  // i_l(k) exp(-k) = 1/(2k) [sum_m (-1)^m a_m / k^m - (-1)^l exp(-2k) sum_m a_m / k^m],
  // a_m = (l + m)! / (m! (l - m)! 2^m)  (Abramowitz & Stegun 10.2.9)
  const double k = 1.0 / (s * s);
  double sum = 0.0;
  for (int m = 0; m <= l; ++m) {
    const double a =
        std::tgamma(l + m + 1.0) / (std::tgamma(m + 1.0) * std::tgamma(l - m + 1.0) * std::pow(2.0 * k, m));
    sum += (m % 2 == 0 ? 1.0 : -1.0) * a - (l % 2 == 0 ? 1.0 : -1.0) * std::exp(-2.0 * k) * a;
  }
  return sum;
}

double geodesic_eigenvalue(int l, double s) {
  // Simpson over 12 deviations, in 40000 parts: (12 / 40000)^4 is 1e-14.
  const int n = 40000;
  const double end = std::min(kPi, 12.0 * s);
  double sum = 0.0;
  for (int i = 0; i <= n; ++i) {
    const double t = end * i / n;
    const double f =
        std::exp(-0.5 * t * t / (s * s)) * std::legendre(static_cast<unsigned>(l), std::cos(t)) * std::sin(t);
    sum += f * (i == 0 || i == n ? 1.0 : i % 2 == 1 ? 4.0 : 2.0);
  }
  return sum * end / (3.0 * n) / (s * s);
}

TEST(SphericalHarmonics, EigenvaluesAreTheTabulatedOnes) {
  const std::array<double, 4> euclidean = {1.0, 0.99, 0.9703, 0.90439605};
  const std::array<double, 4> geodesic = {.996673323820, .986772726509, .967265601281, .901977824991};
  for (std::size_t i = 0; i < kDegrees.size(); ++i) {
    EXPECT_NEAR(euclidean_eigenvalue(kDegrees[i], 0.1), euclidean[i], 1e-12);
    EXPECT_NEAR(geodesic_eigenvalue(kDegrees[i], 0.1), geodesic[i], 1e-12);
  }
}

struct Ball {
  std::vector<Vec3d> positions_mm;
  std::vector<std::array<int, 3>> triangles;
};

// An icosahedron, its triangles cut in four `levels` times; vertices keep their numbers from level to level.
Ball ball(int levels) {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  Ball ball;
  ball.positions_mm = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                       {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Vec3d& p : ball.positions_mm) p.normalize();
  ball.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [found, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<int>(ball.positions_mm.size()));
      if (fresh) {
        ball.positions_mm.push_back(
            (ball.positions_mm[static_cast<std::size_t>(a)] + ball.positions_mm[static_cast<std::size_t>(b)])
                .normalized());
      }
      return found->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : ball.triangles) {
      const int ab = middle(a, b);
      const int bc = middle(b, c);
      const int ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    ball.triangles = finer;
  }
  return ball;
}

// Y_l about an axis that is none of the icosahedron's.
double harmonic(int l, const Vec3d& p) {
  return std::legendre(static_cast<unsigned>(l), p.dot(Vec3d(0.48, 0.6, 0.64)));
}

// What the convolution makes of Y_l at some vertices of a mesh, as a multiple of Y_l: least squares.
// `values` of RGB irradiance Y_1, Y_2, Y_4; the mass is Y_0's.
std::vector<double> multiples(const std::vector<Vec3d>& points, const std::vector<Vec4d>& values) {
  std::vector<double> result;
  for (std::size_t i = 0; i < kDegrees.size(); ++i) {
    double product = 0.0;
    double square = 0.0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      const double y = harmonic(kDegrees[i], points[p]);
      product += y * values[p][i == 0 ? 3 : static_cast<Eigen::Index>(i) - 1];
      square += y * y;
    }
    result.push_back(product / square);
  }
  return result;
}

Vec3d light_at(const Vec3d& p) { return {harmonic(1, p), harmonic(2, p), harmonic(4, p)}; }

// Errors at three levels: each quarter of the one before, and what Richardson's extrapolation leaves is of
// the fourth order: at h/s = 0.33 and below at most an eighth of what it started from.
void expect_second_order(const std::array<std::vector<double>, 3>& found, double (*eigenvalue)(int, double)) {
  for (std::size_t i = 0; i < kDegrees.size(); ++i) {
    const double exact = eigenvalue(kDegrees[i], kStdDev);
    const double coarse = found[0][i] - exact;
    const double middle = found[1][i] - exact;
    const double fine = found[2][i] - exact;
    std::printf("l = %d: off by %.3e, %.3e, %.3e; extrapolated by %.1e\n", kDegrees[i], coarse, middle, fine,
                (4.0 * fine - middle) / 3.0);
    // The geodesic mass, 1 - K s^2 / 3 of a surface of curvature K, sees the area that facets lack only times
    // s^2: the second order is too small to be seen beside what a single vertex' angle does nearby.
    if (kDegrees[i] == 0 && eigenvalue == geodesic_eigenvalue) {
      EXPECT_LE(std::abs(middle), std::abs(coarse) / 4.0);
      EXPECT_LE(std::abs(fine), std::abs(middle) / 4.0);
      continue;
    }
    EXPECT_NEAR(middle / fine, 4.0, 0.5) << "l = " << kDegrees[i];
    EXPECT_NEAR(coarse / middle, 4.0, 1.0) << "l = " << kDegrees[i];
    EXPECT_LE(std::abs((4.0 * fine - middle) / 3.0), std::abs(fine) / 8.0) << "l = " << kDegrees[i];
  }
}

TEST(SphericalHarmonics, EuclideanConvergesAtSecondOrder) {
  std::array<std::vector<double>, 3> found;
  for (std::size_t i = 0; i < 3; ++i) {
    const Ball mesh = ball(3 + static_cast<int>(i));
    Surface surface;
    for (const auto& t : mesh.triangles) {
      SurfaceTriangle triangle;
      for (std::size_t c = 0; c < 3; ++c) {
        triangle.corners_mm[c] = mesh.positions_mm[static_cast<std::size_t>(t[c])];
        triangle.irradiance[c] = light_at(triangle.corners_mm[c]);
      }
      surface.triangles.push_back(triangle);
    }
    std::vector<Vec3d> at;
    std::vector<SurfacePoint> points;
    for (std::size_t v = 12; v < 72; v += 3) {
      at.push_back(mesh.positions_mm[v]);
      points.push_back({mesh.positions_mm[v], 0});
    }
    const std::vector<TruthLayer> layers = {{kStdDev}};
    found[i] = multiples(at, ExactEngine(surface).convolve(points, layers).front());
  }
  expect_second_order(found, euclidean_eigenvalue);
}

// At centroids: the middle one of a triangle's four parts has the same centroid. (At vertices the geodesic
// mass happens to converge faster.)
TEST(SphericalHarmonics, GeodesicConvergesAtSecondOrder) {
  std::array<std::vector<double>, 3> found;
  std::vector<std::size_t> faces;
  for (std::size_t f = 0; f < 1280; f += 67) faces.push_back(f);
  for (std::size_t i = 0; i < 3; ++i) {
    const Ball mesh = ball(3 + static_cast<int>(i));
    std::vector<GeodesicPiece> pieces;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      GeodesicPiece piece{f, {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()}, {}, 0};
      for (std::size_t c = 0; c < 3; ++c)
        piece.irradiance[c] = light_at(mesh.positions_mm[static_cast<std::size_t>(mesh.triangles[f][c])]);
      pieces.push_back(piece);
    }
    const GeodesicSurface surface(IntrinsicMesh(mesh.positions_mm, mesh.triangles), pieces);
    std::vector<Vec3d> at;
    std::vector<GeodesicTarget> targets;
    for (std::size_t& f : faces) {
      Vec3d sum = Vec3d::Zero();
      for (const int v : mesh.triangles[f]) sum += mesh.positions_mm[static_cast<std::size_t>(v)];
      at.emplace_back(sum.normalized());
      targets.push_back({{f, Vec3d::Constant(1.0 / 3.0)}, 0});
      f = 4 * f + 3;
    }
    // Beyond 6.5 deviations lies exp(-6.5^2 / 2) = 7e-10: far less than what is to be seen.
    const std::vector<TruthLayer> layers = {{kStdDev}};
    found[i] = multiples(at, GeodesicExactEngine(surface, 6.5).convolve(targets, layers).front());
  }
  expect_second_order(found, geodesic_eigenvalue);
}

}  // namespace
}  // namespace truescatter
