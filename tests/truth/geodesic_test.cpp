// The geodesic truth against closed forms (sources: the cone, saddle and cylinder below are isometric to
// sectors and strips of the plane, where everything is a Gaussian integral).
#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <random>

#include "core/error.h"
#include "core/parallel.h"
#include "scene/builtin.h"
#include "support/random.h"
#include "truth/cgal_geodesic.h"
#include "truth/exact.h"
#include "truth/geodesic_exact.h"
#include "truth/geodesic_fast.h"
#include "truth/piece_integral.h"

namespace truescatter {
namespace {

using test::uniform;

struct Soup {
  std::vector<Vec3d> positions_mm;
  std::vector<std::array<int, 3>> triangles;
};

// A fan of `count` isosceles triangles of total angle `total` about a vertex at the origin, legs of `leg` mm,
// in space: cones by tilting, saddles by waving. Geodesics only see lengths, so any isometric embedding will
// do; this one puts the rim's points at directions whose successive angles are total / count.
Soup fan(double total, int count, double leg) {
  Soup soup;
  soup.positions_mm.push_back(Vec3d::Zero());
  const double step = total / count;
  // Rim directions on the unit sphere, alternating latitudes +-b with equal longitudes apart: the angle
  // between neighbours grows with b for a saddle; a cone has all at one latitude.
  const double longitude = 2.0 * kPi / count;
  for (int i = 0; i < count; ++i) {
    double latitude = 0.0;
    if (step < longitude) {
      // cos(step) = sin^2 b + cos^2 b cos(longitude)
      latitude = std::acos(std::sqrt((1.0 - std::cos(step)) / (1.0 - std::cos(longitude))));
    } else {
      // cos(step) = -sin^2 b + cos^2 b cos(longitude)
      latitude = std::acos(std::sqrt((1.0 + std::cos(step)) / (1.0 + std::cos(longitude))));
      if (i % 2 == 1) latitude = -latitude;
    }
    const double phi = i * longitude;
    soup.positions_mm.push_back(leg * Vec3d(std::cos(latitude) * std::cos(phi),
                                            std::cos(latitude) * std::sin(phi), std::sin(latitude)));
  }
  for (int i = 0; i < count; ++i) soup.triangles.push_back({0, 1 + i, 1 + (i + 1) % count});
  return soup;
}

GeodesicSurface lit(const Soup& soup, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<Vec3d> value(soup.positions_mm.size());
  for (Vec3d& v : value) v = Vec3d(uniform(generator), uniform(generator), uniform(generator));
  std::vector<GeodesicPiece> pieces;
  for (std::size_t f = 0; f < soup.triangles.size(); ++f) {
    GeodesicPiece piece;
    piece.face = f;
    for (std::size_t c = 0; c < 3; ++c) {
      piece.barycentric[c] = Vec3d::Unit(static_cast<Eigen::Index>(c));
      piece.irradiance[c] = value[static_cast<std::size_t>(soup.triangles[f][c])];
    }
    pieces.push_back(piece);
  }
  return {IntrinsicMesh(soup.positions_mm, soup.triangles), pieces};
}

Vec4d exact_at(const GeodesicSurface& surface, const GeodesicPoint& point, const TruthLayer& layer) {
  GeodesicField field(surface.mesh());
  return GeodesicExactEngine(surface).convolve(field, {point, 0}, std::span(&layer, 1)).front();
}

// Mass of a Gaussian on a cone of total angle T < 2 pi at distance a from the apex:
// int_{-T/2}^{T/2} f(phi) dphi, f as below (what lies within the cut locus opposite the source).
double cone_mass(double total, double a, double s) {
  const auto f = [&](double phi) {
    const double c = a * std::cos(phi) / s;
    return (std::exp(-0.5 * a * a / (s * s)) + c * std::sqrt(0.5 * kPi) *
                                                   std::exp(-0.5 * std::pow(a * std::sin(phi) / s, 2)) *
                                                   (1.0 + std::erf(c / std::sqrt(2.0)))) /
           (2.0 * kPi);
  };
  // Simpson with 2000 parts: the fourth derivative is of the order of (a/s)^4, so 1e-13 of the value.
  const int n = 2000;
  const double h = total / n;
  double sum = 0.0;
  for (int i = 0; i <= n; ++i)
    sum += (i == 0 || i == n ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * f(-0.5 * total + i * h);
  return sum * h / 3.0;
}

double saddle_mass(double total, double a, double s) {
  return 1.0 + (total - 2.0 * kPi) / (2.0 * kPi) *
                   (std::exp(-0.5 * a * a / (s * s)) -
                    a / s * std::sqrt(0.5 * kPi) * std::erfc(a / (s * std::sqrt(2.0))));
}

// A source at distance a from the fan's apex, in the middle of its first triangle's angle or off it.
GeodesicPoint fan_point(const Soup& soup, double a, double share) {
  const double leg = soup.positions_mm[1].norm();
  // On the ray that divides the opposite edge in `share`: |(1-share) p1 + share p2| of the way.
  const Vec3d at_rim = (1.0 - share) * soup.positions_mm[1] + share * soup.positions_mm[2];
  const double t = a / at_rim.norm();
  EXPECT_LT(t, 1.0) << leg;
  return {0, {1.0 - t, t * (1.0 - share), t * share}};
}

// Rounding of some hundred pieces: 1e-13. Behind a convex apex at distance a the cut locus' owners change
// within an angle of a/s; from about 1e-8 on, the quadrature no longer sees that layer, whose mass is at most
// a/(2s).
double allowed(double a, double s) { return 1e-13 + (a > 0.0 && a < 1e-7 ? 2.0 * a / s : 0.0); }

TEST(GeodesicExact, MassOnACone) {
  // The cube's corner at a/s = 0.8: 0.918316175058 (tabulated); sources down to the apex.
  EXPECT_NEAR(cone_mass(1.5 * kPi, 0.8, 1.0), 0.918316175058, 1e-12);
  for (const double total : {1.5 * kPi, 1.9 * kPi, 0.7 * kPi}) {
    const Soup soup = fan(total, 6, 30.0);
    const GeodesicSurface surface = lit(soup, 3);
    for (const double a : {3.0, 0.8, 0.05, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 0.0}) {
      for (const double share : {0.5, 0.13, 0.0}) {
        EXPECT_NEAR(exact_at(surface, fan_point(soup, a, share), {1.0})[3], cone_mass(total, a, 1.0),
                    1e-12 + allowed(a, 1.0))
            << "total " << total << " a " << a << " share " << share;
      }
    }
  }
}

TEST(GeodesicExact, MassOnASaddle) {
  // A source within 3e-10 of its edge's 30 mm of the apex is taken to lie on it (geodesic_field.cpp): it
  // moves by a, over which the mass changes by at most a times int 2 r |f'| dr times the angle beyond a
  // plane's, 1.1 pi at most: sqrt(pi/2) 1.1 pi / pi / s < 1.4 a / s.
  const auto moved = [](double a) { return a < 3e-10 * 30.0 ? 1.4 * a : 0.0; };
  EXPECT_NEAR(saddle_mass(2.5 * kPi, 0.8, 1.0), 1.075328712824, 1e-12);
  for (const double total : {2.5 * kPi, 2.05 * kPi, 3.2 * kPi}) {
    const Soup soup = fan(total, 12, 30.0);
    const GeodesicSurface surface = lit(soup, 3);
    for (const double a : {3.0, 0.8, 0.05, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 0.0}) {
      for (const double share : {0.5, 0.13, 0.0}) {
        EXPECT_NEAR(exact_at(surface, fan_point(soup, a, share), {1.0})[3], saddle_mass(total, a, 1.0),
                    1e-13 + allowed(0.0, 1.0) + moved(a))
            << "total " << total << " a " << a << " share " << share;
      }
    }
  }
}

// Light on a fan, from its unfolding: with the apex as origin and angles phi from the source, d is the
// plane's distance for |phi| <= pi and a + r beyond (round a saddle's apex); on a cone |phi| <= T/2.
// Gauss-Legendre with 16 nodes on parts between the spokes, the source's direction and what lies opposite, so
// narrow (s/2 and 0.1 rad) that 16 nodes are exact to rounding of the sum.
Vec4d fan_quadrature(const Soup& soup, const GeodesicSurface& surface, double total, double a, double share,
                     double s) {
  using Gauss = boost::math::quadrature::gauss<double, 16>;
  const auto count = soup.triangles.size();
  const double step = total / static_cast<double>(count);
  const double leg = soup.positions_mm[1].norm();
  // The angle of the source's ray, which divides the first triangle's chord in `share`.
  const double source = std::atan2(share * std::sin(step), 1.0 - share + share * std::cos(step));
  std::vector<double> breaks;
  for (std::size_t i = 0; i <= count; ++i) breaks.push_back(static_cast<double>(i) * step);
  const double half = std::min(kPi, 0.5 * total);
  for (const double phi : {source, source + half, source - half + total}) breaks.push_back(phi);
  const auto refine = [](std::vector<double> coarse, double width) {
    std::sort(coarse.begin(), coarse.end());
    std::vector<double> fine;
    for (std::size_t i = 0; i + 1 < coarse.size(); ++i) {
      const int parts = std::max(1, static_cast<int>(std::ceil((coarse[i + 1] - coarse[i]) / width)));
      for (int k = 0; k < parts; ++k) fine.push_back(coarse[i] + (coarse[i + 1] - coarse[i]) * k / parts);
    }
    fine.push_back(coarse.back());
    return fine;
  };
  const auto sum_over = [](const std::vector<double>& ends, const auto& f) {
    Vec4d sum = Vec4d::Zero();
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
      const double middle = 0.5 * (ends[i] + ends[i + 1]);
      const double radius = 0.5 * (ends[i + 1] - ends[i]);
      for (std::size_t k = 0; k < Gauss::abscissa().size(); ++k) {
        const double x = radius * Gauss::abscissa()[k];
        sum += radius * Gauss::weights()[k] * (f(middle - x) + f(middle + x));
      }
    }
    return sum;
  };
  const std::vector<double> radii = refine({0.0, a, a + 9.0 * s}, 0.5 * s);
  return sum_over(refine(breaks, 0.1), [&](double phi) -> Vec4d {
    const auto face = std::min(static_cast<std::size_t>(phi / step), count - 1);
    const double within = phi - static_cast<double>(face) * step;
    double away = std::abs(phi - source);
    away = std::min(away, total - away);
    // Barycentric coordinates of leg * (cos, sin) in the triangle with corners at 0 and at legs of 0 and
    // `step`.
    const double to_second = std::sin(within) / std::sin(step);
    const double to_first = std::cos(within) - to_second * std::cos(step);
    const FlatPiece& piece = surface.pieces(face).front();
    return sum_over(radii, [&](double r) -> Vec4d {
      const double d = away <= kPi ? std::sqrt(a * a + r * r - 2.0 * a * r * std::cos(away)) : a + r;
      const double weight = std::exp(-0.5 * d * d / (s * s)) / (2.0 * kPi * s * s) * r;
      Vec4d value;
      value.head<3>() =
          weight * (piece.irradiance[0] + r / leg *
                                              (to_first * (piece.irradiance[1] - piece.irradiance[0]) +
                                               to_second * (piece.irradiance[2] - piece.irradiance[0])));
      value[3] = weight;
      return value;
    });
  });
}

TEST(GeodesicExact, RandomLightOnConeAndSaddle) {
  for (const double total : {1.5 * kPi, 1.9 * kPi, 0.7 * kPi, 2.5 * kPi, 3.2 * kPi}) {
    const Soup soup = fan(total, total > 2.0 * kPi ? 12 : 6, 30.0);
    const GeodesicSurface surface = lit(soup, 13);
    for (const double a : {2.0, 0.8, 0.05, 1e-3}) {
      for (const double share : {0.5, 0.13}) {
        const Vec4d exact = exact_at(surface, fan_point(soup, a, share), {1.0});
        const Vec4d expected = fan_quadrature(soup, surface, total, a, share, 1.0);
        EXPECT_LE((exact - expected).cwiseAbs().maxCoeff(), 1e-11)
            << "total " << total << " a " << a << " share " << share << " exact " << exact.transpose()
            << " expected " << expected.transpose();
      }
    }
  }
}

// Distances at random interior points of rough meshes, sources inside faces, on edges and on vertices:
// vertices alone would not show a window that is missing. CGAL's are exact to rounding of its own
// coordinates, some 1e-12 of the radius; sources on edges are moved by 1e-12 of a face for its sake.
TEST(GeodesicField, DistancesAreCgals) {
  std::mt19937_64 generator(17);
  for (const char* name : {"sphere", "tube", "slab", "plane", "wedge"}) {
    Mesh mesh = make_builtin(name);
    for (Vec3d& p : mesh.positions_mm)
      p += 1.5 * Vec3d(uniform(generator) - 0.5, uniform(generator) - 0.5, uniform(generator) - 0.5);
    const IntrinsicMesh intrinsic(mesh.positions_mm, mesh.triangles);
    const CgalGeodesics cgal(mesh.positions_mm, mesh.triangles);
    GeodesicField field(intrinsic);
    const double radius_mm = 8.0;
    for (int i = 0; i < 4; ++i) {
      GeodesicPoint source;
      source.face = generator() % mesh.triangles.size();
      Vec3d b(uniform(generator), uniform(generator), uniform(generator));
      if (i == 1) b[1] = 0.0;
      if (i == 2) b = Vec3d::UnitZ();
      source.barycentric = b / b.sum();
      field.propagate(source, radius_mm);
      std::vector<MeshPoint> targets;
      for (const std::int32_t face : field.faces()) {
        for (int k = 0; k < 3; ++k) {
          const Vec3d t(uniform(generator), uniform(generator), uniform(generator));
          targets.push_back({static_cast<std::size_t>(face), t / t.sum()});
        }
      }
      const std::vector<double> expected = cgal.distances_mm({source.face, source.barycentric}, targets);
      for (std::size_t k = 0; k < targets.size(); ++k) {
        if (expected[k] >= radius_mm) continue;
        const Vec2d x = flat_position(intrinsic, {targets[k].triangle, targets[k].barycentric});
        EXPECT_NEAR(field.distance(targets[k].triangle, x), expected[k], 1e-10 * radius_mm)
            << name << " source " << i << " target " << k;
      }
    }
  }
}

// An L of three squares, its sides on open boundaries: paths from one end run along a boundary edge to the
// inner corner and round it. Rounding of the fans' angles must not lose them, whatever the lengths.
TEST(GeodesicField, PathsFollowBoundaryEdges) {
  const std::vector<std::array<int, 3>> triangles = {{0, 1, 4}, {4, 3, 0}, {1, 2, 5},
                                                     {5, 4, 1}, {3, 4, 7}, {7, 6, 3}};
  std::mt19937_64 generator(23);
  for (int i = 0; i < 300; ++i) {
    std::vector<Vec3d> positions_mm = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0},
                                       {1, 1, 0}, {2, 1, 0}, {0, 2, 0}, {1, 2, 0}};
    for (Vec3d& p : positions_mm)
      p += 0.3 * Vec3d(uniform(generator) - 0.5, uniform(generator) - 0.5, uniform(generator) - 0.5);
    const IntrinsicMesh mesh(positions_mm, triangles);
    GeodesicField field(mesh);
    field.propagate({4, Vec3d::UnitZ()}, 20.0);
    const MeshPoint target{2, {0.1, 0.7, 0.2}};
    const double expected =
        CgalGeodesics(positions_mm, triangles).distances_mm({4, Vec3d::UnitZ()}, std::span(&target, 1))[0];
    EXPECT_NEAR(field.distance(2, flat_position(mesh, {2, target.barycentric})), expected, 1e-10) << i;
  }
}

// Rays that run along a polygon's edges leave corners on both sides by rounding alone. However they fall, the
// polygon stays within its capacity, and no cut enlarges it.
TEST(FlatPolygon, StaysWithinItsCapacityWhereRaysRunAlongEdges) {
  const auto area = [](const FlatPolygon& p) {
    double twice = 0.0;
    for (std::size_t i = 2; i < p.size; ++i) {
      const Vec2d a = p[i - 1] - p[0];
      const Vec2d b = p[i] - p[0];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return 0.5 * twice;
  };
  std::mt19937_64 generator(29);
  std::size_t most = 0;
  for (int i = 0; i < 20000; ++i) {
    FlatPolygon polygon;
    for (const Vec2d& corner :
         {Vec2d(0, 0), Vec2d(1, 0), Vec2d(uniform(generator), 0.1 + uniform(generator))})
      polygon.push_back(corner);
    for (int cut = 0; cut < 2; ++cut) {
      // From a point on the line of one of the polygon's edges, along it; the other ray anywhere.
      const std::size_t e = generator() % polygon.size;
      const Vec2d along = (polygon.after(e) - polygon[e]).normalized();
      const double turn = 0.2 + 2.0 * uniform(generator);
      const Vec2d other(std::cos(turn) * along.x() - std::sin(turn) * along.y(),
                        std::sin(turn) * along.x() + std::cos(turn) * along.y());
      const GeodesicWindow window{polygon[e] - 3.0 * uniform(generator) * along, 0.0, other, along, false};
      const double before = area(polygon);
      polygon = covered(window, polygon);
      most = std::max(most, polygon.size);
      ASSERT_LE(polygon.size, FlatPolygon::kCapacity);
      ASSERT_LE(area(polygon), before + 1e-14);
      if (polygon.size < 3) break;
    }
  }
  EXPECT_GE(most, 4U);
}

// A polygon with corners along its edges, which an earlier cut leaves, cut by a ray along any of them: all of
// it lies to one side. Coordinates are O(10), so sides round by 1e-14 and areas by as much.
TEST(FlatPolygon, LosesNothingToARayAlongItsCorners) {
  std::mt19937_64 generator(31);
  for (int i = 0; i < 20000; ++i) {
    const Vec2d from(10.0 * uniform(generator), 10.0 * uniform(generator));
    const double angle = 2.0 * kPi * uniform(generator);
    const Vec2d along(std::cos(angle), std::sin(angle));
    const Vec2d inward(along.y(), -along.x());
    FlatPolygon polygon;  // a right triangle on the ray, with corners at a third and two thirds of its side
    polygon.push_back(from + inward);
    for (const double t : {3.0, 2.0, 1.0, 0.0}) polygon.push_back(from + t * along);
    const GeodesicWindow window{from - 5.0 * uniform(generator) * along, 0.0, along, inward, false};
    const FlatPolygon rest = covered(window, polygon);
    double twice_area = 0.0;
    for (std::size_t k = 2; k < rest.size; ++k) {
      const Vec2d a = rest[k - 1] - rest[0];
      const Vec2d b = rest[k] - rest[0];
      twice_area += a.x() * b.y() - a.y() * b.x();
    }
    ASSERT_NEAR(std::abs(twice_area), 3.0, 1e-13) << rest.size;
  }
}

// What cannot be unfolded is refused by name.
TEST(IntrinsicMesh, RefusesWhatHasNoOneAnswer) {
  const auto message = [](const Soup& soup) -> std::string {
    try {
      const IntrinsicMesh mesh(soup.positions_mm, soup.triangles);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::input);
      return error.what();
    }
    return "accepted";
  };
  const Vec3d o(0, 0, 0);
  const Vec3d x(1, 0, 0);
  const Vec3d y(0, 1, 0);
  const Vec3d z(0, 0, 1);
  EXPECT_NE(message({{o, x, 2.0 * x}, {{0, 1, 2}}}).find("triangle 0 at (0, 0, 0) has no area"),
            std::string::npos);
  EXPECT_NE(message({{o, x, y, z, -y}, {{0, 1, 2}, {1, 0, 3}, {1, 0, 4}}}).find("triangles 1 and 2"),
            std::string::npos);
  EXPECT_NE(message({{o, x, y, z}, {{0, 1, 2}, {0, 1, 3}}}).find("triangles 0 and 1"), std::string::npos);
  EXPECT_NE(
      message({{o, x, y, -x, -y}, {{0, 1, 2}, {0, 3, 4}}}).find("at the vertex (0, 0, 0) two sheets touch"),
      std::string::npos);
  // A long edge against two short ones.
  EXPECT_NE(message({{-x, x, y, o, -y}, {{0, 1, 2}, {3, 0, 4}, {1, 3, 4}}}).find("(a T-junction)"),
            std::string::npos);
  EXPECT_EQ(message({{o, x, y, z}, {{0, 1, 2}, {1, 0, 3}}}), "accepted");
}

// The fast engine keeps its tolerance where the surface is rough and light is, too.
TEST(GeodesicFast, HoldsItsTolerance) {
  for (const char* name : {"tube", "wedge"}) {
    const Mesh mesh = make_builtin(name);
    const GeodesicSurface surface = lit({mesh.positions_mm, mesh.triangles}, 7);
    std::mt19937_64 generator(19);
    std::vector<GeodesicTarget> targets;
    for (int i = 0; i < 12; ++i) {
      Vec3d b(uniform(generator), uniform(generator), uniform(generator));
      if (i % 4 == 1) b[i % 3] = 0.0;
      if (i % 4 == 2) b = Vec3d::Unit(i % 3);
      targets.push_back({{generator() % mesh.triangles.size(), b / b.sum()}, 0});
    }
    const std::vector<TruthLayer> layers = {{0.08}, {0.43}, {1.4}, {1.4, 3.1}};
    const TruthValues exact = GeodesicExactEngine(surface).convolve(targets, layers);
    for (const double tolerance : {1e-4, 1e-6}) {
      const TruthValues fast = GeodesicFastEngine(surface, tolerance).convolve(targets, layers);
      for (std::size_t l = 0; l < layers.size(); ++l) {
        for (std::size_t i = 0; i < targets.size(); ++i) {
          EXPECT_LE((fast[l][i] - exact[l][i]).cwiseAbs().maxCoeff(), tolerance)
              << name << " s " << layers[l].std_dev_mm << " r_max " << layers[l].r_max_mm << " point " << i;
        }
      }
    }
  }
}

TEST(GeodesicFast, SameBitsForAnyNumberOfJobs) {
  const Mesh mesh = make_builtin("tube");
  const GeodesicSurface surface = lit({mesh.positions_mm, mesh.triangles}, 7);
  std::vector<GeodesicTarget> targets;
  for (std::size_t i = 0; i < 600; ++i) targets.push_back({{i % mesh.triangles.size(), {0.2, 0.3, 0.5}}, 0});
  const std::vector<TruthLayer> layers = {{0.43}, {1.0}};
  const auto run = [&](int jobs) {
    const JobLimit limit(jobs);
    return GeodesicFastEngine(surface, 1e-4).convolve(targets, layers);
  };
  const TruthValues one = run(1);
  const TruthValues two = run(2);
  for (std::size_t l = 0; l < layers.size(); ++l) {
    for (std::size_t i = 0; i < targets.size(); ++i) ASSERT_EQ(one[l][i], two[l][i]);
  }
}

// On a plane geodesic is Euclidean, irradiance, boundary and cut-off included.
TEST(GeodesicExact, EqualsEuclideanOnAPlane) {
  std::mt19937_64 generator(11);
  Mesh plane = make_builtin("plane", {{"size_mm", 20.0}, {"edge_mm", 1.5}});
  // Move the inner vertices, so that no three are aligned; a convex plane, as Euclidean paths need.
  for (Vec3d& p : plane.positions_mm) {
    if (std::max(std::abs(p.x()), std::abs(p.y())) < 9.9)
      p += 0.5 * Vec3d(uniform(generator) - 0.5, uniform(generator) - 0.5, 0.0);
  }
  const GeodesicSurface surface = lit({plane.positions_mm, plane.triangles}, 5);
  Surface soup;
  std::mt19937_64 same(5);
  std::vector<Vec3d> value(plane.positions_mm.size());
  for (Vec3d& v : value) v = Vec3d(uniform(same), uniform(same), uniform(same));
  for (const auto& t : plane.triangles) {
    SurfaceTriangle triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      triangle.corners_mm[c] = plane.positions_mm[static_cast<std::size_t>(t[c])];
      triangle.irradiance[c] = value[static_cast<std::size_t>(t[c])];
    }
    soup.triangles.push_back(triangle);
  }
  const ExactEngine euclidean(soup);
  for (int i = 0; i < 12; ++i) {
    GeodesicPoint point;
    point.face = generator() % plane.triangles.size();
    Vec3d b(uniform(generator), uniform(generator), uniform(generator));
    if (i % 3 == 1) b[i % 2] = 0.0;
    if (i % 4 == 3) b = Vec3d::UnitY();
    point.barycentric = b / b.sum();
    Vec3d at = Vec3d::Zero();
    for (std::size_t c = 0; c < 3; ++c)
      at += point.barycentric[static_cast<Eigen::Index>(c)] * soup.triangles[point.face].corners_mm[c];
    for (const TruthLayer& layer : {TruthLayer{0.3}, TruthLayer{1.2}, TruthLayer{1.2, 2.0}}) {
      const Vec4d difference = exact_at(surface, point, layer) - euclidean.convolve({at, 0}, layer);
      EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-11) << "s " << layer.std_dev_mm << " point " << i;
    }
  }
}

// A prism over a regular polygon unrolls into a strip; irradiance that is constant leaves the Gaussian's mass
// on a strip that wraps: erf of half the girth.
TEST(GeodesicExact, MassOnAPrismThatWraps) {
  const int sides = 8;
  const double side = 1.0;
  const double radius = side / (2.0 * std::sin(kPi / sides));
  const int rings = 25;
  Soup soup;
  for (int r = 0; r < rings; ++r) {
    for (int i = 0; i < sides; ++i) {
      const double phi = 2.0 * kPi * i / sides;
      soup.positions_mm.emplace_back(radius * std::cos(phi), radius * std::sin(phi), 1.5 * (r - rings / 2));
    }
  }
  for (int r = 0; r + 1 < rings; ++r) {
    for (int i = 0; i < sides; ++i) {
      const int a = r * sides + i;
      const int b = r * sides + (i + 1) % sides;
      soup.triangles.push_back({a, b, b + sides});
      soup.triangles.push_back({a, b + sides, a + sides});
    }
  }
  const GeodesicSurface surface = lit(soup, 3);
  const double s = 1.6;
  const double half_girth = 0.5 * sides * side;
  // Along the axis the strip ends 16 mm = 10 s away: 1e-23.
  const double expected = std::erf(half_girth / (s * std::sqrt(2.0)));
  for (const std::size_t face : {std::size_t{192}, std::size_t{197}}) {
    EXPECT_NEAR(exact_at(surface, {face, {0.2, 0.3, 0.5}}, {s})[3], expected, 1e-12);
    EXPECT_NEAR(exact_at(surface, {face, {0.0, 0.3, 0.7}}, {s})[3], expected, 1e-12);
    EXPECT_NEAR(exact_at(surface, {face, {0.0, 1.0, 0.0}}, {s})[3], expected, 1e-12);
  }
}

}  // namespace
}  // namespace truescatter
