#include "truth/piece_integral.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "support/sampling.h"

namespace truescatter {
namespace {

using test::uniform;

// int f(offset + |x - source|) I over a triangle by a product rule in u, v with
// x = corner + u ((1 - v) e1 + v e2): 60 panels of 16 nodes along the needle, 16 nodes across. Where the
// source is the corner, or not on the needle, the integrand is smooth in both: rounding.
Vec4d by_quadrature(const FlatPiece& piece, const GeodesicWindow& window, double s) {
  using Gauss = boost::math::quadrature::gauss<double, 16>;
  const auto& x = piece.corners_mm;
  constexpr int kPanels = 60;
  Vec4d sum = Vec4d::Zero();
  const auto nodes = [](const auto& visit) {
    for (std::size_t i = 0; i < Gauss::abscissa().size(); ++i) {
      for (const double sign : {-1.0, 1.0})
        visit(0.5 + 0.5 * sign * Gauss::abscissa()[i], 0.5 * Gauss::weights()[i]);
    }
  };
  for (int panel = 0; panel < kPanels; ++panel) {
    nodes([&](double along, double weight_u) {
      const double u = (panel + along) / kPanels;
      nodes([&](double v, double weight_v) {
        const Vec3d b(1.0 - u, u * (1.0 - v), u * v);
        const Vec2d at = b[0] * x[0] + b[1] * x[1] + b[2] * x[2];
        const double d = window.distance(at);
        const double weight = weight_u * weight_v * u / kPanels * 2.0 * piece.area_mm2() *
                              std::exp(-0.5 * d * d / (s * s)) / (2.0 * kPi * s * s);
        Vec4d value(0.0, 0.0, 0.0, 1.0);
        for (std::size_t c = 0; c < 3; ++c)
          value.head<3>() += b[static_cast<Eigen::Index>(c)] * piece.irradiance[c];
        sum += weight * value;
      });
    });
  }
  return sum;
}

// The piece's formula takes irradiance as i0 + g.x about the source, and over a needle of height h the light
// gains 1: g is 1/h, and integrals along two nearly equal edges, each rounded, differ by what counts. So
// digits go as rounding * s / h, at most 1e-10, below which the needle is integrated as such.
TEST(PieceIntegral, NeedlesAgreeWithQuadrature) {
  std::mt19937_64 generator(3);
  const double s = 0.8;
  for (const double offset : {0.0, 0.5}) {
    for (const double height : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
      double worst = 0.0;
      for (int i = 0; i < 40; ++i) {
        FlatPiece piece;
        const double length = 0.3 + 2.0 * uniform(generator);
        const double turn = 2.0 * kPi * uniform(generator);
        const auto turned = [&](double a, double b) {
          return Vec2d(std::cos(turn) * a - std::sin(turn) * b, std::sin(turn) * a + std::cos(turn) * b);
        };
        piece.corners_mm = {turned(0.0, 0.0), turned(length, 0.0),
                            turned(uniform(generator) * length, height * s)};
        for (Vec3d& value : piece.irradiance)
          value = Vec3d(uniform(generator), uniform(generator), uniform(generator));
        // At a corner, or beside the needle; everything is seen.
        const Vec2d source =
            i % 3 == 0 ? piece.corners_mm[0] : turned(-0.3 + uniform(generator), -0.2 - uniform(generator));
        const GeodesicWindow window{source, offset, turned(-1.0, 0.0), turned(1.0, 0.0), i % 3 == 0};
        const GeodesicWindow* const windows[] = {&window};
        const TruthLayer layers[] = {{s}};
        Vec4d found = Vec4d::Zero();
        PieceIntegral({}).add(piece, windows, layers, std::span(&found, 1));
        worst = std::max(worst, (found - by_quadrature(piece, window, s)).cwiseAbs().maxCoeff());
      }
      std::printf("offset %g, height %.0e s: off by %.1e\n", offset, height, worst);
      EXPECT_LE(worst, 1e-10) << "offset " << offset << " height " << height;
    }
  }
}

}  // namespace
}  // namespace truescatter
