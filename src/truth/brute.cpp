#include "truth/brute.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "scene/mesh.h"
#include "truth/line_rule.h"

namespace truescatter {
namespace {

constexpr double kTailShare = 0.01;    // of the tolerance
constexpr int kDeepestCut = 100;       // halvings of an edge until it is short against s and the cut
constexpr int kDeepestRefinement = 8;  // and until the rules agree

struct Triangle {
  Vec3d a;
  Vec3d b;
  Vec3d c;

  Vec3d area_vector() const { return 0.5 * (b - a).cross(c - a); }
  double longest_edge() const { return std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()}); }
};

// Halves the longest edge.
std::array<Triangle, 2> halves(const Triangle& t) {
  const double ab = (t.b - t.a).squaredNorm();
  const double bc = (t.c - t.b).squaredNorm();
  const double ca = (t.a - t.c).squaredNorm();
  if (bc > ab && bc >= ca) return halves({t.b, t.c, t.a});
  if (ca > ab) return halves({t.c, t.a, t.b});
  const Vec3d middle = 0.5 * (t.a + t.b);
  return {Triangle{t.a, middle, t.c}, Triangle{middle, t.b, t.c}};
}

std::array<Triangle, 4> quarters(const Triangle& t) {
  const auto [first, second] = halves(t);
  const auto [a, b] = halves(first);
  const auto [c, d] = halves(second);
  return {a, b, c, d};
}

// The point's disc in a triangle's plane: where that lies within r_max.
struct Disc {
  Vec3d center;
  double radius;
  Vec3d x;  // axes of the plane, turning from x to y counter-clockwise
  Vec3d y;

  Vec3d at(double angle) const { return center + radius * (std::cos(angle) * x + std::sin(angle) * y); }
  double angle_of(const Vec3d& p) const { return std::atan2((p - center).dot(y), (p - center).dot(x)); }
};

// What lies between an arc of the disc and its chord; to - from < pi.
struct Sliver {
  double from;
  double to;
};

// One triangle of the surface, seen from one point.
class TriangleIntegral {
 public:
  TriangleIntegral(const SurfaceTriangle& triangle, const Vec3d& point_mm, const TruthLayer& layer,
                   double reach_mm, double tolerance_per_mm2, const Vec4d& unit)
      : triangle_{triangle.corners_mm[0], triangle.corners_mm[1], triangle.corners_mm[2]},
        point_(point_mm),
        layer_(layer),
        reach_mm_(reach_mm),
        tolerance_per_mm2_(tolerance_per_mm2),
        unit_(unit),
        irradiance_at_a_(triangle.irradiance[0]) {
    const Vec3d area = triangle_.area_vector();
    if (!(area.norm() > 0.0)) return;
    normal_ = area.normalized();
    // The gradient of a corner's barycentric coordinate: its opposite edge turned, over twice the area.
    const Vec3d of_b = normal_.cross(triangle_.a - triangle_.c) / (2.0 * area.norm());
    const Vec3d of_c = normal_.cross(triangle_.b - triangle_.a) / (2.0 * area.norm());
    gradient_ = (triangle.irradiance[1] - triangle.irradiance[0]) * of_b.transpose() +
                (triangle.irradiance[2] - triangle.irradiance[0]) * of_c.transpose();
    // Irradiance is read at rounded positions: on a needle that can be seen.
    double size = point_.cwiseAbs().maxCoeff();
    for (const Vec3d& x : triangle.corners_mm) size = std::max(size, x.cwiseAbs().maxCoeff());
    const double peak = 1.0 / (2.0 * kPi * layer.std_dev_mm * layer.std_dev_mm);
    rounding_per_mm2_ =
        8.0 * std::numeric_limits<double>::epsilon() * peak * size * gradient_.cwiseAbs().maxCoeff();
  }

  Vec4d value() {
    if (normal_.isZero(0.0)) return Vec4d::Zero();
    if (layer_.r_max_mm >= reach_mm_ + layer_.std_dev_mm) return cut_short(triangle_, 0);
    const double height = (point_ - triangle_.a).dot(normal_);
    const double radius2 = layer_.r_max_mm * layer_.r_max_mm - height * height;
    // A disc so small holds 1e-20 of the Gaussian's mass.
    if (radius2 <= 1e-20 * layer_.std_dev_mm * layer_.std_dev_mm) return Vec4d::Zero();
    disc_.center = point_ - height * normal_;
    disc_.radius = std::sqrt(radius2);
    disc_.x = (triangle_.b - triangle_.a).normalized();
    disc_.y = normal_.cross(disc_.x);
    return inside_disc(triangle_, 0);
  }

 private:
  // The part within the disc.
  Vec4d inside_disc(const Triangle& t, int depth) {
    const double cut2 = disc_.radius * disc_.radius;
    const auto distance2 = [&](const Vec3d& p) { return (p - disc_.center).squaredNorm(); };
    if (distance2(t.a) <= cut2 && distance2(t.b) <= cut2 && distance2(t.c) <= cut2)
      return cut_short(t, depth);
    if (squared_distance_to_triangle(disc_.center, t.a, t.b, t.c) >= cut2) return Vec4d::Zero();
    if (t.longest_edge() > std::min(0.25 * disc_.radius, layer_.std_dev_mm)) {
      require(depth < kDeepestCut);
      Vec4d sum = Vec4d::Zero();
      for (const Triangle& part : quarters(t)) sum += inside_disc(part, depth + 1);
      return sum;
    }
    return clipped(t);
  }

  // A triangle that the circle crosses in gentle arcs.
  Vec4d clipped(const Triangle& t) {
    const std::array<Vec3d, 3> corner = {t.a, t.b, t.c};
    std::vector<std::pair<Vec3d, Vec3d>> chords;  // the edges' parts inside, in order
    for (std::size_t e = 0; e < 3; ++e) {
      const Vec3d from = corner[e] - disc_.center;
      const Vec3d along = corner[(e + 1) % 3] - corner[e];
      const double length2 = along.squaredNorm();
      const double middle = -from.dot(along) / length2;
      const double half2 = middle * middle - (from.squaredNorm() - disc_.radius * disc_.radius) / length2;
      if (!(half2 > 0.0)) continue;
      const double first = std::clamp(middle - std::sqrt(half2), 0.0, 1.0);
      const double last = std::clamp(middle + std::sqrt(half2), 0.0, 1.0);
      if (last > first) chords.emplace_back(corner[e] + first * along, corner[e] + last * along);
    }
    Vec4d sum = Vec4d::Zero();
    for (std::size_t i = 0; i < chords.size(); ++i) {
      const auto& [start, end] = chords[i];
      const Vec3d& next = chords[(i + 1) % chords.size()].first;
      sum += refined(Triangle{chords.front().first, start, end}, 0);
      sum += refined(Triangle{chords.front().first, end, next}, 0);
      const double from = disc_.angle_of(end);
      double span = disc_.angle_of(next) - from;
      if (span < 0.0) span += 2.0 * kPi;
      // In so small a triangle, a larger span is one of 0, rounded: the chords meet in a corner.
      if (span < 0.5 * kPi) sum += refined(Sliver{from, from + span}, 0);
    }
    return sum;
  }

  // Cuts a triangle until it is short against the Gaussian, and leaves out what lies beyond its reach.
  Vec4d cut_short(const Triangle& t, int depth) {
    const Vec3d middle = (t.a + t.b + t.c) / 3.0;
    const double radius = std::max({(t.a - middle).norm(), (t.b - middle).norm(), (t.c - middle).norm()});
    if ((middle - point_).norm() > reach_mm_ + radius) return Vec4d::Zero();
    if (t.longest_edge() <= layer_.std_dev_mm) return refined(t, 0);
    require(depth < kDeepestCut);
    Vec4d sum = Vec4d::Zero();
    for (const Triangle& part : quarters(t)) sum += cut_short(part, depth + 1);
    return sum;
  }

  Vec4d refined(const Triangle& t, int depth) {
    if (const std::optional<Vec4d> sum = agreed(t, t.area_vector().norm())) return *sum;
    require(depth < kDeepestRefinement);
    Vec4d sum = Vec4d::Zero();
    for (const Triangle& part : quarters(t)) sum += refined(part, depth + 1);
    return sum;
  }

  Vec4d refined(const Sliver& s, int depth) {
    const double span = s.to - s.from;
    const double area = disc_.radius * disc_.radius * span * span * span / 12.0;
    if (const std::optional<Vec4d> sum = agreed(s, area)) return *sum;
    require(depth < kDeepestRefinement);
    const double middle = 0.5 * (s.from + s.to);
    const Triangle between{disc_.at(s.from), disc_.at(middle), disc_.at(s.to)};
    return refined(Sliver{s.from, middle}, depth + 1) + refined(Sliver{middle, s.to}, depth + 1) +
           refined(between, depth + 1);
  }

  // The integral over a part, if two rules agree on it.
  template <typename Part>
  std::optional<Vec4d> agreed(const Part& part, double area) const {
    const Vec4d allowed = area * (tolerance_per_mm2_ * unit_ + rounding_per_mm2_ * Vec4d(1.0, 1.0, 1.0, 0.0));
    Vec4d coarse = integral(part, brute_rules()[0]);
    for (std::size_t k = 1; k < brute_rules().size(); ++k) {
      const Vec4d fine = integral(part, brute_rules()[k]);
      if (((fine - coarse).cwiseAbs().array() <= allowed.array()).all()) return fine;
      coarse = fine;
    }
    return std::nullopt;
  }

  // a + u ((b - a) + v (c - b)) over the unit square.
  Vec4d integral(const Triangle& t, const LineRule& rule) const {
    const double twice_area = 2.0 * t.area_vector().norm();
    return over_square(rule, [&](double u, double v) {
      return std::pair(Vec3d(t.a + u * ((1.0 - v) * (t.b - t.a) + v * (t.c - t.a))), twice_area * u);
    });
  }

  // From the chord (u = 0) to the arc (u = 1), in axes through the middle of the arc. The rise is written so
  // that it keeps its digits where the arc is short.
  Vec4d integral(const Sliver& s, const LineRule& rule) const {
    const double middle = 0.5 * (s.from + s.to);
    const double half = 0.5 * (s.to - s.from);
    const Vec3d outward = (disc_.at(middle) - disc_.center) / disc_.radius;
    const Vec3d sideways = std::cos(middle) * disc_.y - std::sin(middle) * disc_.x;
    return over_square(rule, [&](double u, double v) {
      const double angle = (2.0 * v - 1.0) * half;
      const Vec2d low(std::cos(half), (2.0 * v - 1.0) * std::sin(half));
      const Vec2d rise(2.0 * std::sin(0.5 * (half + angle)) * std::sin(0.5 * (half - angle)),
                       std::sin(angle) - low.y());
      const Vec2d along(-2.0 * half * u * std::sin(angle),
                        2.0 * (1.0 - u) * std::sin(half) + 2.0 * half * u * std::cos(angle));
      const Vec2d at = low + u * rise;
      return std::pair(Vec3d(disc_.center + disc_.radius * (at.x() * outward + at.y() * sideways)),
                       disc_.radius * disc_.radius * std::abs(rise.x() * along.y() - rise.y() * along.x()));
    });
  }

  // `map(u, v)` gives a position and the area that the unit square has there.
  template <typename Map>
  Vec4d over_square(const LineRule& rule, const Map& map) const {
    const double two_variances = 2.0 * layer_.std_dev_mm * layer_.std_dev_mm;
    Vec4d sum = Vec4d::Zero();
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      for (std::size_t j = 0; j < rule.nodes.size(); ++j) {
        const auto [x, area] = map(rule.nodes[i], rule.nodes[j]);
        const double gauss = std::exp(-(x - point_).squaredNorm() / two_variances) / (kPi * two_variances);
        const Vec3d irradiance = irradiance_at_a_ + gradient_ * (x - triangle_.a);
        const double weight = rule.weights[i] * rule.weights[j] * area * gauss;
        sum += weight * Vec4d(irradiance.x(), irradiance.y(), irradiance.z(), 1.0);
      }
    }
    return sum;
  }

  static void require(bool in_reach) {
    if (in_reach) return;
    throw_run_error(
        "plain quadrature does not reach the tolerance: two rules still differ on the smallest part");
  }

  Triangle triangle_;
  Vec3d point_;
  TruthLayer layer_;
  double reach_mm_;
  double tolerance_per_mm2_;
  double rounding_per_mm2_ = 0.0;
  Vec4d unit_;
  Vec3d irradiance_at_a_;
  Vec3d normal_ = Vec3d::Zero();  // zero: no area
  Mat3d gradient_ = Mat3d::Zero();
  Disc disc_{};
};

}  // namespace

BruteEngine::BruteEngine(const Surface& surface, double tolerance)
    : surface_(surface), tolerance_(tolerance), unit_(Vec4d::Constant(surface.largest_irradiance())) {
  assert(tolerance > 0.0);
  unit_[3] = 1.0;
}

Vec4d BruteEngine::convolve(const SurfacePoint& point, const TruthLayer& layer) const {
  const double tail_mm = layer.std_dev_mm * std::sqrt(-2.0 * std::log(kTailShare * tolerance_));
  const double reach_mm = std::min(tail_mm, layer.r_max_mm);
  std::vector<const SurfaceTriangle*> near;
  double area = 0.0;
  for (const SurfaceTriangle& t : surface_.triangles) {
    const auto& x = t.corners_mm;
    if (t.component != point.component) continue;
    if (squared_distance_to_triangle(point.position_mm, x[0], x[1], x[2]) > reach_mm * reach_mm) continue;
    near.push_back(&t);
    // No more of a plane than this is integrated: parts of at most s that come within reach.
    const double widest = reach_mm + 2.0 * layer.std_dev_mm;
    area += std::min(t.area_mm2(), kPi * widest * widest);
  }
  Vec4d sum = Vec4d::Zero();
  for (const SurfaceTriangle* t : near) {
    sum += TriangleIntegral(*t, point.position_mm, layer, tail_mm, tolerance_ / area, unit_).value();
  }
  return sum;
}

}  // namespace truescatter
