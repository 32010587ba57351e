#include "truth/face_integral.h"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>

namespace truescatter {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxDepth = 44;
// Standard deviations; beyond lies exp(-8.6^2 / 2) = 9e-17 of a plane's mass.
constexpr double kReach = 8.6;
constexpr double kTouch = 1e-12;  // of a face's size, squared

double cross(const Vec2d& a, const Vec2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// int_0^rho t f(offset + t) dt and int_0^rho t^2 f(offset + t) dt for the Gaussian f of standard deviation s.
// With q = offset + t and E' = f: int q f = -s^2 f, int q^2 f = s^2 (E - q f).
class RadialIntegrals {
 public:
  RadialIntegrals(double std_dev_mm, double offset_mm)
      : s_(std_dev_mm), offset_(offset_mm), f0_(f(offset_mm)), e0_(e(offset_mm)) {}

  struct Pair {
    double a;
    double b;
  };
  Pair at(double rho) const {
    const double q = offset_ + rho;
    const double df = f(q) - f0_;
    const double de = e(q) - e0_;
    const double s2 = s_ * s_;
    const double dqf = q * f(q) - offset_ * f0_;
    return {-s2 * df - offset_ * de, s2 * (de - dqf) + 2.0 * offset_ * s2 * df + offset_ * offset_ * de};
  }

 private:
  double f(double q) const { return std::exp(-0.5 * (q / s_) * (q / s_)) / (2.0 * kPi * s_ * s_); }
  double e(double q) const {
    return std::sqrt(0.5 * kPi) / (2.0 * kPi * s_) * std::erf(q / (s_ * std::sqrt(2.0)));
  }

  double s_;
  double offset_;
  double f0_;
  double e0_;
};

// Along the ray source + rho u: where rho lies within a linear bound a + rho b <= 0.
void clip(double a, double b, double& low, double& high) {
  if (b > 0.0) {
    high = std::min(high, -a / b);
  } else if (b < 0.0) {
    low = std::max(low, -a / b);
  } else if (a > 0.0) {
    high = -kInfinity;
  }
}

// The part of a polygon that a window covers.
std::vector<Vec2d> covered(const GeodesicWindow& window, std::vector<Vec2d> polygon) {
  if (window.all_round) return polygon;
  for (const bool left : {true, false}) {
    std::vector<Vec2d> kept;
    const auto over = [&](const Vec2d& x) {
      const Vec2d d = x - window.source;
      return left ? cross(window.left, d) : cross(d, window.right);
    };
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec2d& a = polygon[i];
      const Vec2d& b = polygon[(i + 1) % polygon.size()];
      const double at_a = over(a);
      const double at_b = over(b);
      if (at_a <= 0.0) kept.push_back(a);
      if ((at_a < 0.0 && at_b > 0.0) || (at_a > 0.0 && at_b < 0.0))
        kept.emplace_back(a + at_a / (at_a - at_b) * (b - a));
    }
    polygon = std::move(kept);
  }
  return polygon;
}

}  // namespace

FaceIntegral::FaceIntegral(const IntrinsicMesh& mesh, const GeodesicField& field, std::size_t face,
                           double quadrature_error)
    : quadrature_error_(quadrature_error) {
  for (int j = 0; j < 3; ++j) corners_[static_cast<std::size_t>(j)] = mesh.corner(face, j);
  size_mm_ = corners_[1].norm() + corners_[2].norm();
  for (std::int32_t i = field.first_window(face); i >= 0; i = field.window(i).next)
    windows_.push_back(field.window(i));
}

// Adds what every window owns of the pieces of `component`.
void FaceIntegral::add(std::span<const FlatPiece> pieces, int component, std::span<const TruthLayer> layers,
                       std::span<Vec4d> sums) {
  for (std::size_t w = 0; w < windows_.size(); ++w) {
    choose(w);
    for (const FlatPiece& piece : pieces) {
      if (piece.component != component) continue;
      for (std::size_t l = 0; l < layers.size(); ++l) sums[l] += owned(piece, layers[l]);
    }
  }
}

// Makes a window the current one, and finds the windows that may take points from it.
void FaceIntegral::choose(std::size_t w) {
  window_ = &windows_[w];
  rivals_.clear();
  turning_points_.clear();
  const std::vector<Vec2d> mine = covered(*window_, {corners_.begin(), corners_.end()});
  for (std::size_t other = 0; other < windows_.size(); ++other) {
    if (other == w) continue;
    const std::vector<Vec2d> shared = covered(windows_[other], mine);
    if (!may_take(windows_[other], shared)) continue;
    rivals_.push_back(&windows_[other]);
    for (std::size_t i = 0; i < shared.size(); ++i) {
      const Vec2d& a = shared[i];
      const Vec2d& b = shared[(i + 1) % shared.size()];
      turning_points_.push_back(a);
      for (const double t : equal_lengths(windows_[other], a, b))
        turning_points_.emplace_back(a + t * (b - a));
    }
  }
}

// Where between a and b the rival's paths may be as long as the current window's: fractions, at most two.
// On a line |x - s| = |x - s'| + l squares to 2 l |x - s'| = linear, and again to a quadratic equation;
// what squaring adds does no harm here.
std::vector<double> FaceIntegral::equal_lengths(const GeodesicWindow& rival, const Vec2d& a,
                                                const Vec2d& b) const {
  const double l = rival.offset_mm - window_->offset_mm;
  const Vec2d e = b - a;
  const Vec2d from_mine = a - window_->source;
  const Vec2d from_rival = a - rival.source;
  const Vec2d apart = rival.source - window_->source;
  // The difference of squares as a product: sources may lie close together, and far from here.
  const double c0 = apart.dot(from_mine + from_rival) - l * l;
  const double c1 = 2.0 * e.dot(apart);
  const double q2 = c1 * c1 - 4.0 * l * l * e.squaredNorm();
  const double q1 = c0 * c1 - 4.0 * l * l * e.dot(from_rival);  // half the middle coefficient
  const double q0 = c0 * c0 - 4.0 * l * l * from_rival.squaredNorm();
  std::vector<double> roots;
  const auto keep = [&](double t) {
    if (t > 0.0 && t < 1.0) roots.push_back(t);
  };
  const double root = std::sqrt(std::max(0.0, q1 * q1 - q2 * q0));
  const double q = -(q1 + std::copysign(root, q1));
  if (q2 != 0.0) keep(q / q2);
  if (q != 0.0) keep(q0 / q);
  return roots;
}

// Whether `rival` may have the shorter paths somewhere in `shared`, which both windows cover.
bool FaceIntegral::may_take(const GeodesicWindow& rival, const std::vector<Vec2d>& shared) const {
  // Where two windows touch along a ray, rounding makes an overlap of nothing.
  double twice_area = 0.0;
  for (std::size_t i = 2; i < shared.size(); ++i)
    twice_area += cross(shared[i - 1] - shared[0], shared[i] - shared[0]);
  if (!(twice_area > kTouch * size_mm_ * size_mm_)) return false;
  Vec2d center = Vec2d::Zero();
  for (const Vec2d& x : shared) center += x / static_cast<double>(shared.size());
  double radius = 0.0;
  double longest = 0.0;  // of the current window's paths: convex, so at a corner
  for (const Vec2d& x : shared) {
    radius = std::max(radius, (x - center).norm());
    longest = std::max(longest, window_->distance(x));
  }
  return rival.distance(center) - radius < longest;
}

// How far along the ray at `u` the current window owns its points.
double FaceIntegral::owned_up_to(const Vec2d& u) const {
  if (rivals_.empty()) return kInfinity;
  const Vec2d& s = window_->source;
  double enters = 0.0;
  double leaves = kInfinity;
  for (std::size_t j = 0; j < 3; ++j) {
    const Vec2d edge = corners_[(j + 1) % 3] - corners_[j];
    clip(-cross(edge, s - corners_[j]), -cross(edge, u), enters, leaves);
  }
  double limit = kInfinity;
  for (const GeodesicWindow* rival : rivals_) {
    double from = enters;
    double to = leaves;
    const Vec2d d = s - rival->source;
    if (!rival->all_round) {
      clip(cross(rival->left, d), cross(rival->left, u), from, to);
      clip(cross(d, rival->right), cross(u, rival->right), from, to);
    }
    // |rho u + d| + rival offset < rho + offset: the difference falls along the ray.
    const double lead = window_->offset_mm - rival->offset_mm;
    const double slope = lead - u.dot(d);
    if (slope > 0.0)
      from = std::max(from, (d.squaredNorm() - lead * lead) / (2.0 * slope));
    else
      continue;
    if (from < to) limit = std::min(limit, from);
  }
  return limit;
}

Vec4d FaceIntegral::owned(const FlatPiece& piece, const TruthLayer& layer) const {
  const Vec2d& s = window_->source;
  // Nothing to rounding lies beyond 40 standard deviations; infinity would have no integrals.
  const double room = std::min(layer.r_max_mm, 40.0 * layer.std_dev_mm) - window_->offset_mm;
  if (room <= 0.0) return Vec4d::Zero();
  const Vec2d centroid = (piece.corners_mm[0] + piece.corners_mm[1] + piece.corners_mm[2]) / 3.0;
  double radius = 0.0;
  for (const Vec2d& corner : piece.corners_mm) radius = std::max(radius, (corner - centroid).norm());
  if (window_->distance(centroid) - radius > std::min(layer.r_max_mm, kReach * layer.std_dev_mm))
    return Vec4d::Zero();
  // Irradiance about the source.
  const Vec2d e1 = piece.corners_mm[1] - piece.corners_mm[0];
  const Vec2d e2 = piece.corners_mm[2] - piece.corners_mm[0];
  const double twice_area = cross(e1, e2);
  if (!(twice_area > 0.0)) return Vec4d::Zero();
  const std::vector<Vec2d> seen = covered(*window_, {piece.corners_mm.begin(), piece.corners_mm.end()});
  if (seen.size() < 3) return Vec4d::Zero();
  const Vec3d d1 = piece.irradiance[1] - piece.irradiance[0];
  const Vec3d d2 = piece.irradiance[2] - piece.irradiance[0];
  const Vec3d gx = (d1 * e2.y() - d2 * e1.y()) / twice_area;
  const Vec3d gy = (d2 * e1.x() - d1 * e2.x()) / twice_area;
  const Vec2d to_source = s - piece.corners_mm[0];
  const Vec3d i0 = piece.irradiance[0] + gx * to_source.x() + gy * to_source.y();

  const RadialIntegrals radial(layer.std_dev_mm, window_->offset_mm);
  Vec4d sum = Vec4d::Zero();
  for (std::size_t e = 0; e < seen.size(); ++e) {
    const Vec2d a = seen[e] - s;
    const Vec2d b = seen[(e + 1) % seen.size()] - s;
    const double length = (b - a).norm();
    if (!(length > 0.0)) continue;
    const Vec2d along = (b - a) / length;
    const double p = cross(a, along);  // positive: the source lies on the inner side
    // Rays along the edge sweep no area.
    if (std::abs(p) <= 1e-15 * (a.norm() + b.norm())) continue;
    const double distance = std::abs(p);
    const Vec2d to_foot = (p > 0.0 ? 1.0 : -1.0) * Vec2d(along.y(), -along.x());
    // theta = atan(sinh w): rho = |p| cosh w, and dtheta = dw / cosh w stays smooth however close the edge.
    const auto integrand = [&](double w) -> Vec4d {
      const double c = std::cosh(w);
      const Vec2d u = to_foot / c + along * std::tanh(w);
      const RadialIntegrals::Pair value = radial.at(std::min({distance * c, owned_up_to(u), room}));
      Vec4d result;
      result.head<3>() = i0 * value.a + (gx * u.x() + gy * u.y()) * value.b;
      result[3] = value.a;
      return result / c;
    };
    std::vector<double> breaks = {std::asinh(a.dot(along) / distance), std::asinh(b.dot(along) / distance)};
    if (room > distance) {
      const double half_chord = std::sqrt((room - distance) * (room + distance));
      for (const double t : {-half_chord, half_chord}) {
        const double w = std::asinh(t / distance);
        if (w > breaks[0] && w < breaks[1]) breaks.push_back(w);
      }
    }
    for (const GeodesicWindow* rival : rivals_) {
      for (const double t : equal_lengths(*rival, seen[e], seen[(e + 1) % seen.size()]))
        breaks.push_back(std::asinh((a + t * (b - a)).dot(along) / distance));
    }
    for (const Vec2d& x : turning_points_) {
      const double ahead = (x - s).dot(to_foot);
      if (ahead <= 0.0) continue;
      const double w = std::asinh((x - s).dot(along) / ahead);
      if (w > breaks[0] && w < breaks[1]) breaks.push_back(w);
    }
    std::sort(breaks.begin(), breaks.end());
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
      sum += (p > 0.0 ? 1.0 : -1.0) * adaptive(integrand, breaks[i], breaks[i + 1], 0);
  }
  return sum;
}

// Gauss-Kronrod with 7 and 15 nodes, halved until the two agree.
template <typename Integrand>
Vec4d FaceIntegral::adaptive(const Integrand& integrand, double from, double to, int depth) const {
  using Kronrod = boost::math::quadrature::gauss_kronrod<double, 15>;
  using Gauss = boost::math::quadrature::gauss<double, 7>;
  const auto& nodes = Kronrod::abscissa();
  const auto& weights = Kronrod::weights();
  const auto& gauss_weights = Gauss::weights();
  const double middle = 0.5 * (from + to);
  const double half = 0.5 * (to - from);
  Vec4d fine = weights[0] * integrand(middle);
  Vec4d coarse = fine * (gauss_weights[0] / weights[0]);
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const Vec4d pair = integrand(middle - half * nodes[i]) + integrand(middle + half * nodes[i]);
    fine += weights[i] * pair;
    if (i % 2 == 0) coarse += gauss_weights[i / 2] * pair;
  }
  const Vec4d error = (fine - coarse) * half;
  const double size = (fine * half).cwiseAbs().maxCoeff();
  if (depth >= kMaxDepth || error.cwiseAbs().maxCoeff() <= quadrature_error_ + 1e-14 * size)
    return fine * half;
  return adaptive(integrand, from, middle, depth + 1) + adaptive(integrand, middle, to, depth + 1);
}

}  // namespace truescatter
