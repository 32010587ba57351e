#include "scene/head_sculpt.h"

#include <array>
#include <limits>

namespace truescatter::sculpt {
namespace {

constexpr int kSamplesPerSpan = 4;

}  // namespace

// Catmull-Rom; the span and the place in it are the whole and the fractional part of s.
Knot Sweep::at(double s) const {
  const std::size_t last = knots_.size() - 1;
  const std::size_t i = std::min(std::size_t(s), last - 1);
  const double t = s - double(i);
  const std::array<double, 4> weights = {0.5 * t * (-1.0 + t * (2.0 - t)),
                                         0.5 * (2.0 + t * t * (3.0 * t - 5.0)),
                                         0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * t * (t - 1.0)};
  const std::array<const Knot*, 4> around = {&knots_[i == 0 ? 0 : i - 1], &knots_[i], &knots_[i + 1],
                                             &knots_[std::min(i + 2, last)]};
  Knot result{Vec3d::Zero(), 0.0};
  for (std::size_t k = 0; k < 4; ++k) {
    result.point_mm += weights[k] * around[k]->point_mm;
    result.radius_mm += weights[k] * around[k]->radius_mm;
  }
  return result;
}

Sweep::Sweep(const std::vector<Knot>& knots) : knots_(knots) {
  const std::size_t count = (knots_.size() - 1) * kSamplesPerSpan + 1;
  double widest_mm = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Knot knot = at(double(i) / kSamplesPerSpan);
    samples_mm_.push_back(knot.point_mm);
    center_mm_ += knot.point_mm / double(count);
    widest_mm = std::max(widest_mm, knot.radius_mm);
  }
  for (const Vec3d& s : samples_mm_) bound_mm_ = std::max(bound_mm_, (s - center_mm_).norm() + widest_mm);
}

double Sweep::nearest(const Vec3d& p) const {
  double best_squared = std::numeric_limits<double>::max();
  double s = 0.0;
  for (std::size_t i = 0; i + 1 < samples_mm_.size(); ++i) {
    const Vec3d axis = samples_mm_[i + 1] - samples_mm_[i];
    const Vec3d offset = p - samples_mm_[i];
    const double t = std::clamp(offset.dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    const double squared = (offset - t * axis).squaredNorm();
    if (squared >= best_squared) continue;
    best_squared = squared;
    s = (double(i) + t) / kSamplesPerSpan;
  }
  // The chord's parameter is close; Gauss-Newton steps end on the curve itself.
  const double end = double(knots_.size()) - 1.0;
  for (int step = 0; step < 2; ++step) {
    constexpr double h = 1e-4;
    const Vec3d here = at(s).point_mm;
    const Vec3d tangent = (at(s + h).point_mm - here) / h;
    s = std::clamp(s + (p - here).dot(tangent) / tangent.squaredNorm(), 0.0, end);
  }
  return s;
}

double Sweep::distance_mm(const Vec3d& p) const {
  const Knot knot = at(nearest(p));
  return (p - knot.point_mm).norm() - knot.radius_mm;
}

double Sweep::groove_mm(const Vec3d& p) const {
  if (far_bound_mm(p) > 0.0) return 0.0;
  const double s = nearest(p);
  const Knot knot = at(s);
  const double end = double(knots_.size()) - 1.0;
  const double fade = smooth_step(0.0, 1.0, s) * smooth_step(0.0, 1.0, end - s);
  return fade * knot.radius_mm * bump((p - knot.point_mm).norm() / knot.radius_mm);
}

}  // namespace truescatter::sculpt
