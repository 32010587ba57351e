#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/vec.h"

namespace truescatter::sculpt {

// Sculptor's tools on fields of approximate distance in millimetres (negative inside).

inline double square(double x) { return x * x; }

// The union and the intersection, rounded over `k_mm` with a cubic, so that shading shows no bands.
inline double smooth_union(double a, double b, double k_mm) {
  const double h = std::max(k_mm - std::abs(a - b), 0.0) / k_mm;
  return std::min(a, b) - h * h * h * k_mm / 6.0;
}
inline double smooth_intersection(double a, double b, double k_mm) { return -smooth_union(-a, -b, k_mm); }
inline double smooth_difference(double a, double b, double k_mm) { return smooth_intersection(a, -b, k_mm); }

// A bump of height 1 at 0 that ends smoothly at 1.
inline double bump(double t) {
  const double s = 1.0 - t * t;
  return s <= 0.0 ? 0.0 : s * s * s;
}

inline double smooth_step(double edge0, double edge1, double x) {
  const double t = std::clamp((x - edge0) / (edge1 - edge0), 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

struct Ellipsoid {
  Vec3d center_mm;
  Vec3d radii_mm;

  double distance_mm(const Vec3d& p) const {
    const Vec3d q = (p - center_mm).cwiseQuotient(radii_mm);
    const double k0 = q.norm();
    const double k1 = q.cwiseQuotient(radii_mm).norm();
    return k0 * (k0 - 1.0) / (k1 + 1e-12);
  }
  // 1 at the centre, 0 from the surface on: a soft brush.
  double brush(const Vec3d& p) const { return bump((p - center_mm).cwiseQuotient(radii_mm).norm()); }
};

// A capsule whose two ends may have different radii.
struct Capsule {
  Vec3d a_mm;
  double radius_a_mm;
  Vec3d b_mm;
  double radius_b_mm;

  double distance_mm(const Vec3d& p) const {
    const Vec3d axis = b_mm - a_mm;
    const double t = std::clamp((p - a_mm).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    return (p - a_mm - t * axis).norm() - (radius_a_mm + t * (radius_b_mm - radius_a_mm));
  }
};

// A point of a curve and the half width of what is swept along it there.
struct Knot {
  Vec3d point_mm;
  double radius_mm;
};

// A smooth curve through knots, with a varying radius.
class Sweep {
 public:
  Sweep() = default;
  explicit Sweep(const std::vector<Knot>& knots);

  // Distance to the swept tube.
  double distance_mm(const Vec3d& p) const;
  // The radius on the curve, 0 beyond that from it: presses a groove that is in proportion as deep as it
  // is wide, and that fades out over its first and last span.
  double groove_mm(const Vec3d& p) const;
  // A lower bound of distance_mm that costs next to nothing.
  double far_bound_mm(const Vec3d& p) const { return (p - center_mm_).norm() - bound_mm_; }

 private:
  // Where the curve is nearest to p: the span, and as fraction the place in it. It is a spline, not a
  // polygon, so distances are smooth.
  double nearest(const Vec3d& p) const;
  Knot at(double s) const;

  std::vector<Knot> knots_;
  std::vector<Vec3d> samples_mm_;  // kSamplesPerSpan to a span
  Vec3d center_mm_ = Vec3d::Zero();
  double bound_mm_ = 0.0;
};

}  // namespace truescatter::sculpt
