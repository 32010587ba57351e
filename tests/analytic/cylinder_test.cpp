// A regular prism, as a cylinder, under irradiance cos(n phi) cos(kappa z), whose convolution on the smooth
// cylinder (R = 1 mm, s = sigma / R) is that times exp(-kappa^2 sigma^2 / 2) and
//   Euclidean  sqrt(2 pi) / s exp(-1 / s^2) I_n(1 / s^2)
//   geodesic   int_-pi^pi exp(-t^2 / 2 s^2) cos(n t) dt / (s sqrt(2 pi)), the cylinder unrolled.
// Chords for arcs and light interpolated linearly are off by O(h^2).
#include <gtest/gtest.h>

#include <cmath>

#include "support/sampling.h"
#include "truth/exact.h"
#include "truth/geodesic_exact.h"

namespace truescatter {
namespace {

struct Wave {
  int n;
  double kappa;
};
// RGB.
const std::array<Wave, 3> kWaves = {Wave{0, 1.5}, Wave{1, 0.0}, Wave{2, 2.0}};

double light(const Wave& wave, double phi, double z) {
  return std::cos(wave.n * phi) * std::cos(wave.kappa * z);
}

double euclidean_eigenvalue(const Wave& wave, double s) {
  return std::exp(-0.5 * wave.kappa * wave.kappa * s * s) * std::sqrt(2.0 * kPi) / s *
         std::exp(-1.0 / (s * s)) * std::cyl_bessel_i(static_cast<double>(wave.n), 1.0 / (s * s));
}

double geodesic_eigenvalue(const Wave& wave, double s) {
  const int intervals = 4000;  // Simpson: (pi/4000 s)^4, 1e-11
  double sum = 0.0;
  for (int i = 0; i <= intervals; ++i) {
    const double t = kPi * (2.0 * i / intervals - 1.0);
    sum += std::exp(-0.5 * t * t / (s * s)) * std::cos(wave.n * t) *
           (i == 0 || i == intervals ? 1.0
            : i % 2 == 1             ? 4.0
                                     : 2.0);
  }
  return std::exp(-0.5 * wave.kappa * wave.kappa * s * s) * sum * 2.0 * kPi / (3.0 * intervals) /
         (s * std::sqrt(2.0 * kPi));
}

struct Prism {
  std::vector<Vec3d> positions_mm;
  std::vector<Vec3d> irradiance;
  std::vector<std::array<int, 3>> triangles;
};

// `sides` rectangles round, as high as they are wide, to `half_length` mm on either side of z = 0. Vertex
// `rings` * sides lies at phi = 0, z = 0.
Prism prism(int sides, int rings) {
  const double height = 2.0 * kPi / sides;
  Prism prism;
  for (int r = -rings; r <= rings; ++r) {
    for (int i = 0; i < sides; ++i) {
      const double phi = 2.0 * kPi * i / sides;
      const double z = r * height;
      prism.positions_mm.emplace_back(std::cos(phi), std::sin(phi), z);
      prism.irradiance.emplace_back(light(kWaves[0], phi, z), light(kWaves[1], phi, z),
                                    light(kWaves[2], phi, z));
    }
  }
  for (int r = 0; r < 2 * rings; ++r) {
    for (int i = 0; i < sides; ++i) {
      const int a = r * sides + i;
      const int b = r * sides + (i + 1) % sides;
      prism.triangles.push_back({a, b, b + sides});
      prism.triangles.push_back({a, b + sides, a + sides});
    }
  }
  return prism;
}

// At phi = 0, z = 0 every wave is 1. The prism ends 7 deviations away: 2.6e-12 of the mass.
constexpr double kEndStdDevs = 7.0;

void expect_second_order(const std::array<Vec4d, 3>& found, double s,
                         double (*eigenvalue)(const Wave&, double)) {
  for (std::size_t w = 0; w < kWaves.size(); ++w) {
    const double exact = eigenvalue(kWaves[w], s);
    const auto c = static_cast<Eigen::Index>(w);
    const double coarse = found[0][c] - exact;
    const double middle = found[1][c] - exact;
    const double fine = found[2][c] - exact;
    std::printf("s = %g, wave %zu: off by %.3e, %.3e, %.3e\n", s, w, coarse, middle, fine);
    // The next order is h^2 of the leading one, times the waves' curvature: h = 0.26, 0.13, 0.065.
    EXPECT_NEAR(coarse / middle, 4.0, 0.4) << "wave " << w;
    EXPECT_NEAR(middle / fine, 4.0, 0.1) << "wave " << w;
  }
}

constexpr std::array<int, 3> kSides = {24, 48, 96};

int rings_for(int sides, double s) {
  return static_cast<int>(std::ceil(kEndStdDevs * s * sides / (2.0 * kPi)));
}

TEST(CylinderClosedForm, EuclideanConvergesAtSecondOrder) {
  for (const double s : {0.2, 0.7}) {
    std::array<Vec4d, 3> found;
    for (std::size_t i = 0; i < kSides.size(); ++i) {
      const int rings = rings_for(kSides[i], s);
      const Prism mesh = prism(kSides[i], rings);
      Surface surface;
      for (const auto& t : mesh.triangles) {
        SurfaceTriangle triangle;
        for (std::size_t c = 0; c < 3; ++c) {
          triangle.corners_mm[c] = mesh.positions_mm[static_cast<std::size_t>(t[c])];
          triangle.irradiance[c] = mesh.irradiance[static_cast<std::size_t>(t[c])];
        }
        surface.triangles.push_back(triangle);
      }
      found[i] = ExactEngine(surface).convolve({Vec3d::UnitX(), 0}, {s});
    }
    expect_second_order(found, s, euclidean_eigenvalue);
    // Of the mass: averaged over a chord, distances shrink by h^2 / 24 and so do lengths, which leaves
    // M(s (1 + h^2 / 24)), and of second order in the depth of the chord -h^4 / 240 s^2.
    const auto mass = [](double of) { return euclidean_eigenvalue({0, 0.0}, of); };
    const double h = 2.0 * kPi / kSides[2];
    const double leading = mass(s * (1.0 + h * h / 24.0)) - mass(s);
    EXPECT_NEAR(found[2][3] - mass(s), leading - std::pow(h, 4) / (240.0 * s * s), 0.05 * leading) << s;
  }
}

TEST(CylinderClosedForm, GeodesicConvergesAtSecondOrder) {
  for (const double s : {0.2, 0.7}) {
    std::array<Vec4d, 3> found;
    for (std::size_t i = 0; i < kSides.size(); ++i) {
      const int rings = rings_for(kSides[i], s);
      const Prism mesh = prism(kSides[i], rings);
      std::vector<GeodesicPiece> pieces;
      for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        GeodesicPiece piece{f, {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()}, {}, 0};
        for (std::size_t c = 0; c < 3; ++c)
          piece.irradiance[c] = mesh.irradiance[static_cast<std::size_t>(mesh.triangles[f][c])];
        pieces.push_back(piece);
      }
      const GeodesicSurface surface(IntrinsicMesh(mesh.positions_mm, mesh.triangles), pieces);
      // Corner 0 of the first triangle of the ring above z = 0 is at phi = 0.
      const GeodesicPoint point{static_cast<std::size_t>(2 * rings * kSides[i]), Vec3d::UnitX()};
      const std::vector<TruthLayer> layers = {{s}};
      GeodesicField field(surface.mesh());
      found[i] = GeodesicExactEngine(surface, kEndStdDevs).convolve(field, {point, 0}, layers).front();
    }
    expect_second_order(found, s, geodesic_eigenvalue);
    // The mass is that of a strip of the prism's girth that wraps; 7 deviations away is where the engine ends
    // too, and leaves exp(-7^2 / 2) = 2.3e-11.
    for (std::size_t i = 0; i < kSides.size(); ++i) {
      const double half_girth = kSides[i] * std::sin(kPi / kSides[i]);
      EXPECT_NEAR(found[i][3], std::erf(half_girth / (s * std::sqrt(2.0))), 3e-11) << s;
    }
  }
}

}  // namespace
}  // namespace truescatter
