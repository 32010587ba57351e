#include "truth/light_paths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "irradiance/mesh_point.h"
#include "scene/builtin.h"
#include "truth/exact.h"
#include "truth/geodesic_exact.h"
#include "truth/triangle_rules.h"

namespace truescatter {
namespace {

// LightPathEngine leaves out what lies beyond the distance where a plane keeps this much.
const double kTail = LightPathEngine::tail_bound();

double normal_density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi); }

// A mesh whose triangles give light by their centroids; all of it skin, of one component.
struct LitMesh {
  Mesh mesh;
  GeodesicSurface geodesic;
  Surface surface;

  explicit LitMesh(
      Mesh from, const std::function<double(const Vec3d&)>& light = [](const Vec3d&) { return 1.0; })
      : mesh(std::move(from)),
        geodesic(IntrinsicMesh(mesh.positions_mm, mesh.triangles), pieces(mesh, light)) {
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
      const Vec3d value = Vec3d::Constant(light(centroid(mesh, t)));
      surface.triangles.push_back(
          {{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}, {value, value, value}, 0});
    }
  }

  // The foot of x on the triangle that is nearest.
  GeodesicTarget nearest(const Vec3d& x) const {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
      const double d =
          squared_distance_to_triangle(x, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
      if (d < least) {
        least = d;
        best = t;
      }
    }
    Mat3d corners;
    for (int c = 0; c < 3; ++c) corners.col(c) = mesh.corner(best, c);
    // x less its height over the triangle's plane, which does not pass through the origin in these tests.
    const Vec3d n = triangle_normal(mesh, best);
    const Vec3d foot = x - n.dot(x - mesh.corner(best, 0)) * n;
    const Vec3d b = corners.inverse() * foot;
    return {{best, b.cwiseMax(0.0) / b.cwiseMax(0.0).sum()}, 0};
  }

  Vec3d position(const GeodesicTarget& target) const {
    return position_mm(mesh, {target.point.face, target.point.barycentric});
  }

  LightPaths split(const GeodesicTarget& target, double std_dev_mm, double r_max_mm,
                   double edge_std_devs = 0.5) const {
    const std::vector<double> std_devs = {std_dev_mm};
    GeodesicField field(geodesic.mesh());
    return LightPathEngine(mesh, geodesic, edge_std_devs).split(field, target, std_devs, r_max_mm).front();
  }

  // Euclidean less geodesic, to rounding.
  Vec4d difference(const GeodesicTarget& target, double std_dev_mm) const {
    const std::vector<TruthLayer> layers = {{std_dev_mm}};
    GeodesicField field(geodesic.mesh());
    return ExactEngine(surface).convolve({position(target), 0}, layers.front()) -
           GeodesicExactEngine(geodesic).convolve(field, target, layers).front();
  }

 private:
  static Vec3d centroid(const Mesh& mesh, std::size_t t) {
    return (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
  }
  static std::vector<GeodesicPiece> pieces(const Mesh& mesh,
                                           const std::function<double(const Vec3d&)>& light) {
    std::vector<GeodesicPiece> pieces;
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
      const Vec3d value = Vec3d::Constant(light(centroid(mesh, t)));
      pieces.push_back({t, {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()}, {value, value, value}, 0});
    }
    return pieces;
  }
};

Mesh moved(Mesh mesh, const Vec3d& by) {
  for (Vec3d& p : mesh.positions_mm) p += by;
  return mesh;
}

const Vec3d kAway(100.0, 200.0, 300.0);  // no plane of a built-in scene passes through the origin then

// A slab of thickness t: its far side is a plane at distance t, so what passes through is
// int G(sqrt(t^2 + rho^2)) I = I exp(-t^2 / 2 s^2); no geodesic of less than 60 mm leads there. The rest of
// the near side is a plane, 0 but for 1e-15 of rounding in G times 1 of area. Quadrature: parts of s / 2 lie
// within x = 0.29 s of their centroids at most, where a rule of degree 5 on a Gaussian errs by less than
// 0.29^6 / sqrt(6!) = 2e-5.
TEST(LightPaths, PassThroughASlab) {
  constexpr double kBackLight = 0.7;
  for (const double thickness_mm : {1.0, 2.0, 4.0}) {
    const LitMesh slab(
        moved(make_builtin("slab", {{"size_mm", 60.0}, {"thickness_mm", thickness_mm}}), kAway),
        [](const Vec3d& x) { return x.z() > kAway.z() ? 1.0 : kBackLight; });
    constexpr double kStdDevMm = 1.5;
    const GeodesicTarget target = slab.nearest(kAway + Vec3d(0.3, -0.7, 0.5 * thickness_mm));
    const LightPaths paths = slab.split(target, kStdDevMm, 4.5);
    const double mass = std::exp(-0.5 * thickness_mm * thickness_mm / (kStdDevMm * kStdDevMm));
    EXPECT_NEAR(paths.transmittance[3], mass, 2e-5 + kTail) << thickness_mm;
    EXPECT_NEAR(paths.transmittance[1], kBackLight * mass, 2e-5 + kTail) << thickness_mm;
    EXPECT_LT(std::abs(paths.air[3]), 1e-12);
    EXPECT_LT(std::abs(paths.curvature[3]), 1e-12);
    // No geodesic within reach leads to the far side: the same sum.
    EXPECT_EQ(paths.through[1], paths.transmittance[1]);
    // Along the near side: exp(-4.5^2 / 2 s^2) of the plane; that circle crosses parts of s / 2, each of
    // which may be off by its own area times G there: a part has 0.11 s^2, the circle meets 2 pi 4.5 / 0.5 s
    // of them, and their errors are random: sqrt(38) * 0.11 / 2 pi * exp(-4.5) / 2 = 6e-4.
    EXPECT_NEAR(paths.beyond[3], std::exp(-4.5), 6e-4);
  }
}

// In a convex body every straight way between two points lies inside, so what comes through is all that lies
// beyond r_max along the surface, and more than the way along it brings by transmittance: the same nodes,
// summed in another order, 1e-12 of them. Faces that share a plane have straight ways along themselves, which
// are taken for ways outside; there both distances are the same. What of `beyond` comes from them is the
// point's own facet, whose radius stays below r_max.
TEST(LightPaths, ComeThroughAConvexBodyFromAllThatIsFar) {
  const LitMesh sphere(moved(make_builtin("sphere", {{"radius_mm", 6.0}, {"edge_mm", 1.5}}), kAway));
  const LightPaths paths = sphere.split(sphere.nearest(kAway + Vec3d(0.2, 0.3, 6.0)), 2.5, 4.0);
  EXPECT_GT(paths.beyond[3], 0.1);
  EXPECT_LT(std::abs(paths.air[3]), 1e-12);
  EXPECT_NEAR(paths.through[3], paths.transmittance[3] + paths.beyond[3], 1e-12);
}

TEST(LightPaths, LeaveNothingOnAPlane) {
  const LitMesh plane(moved(make_builtin("plane"), kAway));
  // A tenth of s from the border too, where the plane ends.
  for (const Vec3d& at : {Vec3d(0.3, -0.7, 0.0), Vec3d(29.9, 10.0, 0.0)}) {
    const LightPaths paths = plane.split(plane.nearest(kAway + at), 1.5, 3.0);
    EXPECT_LT(paths.transmittance.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT(paths.air.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT(paths.curvature.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_GT(paths.beyond[3], 0.05);
  }
}

// Two half planes that meet at the angle psi, seen from the first at a distance a from the edge. A point of
// the second at u from the edge and v along it is sqrt(a^2 + u^2 - 2 a u cos(psi) + v^2) away straight and
// sqrt((a + u)^2 + v^2) along the surface. By the midpoint rule in steps of s / 100.
struct WedgeParts {
  double far = 0.0;
  double near = 0.0;
};

WedgeParts wedge_parts(double psi, double a_mm, double s_mm, double r_max_mm) {
  WedgeParts parts;
  const double step = 0.01 * s_mm;
  for (double u = 0.5 * step; u < a_mm + 7.0 * s_mm; u += step) {
    for (double v = 0.5 * step; v < 7.0 * s_mm; v += step) {
      const double straight2 = a_mm * a_mm + u * u - 2.0 * a_mm * u * std::cos(psi) + v * v;
      const double along2 = (a_mm + u) * (a_mm + u) + v * v;
      const double difference =
          normal_density(std::sqrt(straight2) / s_mm) - normal_density(std::sqrt(along2) / s_mm);
      const double mass = 2.0 * difference * step * step / (std::sqrt(2.0 * kPi) * s_mm * s_mm);
      (along2 > r_max_mm * r_max_mm ? parts.far : parts.near) += mass;
    }
  }
  return parts;
}

// A convex wedge's other face is seen through the body, a concave one's through the air, as across a crease;
// what lies within r_max is curvature. The far part jumps along a circle, whose length on the other face is
// at most 2 r_max = 9 s / 1.5: it crosses 6 / 0.5 = 12 parts of 0.11 s^2 with a jump of at most 1 / (2 pi
// s^2) times the two Gaussians' difference, which is below 0.4 there: sqrt(12) * 0.11 * 0.4 / 2 pi / 2 =
// 0.012 for each part; the sum has no jump: 2e-5 as in the slab, for each face, and the tail's.
TEST(LightPaths, CrossACreaseThroughTheAirAndAnEdgeThroughTheBody) {
  constexpr double kStdDevMm = 1.5;
  constexpr double kRMaxMm = 4.5;
  for (const double dihedral_deg : {30.0, 60.0, 120.0, 300.0, 330.0}) {
    const double psi = dihedral_deg * kPi / 180.0;
    const LitMesh wedge(moved(make_builtin("wedge", {{"dihedral_deg", dihedral_deg}}), kAway));
    for (const double a_mm : {0.4, 1.7, 3.0, 5.0}) {
      const Vec3d outward(std::sin(0.5 * psi), 0.0, -std::cos(0.5 * psi));
      const GeodesicTarget target = wedge.nearest(kAway + a_mm * outward + Vec3d(0.0, 0.3, 0.0));
      const LightPaths paths = wedge.split(target, kStdDevMm, kRMaxMm);
      const WedgeParts expected = wedge_parts(psi, a_mm, kStdDevMm, kRMaxMm);
      SCOPED_TRACE(testing::Message() << dihedral_deg << " degrees, " << a_mm << " mm");
      const bool convex = dihedral_deg < 180.0;
      EXPECT_NEAR((convex ? paths.transmittance : paths.air)[3], expected.far, 0.012);
      EXPECT_LT(std::abs((convex ? paths.air : paths.transmittance)[3]), 1e-12);
      EXPECT_NEAR(paths.curvature[3], expected.near, 0.012);
      EXPECT_NEAR(paths.sum()[3], expected.far + expected.near, 4e-5 + kTail);
    }
  }
}

// On a sphere of radius R the straight way 2 R sin(a / 2R) is shorter than the arc a, so curvature is
// positive, and with all of it within r_max it is int 2 pi R sin(a / R) (G(2 R sin(a / 2R)) - G(a)) da. The
// mesh is inside the sphere by at most e^2 / 8 R = 0.6 % of R, e = 1 mm: areas and distances are off by twice
// that.
TEST(LightPaths, CountASphereAsCurvature) {
  constexpr double kRadiusMm = 20.0;
  constexpr double kStdDevMm = 3.0;
  const LitMesh sphere(moved(make_builtin("sphere", {{"radius_mm", kRadiusMm}, {"edge_mm", 1.0}}), kAway));
  const LightPaths paths =
      sphere.split(sphere.nearest(kAway + kRadiusMm * Vec3d(0.3, 0.4, 0.87).normalized()), kStdDevMm, 18.0);
  double expected = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double arc = (i + 0.5) * 18.0 / kSteps;
    const double chord = 2.0 * kRadiusMm * std::sin(0.5 * arc / kRadiusMm);
    expected += 2.0 * kPi * kRadiusMm * std::sin(arc / kRadiusMm) * (18.0 / kSteps) / (std::sqrt(2.0 * kPi)) *
                (normal_density(chord / kStdDevMm) - normal_density(arc / kStdDevMm)) /
                (kStdDevMm * kStdDevMm);
  }
  EXPECT_GT(expected, 1e-3);
  EXPECT_NEAR(paths.curvature[3], expected, 0.025 * expected);
  // 18 mm is 6 s.
  EXPECT_LT(std::abs(paths.transmittance[3] + paths.air[3]), 1e-7);
}

// Round a tube of flat sides, with a cut locus behind. The sum knows no jump. At the locus G has a kink of at
// most 2 max|G'| = 2 * 0.61 / (2 pi s^3); a part of edge h s, of area 0.2 h^2 s^2 and radius 0.58 h s, errs
// there by half its kink times these times kink_rms (triangle_rules.h); 4 / h parts lie along 4 s of locus,
// with random signs. Four deviations: 4 * 0.5 * 0.19 * 0.2 * 0.58 * 2 = 0.088 kink_rms h^2.5. A part of the
// sum jumps along d = r_max, so converges to first order at least; the RMS over eight points of what falls at
// random has a spread of a quarter, and the ratio of two one of 0.35: twice covers it.
TEST(LightPaths, ConvergeToEuclideanLessGeodesic) {
  const LitMesh tube(
      moved(make_builtin("tube", {{"radius_mm", 3.0}, {"length_mm", 30.0}, {"edge_mm", 5.0}}), kAway),
      [](const Vec3d& x) { return 0.5 + 0.1 * std::sin(x.x()); });
  constexpr double kStdDevMm = 2.5;
  std::vector<GeodesicTarget> targets;
  for (int i = 0; i < 8; ++i) {
    const double angle = 0.3 + 0.77 * i;
    targets.push_back(
        tube.nearest(kAway + Vec3d(3.0 * std::cos(angle), 1.3 * i - 5.0, 3.0 * std::sin(angle))));
  }
  std::vector<LightPaths> fine;
  for (const GeodesicTarget& target : targets) fine.push_back(tube.split(target, kStdDevMm, 4.0, 1.0 / 16));
  // The sum's error against the engines of either truth, the largest; the part's against the finest, its RMS.
  struct Error {
    double sum = 0.0;
    double part = 0.0;
  };
  std::map<double, Error> errors;
  for (const double edge : {1.0, 0.5, 0.25}) {
    Error& error = errors[edge];
    double squares = 0.0;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const LightPaths paths = tube.split(targets[i], kStdDevMm, 4.0, edge);
      error.sum =
          std::max(error.sum, (paths.sum() - tube.difference(targets[i], kStdDevMm)).cwiseAbs().maxCoeff());
      squares += std::pow(paths.transmittance[3] - fine[i].transmittance[3], 2);
    }
    error.part = std::sqrt(squares / static_cast<double>(targets.size()));
    EXPECT_GT(fine[0].transmittance[3], 0.01);
  }
  for (const auto& [edge, error] : errors)
    EXPECT_LT(error.sum, 0.088 * triangle_rules()[2].kink_rms * std::pow(edge, 2.5) + kTail) << edge;
  EXPECT_LT(errors[0.25].part, errors[1.0].part / 4.0 * 2.0);
}

}  // namespace
}  // namespace truescatter
