#include "truth/piece_integral.h"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cassert>
#include <cmath>
#include <limits>

#include "truth/edge_fast.h"
#include "truth/exact.h"
#include "truth/needle.h"

namespace truescatter {
namespace {

constexpr int kMaxDepth = 44;
constexpr double kTouch = 1e-12;   // of a piece's size, squared
constexpr double kNoEdge = 1e-14;  // of a piece's size
constexpr double kNoAngle = 1e-13;
// Of the coordinates' extent: a difference of coordinates and a cross product with a unit vector round by
// some 6 units of 1.1e-16 of it, a corner that an earlier cut computed by as much again.
constexpr double kOnRay = 2e-15;
// Beyond, an edge adds less than exp(-5.7^2 / 2) = 1e-7.
constexpr double kFarEdge = 5.7;
constexpr double kSteep = 30.0;        // gains of irradiance that errors of 1e-7 may have
constexpr std::size_t kMaxGroup = 16;  // layers that are integrated at once
constexpr double kThinSlack = 1e-11;   // of a piece's size: how far beyond its rays a window is followed
constexpr double kThin = 1e-6;         // heights in deviations: below, PieceIntegral::add_thin
constexpr double kNeedle = 1e-2;       // and below that, convolve_needle where it applies (needle.h)
constexpr double kNeedleCut = 1e-3;    // with a cut-off

Vec2d turned_left(const Vec2d& v) { return {-v.y(), v.x()}; }
Vec2d turned_right(const Vec2d& v) { return {v.y(), -v.x()}; }

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
    const double fq = f(q);
    const double df = fq - f0_;
    const double de = e(q) - e0_;
    const double s2 = s_ * s_;
    const double dqf = q * fq - offset_ * f0_;
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

// The nodes of a rule of Gauss and Legendre on [from, to]: visit(x, weight).
template <typename Rule, typename Visit>
void for_each_node(double from, double to, const Visit& visit) {
  const double middle = 0.5 * (from + to);
  const double half = 0.5 * (to - from);
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
    const double x = Rule::abscissa()[i];
    visit(middle + half * x, half * Rule::weights()[i]);
    if (x > 0.0) visit(middle - half * x, half * Rule::weights()[i]);
  }
}

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

// int_0^rho F(min(t, r_max)) dt for F(r) = -exp(-r^2 / 2s^2) / 2 pi.
double along_ray(double rho, const TruthLayer& layer) {
  const double s = layer.std_dev_mm;
  const double inside = std::min(rho, layer.r_max_mm);
  double sum = s * std::sqrt(0.5 * kPi) * std::erf(inside / (s * std::sqrt(2.0)));
  if (rho > layer.r_max_mm) sum += gauss_at(layer.r_max_mm, s) * (rho - layer.r_max_mm);
  return -sum / (2.0 * kPi);
}

}  // namespace

FlatPolygon covered(const GeodesicWindow& window, const FlatPolygon& polygon) {
  if (window.all_round) return polygon;
  FlatPolygon rest = polygon;
  // A corner on a ray has a side by rounding alone, and corners along the ray would cross it to and fro.
  double extent_mm = window.source.lpNorm<Eigen::Infinity>();
  for (std::size_t i = 0; i < polygon.size; ++i)
    extent_mm = std::max(extent_mm, polygon[i].lpNorm<Eigen::Infinity>());
  const double on_ray_mm = kOnRay * extent_mm;
  for (const bool left : {true, false}) {
    const auto over = [&](const Vec2d& x) {
      const Vec2d d = x - window.source;
      const double side = left ? cross(window.left, d) : cross(d, window.right);
      return std::abs(side) <= on_ray_mm ? 0.0 : side;
    };
    FlatPolygon kept;
    for (std::size_t i = 0; i < rest.size; ++i) {
      const Vec2d& a = rest[i];
      const Vec2d& b = rest.after(i);
      const double at_a = over(a);
      const double at_b = over(b);
      if (at_a <= 0.0) kept.push_back(a);
      if ((at_a < 0.0 && at_b > 0.0) || (at_a > 0.0 && at_b < 0.0))
        kept.push_back(a + at_a / (at_a - at_b) * (b - a));
    }
    rest = kept;
    if (rest.size < 3) return {};
  }
  return rest;
}

void PieceIntegral::add(const FlatPiece& piece, std::span<const GeodesicWindow* const> windows,
                        std::span<const TruthLayer> layers, std::span<Vec4d> sums) {
  const Vec2d e1 = piece.corners_mm[1] - piece.corners_mm[0];
  const Vec2d e2 = piece.corners_mm[2] - piece.corners_mm[0];
  const double twice_area = cross(e1, e2);
  if (!(twice_area > 0.0)) return;
  size_mm_ = e1.norm() + e2.norm();
  const Vec3d d1 = piece.irradiance[1] - piece.irradiance[0];
  const Vec3d d2 = piece.irradiance[2] - piece.irradiance[0];
  gradient_x_ = (d1 * e2.y() - d2 * e1.y()) / twice_area;
  gradient_y_ = (d2 * e1.x() - d1 * e2.x()) / twice_area;
  // Errors of edges are errors of the irradiance extrapolated to the source, times as large.
  const double steepness = (gradient_x_.cwiseAbs() + gradient_y_.cwiseAbs()).maxCoeff();
  double reach_mm = 0.0;
  for (const TruthLayer& layer : layers) reach_mm = std::max(reach_mm, kFarEdge * layer.std_dev_mm);
  exact_edges_ = accuracy_.to_rounding || steepness * reach_mm > kSteep * accuracy_.largest_irradiance;
  height_mm_ = twice_area / std::max({e1.norm(), e2.norm(), (e2 - e1).norm()});
  for (std::size_t l = 0; l < layers.size(); ++l) {
    if (is_thin(layers[l])) add_thin(piece, windows, layers[l], sums[l]);
  }
  const Vec2d centroid = piece.centroid_mm();
  const double radius_mm = piece.radius_mm();
  for (const GeodesicWindow* window : windows) {
    window_ = window;
    if (!choose_layers(window->distance(centroid) - radius_mm, layers)) continue;
    take_window(piece);
    if (seen_.size < 3) continue;
    find_rivals(windows);
    if (rivals_.empty() && window->offset_mm == 0.0) {
      add_polygon(piece, layers, sums);
      continue;
    }
    for (std::size_t e = 0; e < seen_.size; ++e) {
      // A sector of no angle has no area.
      const Edge& far = edges_[e];
      if (far.line.p > 1e-15 * (seen_[e].norm() + seen_.after(e).norm())) add_far_edge(far, layers, sums);
    }
  }
}

// Those that reach the piece, to which the current window's paths are no shorter than `nearest_mm`.
bool PieceIntegral::choose_layers(double nearest_mm, std::span<const TruthLayer> layers) {
  layers_.clear();
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const double reach = std::min(layers[l].r_max_mm, accuracy_.reach_std_devs * layers[l].std_dev_mm);
    if (nearest_mm < reach && window_->offset_mm < reach && !is_thin(layers[l])) layers_.push_back(l);
  }
  return !layers_.empty();
}

// The part of the piece that the window covers and its edges, about the window's source.
void PieceIntegral::take_window(const FlatPiece& piece) {
  FlatPolygon whole;
  for (const Vec2d& corner : piece.corners_mm) whole.push_back(corner);
  seen_ = covered(*window_, whole);
  const Vec2d to_source = window_->source - piece.corners_mm[0];
  i0_ = piece.irradiance[0] + gradient_x_ * to_source.x() + gradient_y_ * to_source.y();
  for (std::size_t e = 0; e < seen_.size; ++e) seen_.corners[e] -= window_->source;
  for (std::size_t e = 0; e < seen_.size; ++e) {
    const Vec2d& a = seen_[e];
    const Vec2d& b = seen_.after(e);
    const double length = (b - a).norm();
    // Rounding makes edges without a direction where a ray passes a corner.
    const Vec2d along = length > kNoEdge * size_mm_ ? Vec2d((b - a) / length) : Vec2d(Vec2d::Zero());
    edges_[e] = {{turned_right(along), along, cross(a, along)}, a.dot(along), b.dot(along)};
  }
}

// The windows that may take points from the current one, and where ownership may change.
void PieceIntegral::find_rivals(std::span<const GeodesicWindow* const> windows) {
  rivals_.clear();
  turning_points_.clear();
  if (windows.size() == 1) return;
  FlatPolygon mine = seen_;
  for (std::size_t i = 0; i < mine.size; ++i) mine.corners[i] += window_->source;
  for (const GeodesicWindow* rival : windows) {
    if (rival == window_) continue;
    const FlatPolygon shared = covered(*rival, mine);
    if (!may_take(*rival, shared)) continue;
    rivals_.push_back(rival);
    for (std::size_t i = 0; i < shared.size; ++i) {
      const Vec2d& a = shared[i];
      const Vec2d& b = shared.after(i);
      turning_points_.emplace_back(a - window_->source);
      for (const double t : equal_lengths(*rival, a, b)) {
        if (t > 0.0 && t < 1.0) turning_points_.emplace_back(a + t * (b - a) - window_->source);
      }
    }
  }
}

// Where between a and b the rival's paths may be as long as the current window's, as fractions (not between 0
// and 1: nowhere). On a line |x - s| = |x - s'| + l squares to 2 l |x - s'| = linear, and again to a
// quadratic equation; what squaring adds does no harm here.
std::array<double, 2> PieceIntegral::equal_lengths(const GeodesicWindow& rival, const Vec2d& a,
                                                   const Vec2d& b) const {
  const double l = rival.offset_mm - window_->offset_mm;
  const Vec2d e = b - a;
  const Vec2d from_mine = a - window_->source;
  const Vec2d from_rival = a - rival.source;
  const Vec2d apart = rival.source - window_->source;
  // The difference of squares as a product: sources may lie close together, and far from here.
  const double c0 = apart.dot(from_mine + from_rival) - l * l;
  const double c1 = 2.0 * e.dot(apart);
  if (l == 0.0) return {c1 != 0.0 ? -c0 / c1 : -1.0, -1.0};
  const double q2 = c1 * c1 - 4.0 * l * l * e.squaredNorm();
  const double q1 = c0 * c1 - 4.0 * l * l * e.dot(from_rival);  // half the middle coefficient
  const double q0 = c0 * c0 - 4.0 * l * l * from_rival.squaredNorm();
  const double root = std::sqrt(std::max(0.0, q1 * q1 - q2 * q0));
  const double q = -(q1 + std::copysign(root, q1));
  return {q2 != 0.0 ? q / q2 : -1.0, q != 0.0 ? q0 / q : -1.0};
}

// Whether `rival` may have the shorter paths somewhere in `shared`, which both windows cover.
bool PieceIntegral::may_take(const GeodesicWindow& rival, const FlatPolygon& shared) const {
  // Where two windows touch along a ray, rounding makes an overlap of nothing.
  double twice_area = 0.0;
  for (std::size_t i = 2; i < shared.size; ++i)
    twice_area += cross(shared[i - 1] - shared[0], shared[i] - shared[0]);
  if (!(twice_area > kTouch * size_mm_ * size_mm_)) return false;
  Vec2d center = Vec2d::Zero();
  for (std::size_t i = 0; i < shared.size; ++i) center += shared[i] / static_cast<double>(shared.size);
  double radius = 0.0;
  double longest = 0.0;  // of the current window's paths: convex, so at a corner
  for (std::size_t i = 0; i < shared.size; ++i) {
    radius = std::max(radius, (shared[i] - center).norm());
    longest = std::max(longest, window_->distance(shared[i]));
  }
  return rival.distance(center) - radius < longest;
}

EdgeIntegrals PieceIntegral::edge(double p, double t0, double t1, const TruthLayer& layer) const {
  const double s = layer.std_dev_mm;
  if (!exact_edges_) {
    const double t = t0 > 0.0 ? t0 : std::min(t1, 0.0);
    const double reach = kFarEdge * s;
    if (p * p + t * t > reach * reach && layer.r_max_mm == kInfinity)
      return {std::atan2(p * (t1 - t0), p * p + t0 * t1) / (2.0 * kPi), 0.0};
  }
  const auto inside = [&](double q, double from, double to, double at_foot) {
    return exact_edges_ ? edge_inside_exact(q, from, to, s, at_foot)
                        : edge_inside_fast(q, from, to, s, at_foot);
  };
  if (layer.r_max_mm == kInfinity) return inside(p, t0, t1, 1.0);
  return edge_of_inner_part(p, t0, t1, 0.0, layer.r_max_mm, 1.0, gauss_at(layer.r_max_mm, s), inside);
}

Vec4d PieceIntegral::combine(double radial, const Vec2d& line) const {
  Vec4d sum;
  sum.head<3>() = i0_ * radial + gradient_x_ * line.x() + gradient_y_ * line.y();
  sum[3] = radial;
  return sum;
}

bool PieceIntegral::is_thin(const TruthLayer& layer) const { return height_mm_ < kThin * layer.std_dev_mm; }

void PieceIntegral::add_thin(const FlatPiece& piece, std::span<const GeodesicWindow* const> windows,
                             const TruthLayer& layer, Vec4d& sum) const {
  using Along = boost::math::quadrature::gauss<double, 15>;
  using Across = boost::math::quadrature::gauss<double, 7>;
  const double slack = kThinSlack * size_mm_;
  const double reach = std::min(layer.r_max_mm, accuracy_.reach_std_devs * layer.std_dev_mm);
  const auto distance = [&](const Vec2d& x) {
    double shortest = kInfinity;
    for (const GeodesicWindow* window : windows) {
      if (window->beyond_rays(x) <= slack) shortest = std::min(shortest, window->distance(x));
    }
    return shortest;
  };
  std::size_t longest = 0;
  const auto& x = piece.corners_mm;
  for (std::size_t e = 1; e < 3; ++e) {
    if ((x[(e + 1) % 3] - x[e]).norm() > (x[(longest + 1) % 3] - x[longest]).norm()) longest = e;
  }
  // Two parts with a right angle at the foot of the height; each from its sharp end, where rows meet.
  const Vec2d base = x[(longest + 1) % 3] - x[longest];
  const double share =
      std::clamp((x[(longest + 2) % 3] - x[longest]).dot(base) / base.squaredNorm(), 0.0, 1.0);
  const Vec3d top = Vec3d::Unit(static_cast<Eigen::Index>((longest + 2) % 3));
  const Vec3d foot = (1.0 - share) * Vec3d::Unit(static_cast<Eigen::Index>(longest)) +
                     share * Vec3d::Unit(static_cast<Eigen::Index>((longest + 1) % 3));
  for (const std::size_t end : {longest, (longest + 1) % 3}) {
    const Vec3d tip = Vec3d::Unit(static_cast<Eigen::Index>(end));
    const double part = end == longest ? share : 1.0 - share;
    const double twice_area_mm2 = part * 2.0 * piece.area_mm2();
    const int panels = 1 + static_cast<int>(4.0 * part * base.norm() / layer.std_dev_mm);
    const auto row = [&](double v, double weight_v) {
      const Vec3d way = (1.0 - v) * foot + v * top - tip;
      const auto place = [&](double u) -> Vec2d {
        const Vec3d b = tip + u * way;
        return b[0] * x[0] + b[1] * x[1] + b[2] * x[2];
      };
      const auto stretch = [&](double from, double to) {
        const auto node = [&](double u, double weight_u) {
          const double d = distance(place(u));
          if (!(d < reach)) return;
          const double r = d / layer.std_dev_mm;
          const double weight = weight_u * weight_v * u * twice_area_mm2 * std::exp(-0.5 * r * r) /
                                (2.0 * kPi * layer.std_dev_mm * layer.std_dev_mm);
          const Vec3d b = tip + u * way;
          for (std::size_t c = 0; c < 3; ++c)
            sum.head<3>() += weight * b[static_cast<Eigen::Index>(c)] * piece.irradiance[c];
          sum[3] += weight;
        };
        for_each_node<Along>(from, to, node);
      };
      for (int i = 0; i < panels; ++i) {
        const double from = static_cast<double>(i) / panels;
        const double to = static_cast<double>(i + 1) / panels;
        const bool enters = distance(place(from)) < reach;
        if (enters == (distance(place(to)) < reach)) {
          stretch(from, to);
          continue;
        }
        // The cut-off lies in between.
        double low = from;
        double high = to;
        for (int k = 0; k < 50; ++k) {
          const double middle = 0.5 * (low + high);
          ((distance(place(middle)) < reach) == enters ? low : high) = middle;
        }
        enters ? stretch(from, low) : stretch(high, to);
      }
    };
    for_each_node<Across>(0.0, 1.0, row);
  }
}

// A window without rivals and without an offset: all that it sees, edge by edge.
void PieceIntegral::add_polygon(const FlatPiece& piece, std::span<const TruthLayer> layers,
                                std::span<Vec4d> sums) const {
  for (const std::size_t l : layers_) {
    const bool cut = layers[l].r_max_mm < kInfinity;
    if (exact_edges_ && height_mm_ < (cut ? kNeedleCut : kNeedle) * layers[l].std_dev_mm) {
      sums[l] += needle(piece, layers[l]);
      continue;
    }
    double radial = 0.0;
    Vec2d line = Vec2d::Zero();
    for (std::size_t e = 0; e < seen_.size; ++e) {
      if (!(edges_[e].last > edges_[e].first)) continue;
      const EdgeIntegrals part = edge(edges_[e].line.p, edges_[e].first, edges_[e].last, layers[l]);
      radial += part.radial;
      line += part.line * edges_[e].line.normal;
    }
    sums[l] += combine(radial, line);
  }
}

// What is seen of a needle, as a fan of needles about the source.
Vec4d PieceIntegral::needle(const FlatPiece& piece, const TruthLayer& layer) const {
  const auto& x = piece.corners_mm;
  const double twice_area = cross(x[1] - x[0], x[2] - x[0]);
  const auto irradiance_at = [&](const Vec2d& at) -> Vec3d {
    Vec3d b;
    for (std::size_t c = 0; c < 3; ++c)
      b[static_cast<Eigen::Index>(c)] =
          std::max(0.0, cross(x[(c + 1) % 3] - at, x[(c + 2) % 3] - at) / twice_area);
    b /= b.sum();
    return b[0] * piece.irradiance[0] + b[1] * piece.irradiance[1] + b[2] * piece.irradiance[2];
  };
  const auto corner = [&](std::size_t i) { return Vec3d(seen_[i].x(), seen_[i].y(), 0.0); };
  std::array<Vec3d, FlatPolygon::kCapacity> light;
  for (std::size_t i = 0; i < seen_.size; ++i) light[i] = irradiance_at(seen_[i] + window_->source);
  Vec4d sum = Vec4d::Zero();
  for (std::size_t i = 1; i + 1 < seen_.size; ++i)
    sum += convolve_needle({{corner(0), corner(i), corner(i + 1)}, {light[0], light[i], light[i + 1]}, 0},
                           Vec3d::Zero(), layer);
  return sum;
}

// The sectors that end on a far edge, or end before it.
void PieceIntegral::add_far_edge(const Edge& far, std::span<const TruthLayer> layers, std::span<Vec4d> sums) {
  breaks_.clear();
  breaks_.push_back(far.first);
  breaks_.push_back(far.last);
  const auto add_break = [&](const Vec2d& direction) {
    if (direction.dot(far.line.normal) <= 0.0) return;
    const double t = far.line.place_on(direction);
    if (t > far.first && t < far.last) breaks_.push_back(t);
  };
  for (std::size_t i = 0; i < seen_.size; ++i) add_break(seen_[i]);
  for (const Vec2d& x : turning_points_) add_break(x);
  std::sort(breaks_.begin(), breaks_.end());
  for (std::size_t i = 0; i + 1 < breaks_.size(); ++i) {
    if (breaks_[i + 1] > breaks_[i]) add_stretch(far, breaks_[i], breaks_[i + 1], layers, sums);
  }
}

// A stretch of a far edge without turning points inside: what ends its rays is found at a few places, and
// where it changes from one to the next the place of the change.
void PieceIntegral::add_stretch(const Edge& far, double from, double to, std::span<const TruthLayer> layers,
                                std::span<Vec4d> sums) {
  const auto direction_to = [&](double t) -> Vec2d {
    return (far.line.p * far.line.normal + t * far.line.along).normalized();
  };
  const Line near = near_line(direction_to(0.5 * (from + to)));
  if (rivals_.empty()) {
    add_sector({&far, near, from, to, End::kEdge}, layers, sums);
    return;
  }
  const auto end_at = [&](double t) { return end_of_ray(direction_to(t), far).what; };
  constexpr double kMargin = 1e-10;
  const int samples = rivals_.size() > 1 ? 8 : 2;
  double begin = from;
  double last = from + kMargin * (to - from);
  int what = end_at(last);
  for (int k = 1; k <= samples; ++k) {
    const double t = k == samples ? to - kMargin * (to - from) : from + (to - from) * k / samples;
    const int at_t = end_at(t);
    while (at_t != what) {
      double high = t;
      int at_high = at_t;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (last + high);
        if (!(middle > last && middle < high)) break;
        const int at_middle = end_at(middle);
        if (at_middle == what) {
          last = middle;
        } else {
          high = middle;
          at_high = at_middle;
        }
      }
      add_sector({&far, near, begin, high, what}, layers, sums);
      begin = last = high;
      what = at_high;
    }
    last = t;
  }
  add_sector({&far, near, begin, to, what}, layers, sums);
}

// The near edge through which a ray enters what is seen, turned to face away from the source; at distance 0
// if the ray begins there.
PieceIntegral::Line PieceIntegral::near_line(const Vec2d& direction) const {
  Line found{Vec2d::Zero(), Vec2d::Zero(), 0.0};
  double least_miss = kInfinity;
  for (std::size_t e = 0; e < seen_.size; ++e) {
    const Line& line = edges_[e].line;
    if (!(line.p < 0.0) || !(direction.dot(line.normal) < 0.0)) continue;
    // Rounding may let a ray pass between two edges.
    const double t = line.place_on(direction);
    const double miss = std::max({edges_[e].first - t, t - edges_[e].last, 0.0});
    if (miss >= least_miss) continue;
    least_miss = miss;
    found = {-line.normal, -line.along, -line.p};
  }
  return found;
}

PieceIntegral::End PieceIntegral::end_of_ray(const Vec2d& u, const Edge& far) const {
  const Line near = near_line(u);
  const double enters = near.p > 0.0 ? near.distance_on(u) : 0.0;
  End end{far.line.distance_on(u), End::kEdge};
  for (std::size_t r = 0; r < rivals_.size(); ++r) {
    const GeodesicWindow& rival = *rivals_[r];
    double from = enters;
    double to = end.distance_mm;
    const Vec2d d = window_->source - rival.source;
    if (!rival.all_round) {
      clip(cross(rival.left, d), cross(rival.left, u), from, to);
      clip(cross(d, rival.right), cross(u, rival.right), from, to);
    }
    const bool begins_later = from > enters;
    // |rho u + d| + rival offset < rho + offset: the difference falls along the ray.
    const double lead = window_->offset_mm - rival.offset_mm;
    const double slope = lead - u.dot(d);
    if (!(slope > 0.0)) continue;
    const double equal = (d.squaredNorm() - lead * lead) / (2.0 * slope);
    if (!(std::max(from, equal) < to)) continue;
    end.distance_mm = std::max(from, equal);
    end.what = equal > from ? static_cast<int>(r) : begins_later ? End::kOther : End::kEntry;
  }
  return end;
}

PieceIntegral::Line PieceIntegral::bisector(const GeodesicWindow& rival) const {
  const Vec2d apart = rival.source - window_->source;
  const double distance = apart.norm();
  const Vec2d normal = apart / distance;
  return {normal, turned_left(normal), 0.5 * distance};
}

void PieceIntegral::add_sector(const Sector& sector, std::span<const TruthLayer> layers,
                               std::span<Vec4d> sums) {
  if (sector.end == End::kEntry) return;
  // Rays closer than that are one ray but for rounding, and a bound may run along it.
  const double p = sector.far->line.p;
  if (!(p * (sector.to - sector.from) > kNoAngle * (p * p + sector.from * sector.to))) return;
  const bool to_edge = sector.end == End::kEdge;
  const bool to_rival = sector.end >= 0;
  const auto rival = [&]() -> const GeodesicWindow& {
    return *rivals_[static_cast<std::size_t>(sector.end)];
  };
  const bool closed = window_->offset_mm == 0.0 && (to_edge || (to_rival && rival().offset_mm == 0.0));
  if (!closed) {
    integrate_sector(sector, layers, sums);
    return;
  }
  const Line bound = to_edge ? sector.far->line : bisector(rival());
  for (const std::size_t l : layers_) {
    sums[l] += closed_sector(sector, bound, layers[l]);
    if (sector.near.p > 0.0) sums[l] -= closed_sector(sector, sector.near, layers[l]);
  }
}

// The triangle between the source and a line, by the boundary integrals along its three sides.
Vec4d PieceIntegral::closed_sector(const Sector& sector, const Line& bound, const TruthLayer& layer) const {
  const Line& far = sector.far->line;
  const Vec2d right = far.p * far.normal + sector.from * far.along;
  const Vec2d left = far.p * far.normal + sector.to * far.along;
  const bool itself = &bound == &far;
  const double t0 = itself ? sector.from : bound.place_on(right);
  const double t1 = itself ? sector.to : bound.place_on(left);
  const EdgeIntegrals part = edge(bound.p, t0, t1, layer);
  const double rho0 = std::hypot(bound.p, t0);
  const double rho1 = std::hypot(bound.p, t1);
  const Vec2d line = part.line * bound.normal + along_ray(rho0, layer) * turned_right(right.normalized()) +
                     along_ray(rho1, layer) * turned_left(left.normalized());
  return combine(part.radial, line);
}

void PieceIntegral::integrate_sector(const Sector& sector, std::span<const TruthLayer> layers,
                                     std::span<Vec4d> sums) {
  const Line& far = sector.far->line;
  const double offset = window_->offset_mm;
  // theta = atan(sinh w): rho = p cosh w, and dtheta = dw / cosh w stays smooth however close the edge.
  const double begin = std::asinh(sector.from / far.p);
  const double end = std::asinh(sector.to / far.p);
  const double longest = std::max(std::hypot(far.p, sector.from), std::hypot(far.p, sector.to));
  // Adds the integral for the layers [first, last) of `group`, cut at `room` along the ray.
  const auto integrate = [&](std::span<const std::size_t> group, double room, double from, double to) {
    std::array<RadialIntegrals, kMaxGroup> radial = [&]<std::size_t... I>(std::index_sequence<I...>) {
      return std::array<RadialIntegrals, kMaxGroup>{
          RadialIntegrals(layers[group[std::min(I, group.size() - 1)]].std_dev_mm, offset)...};
    }
    (std::make_index_sequence<kMaxGroup>());
    std::array<Vec4d, kMaxGroup> parts;
    std::fill_n(parts.begin(), group.size(), Vec4d::Zero());
    const auto integrand = [&](double w, std::span<Vec4d> values) {
      const double c = std::cosh(w);
      const Vec2d u = far.normal / c + far.along * std::tanh(w);
      const double high =
          std::min(room, sector.end == End::kEdge ? far.p * c : end_of_ray(u, *sector.far).distance_mm);
      const double low = sector.near.p > 0.0 ? sector.near.distance_on(u) : 0.0;
      const Vec3d slope = gradient_x_ * u.x() + gradient_y_ * u.y();
      for (std::size_t g = 0; g < group.size(); ++g) {
        values[g].setZero();
        if (!(high > low)) continue;
        const RadialIntegrals::Pair outer = radial[g].at(high);
        const RadialIntegrals::Pair inner = low > 0.0 ? radial[g].at(low) : RadialIntegrals::Pair{0.0, 0.0};
        values[g].head<3>() = (i0_ * (outer.a - inner.a) + slope * (outer.b - inner.b)) / c;
        values[g][3] = (outer.a - inner.a) / c;
      }
    };
    adaptive(integrand, from, to, 0, std::span(parts).first(group.size()));
    for (std::size_t g = 0; g < group.size(); ++g) sums[group[g]] += parts[g];
  };

  std::vector<std::size_t> whole;
  for (const std::size_t l : layers_) {
    const double room = layers[l].r_max_mm - offset;
    if (room >= longest) {
      whole.push_back(l);
      continue;
    }
    // Where the cut-off's circle crosses the two edges.
    std::vector<double> breaks = {begin, end};
    const auto cut = [&](const Line& line) {
      if (room <= line.p) return;
      const double half = std::sqrt((room - line.p) * (room + line.p));
      for (const double t : {-half, half}) {
        const Vec2d x = line.p * line.normal + t * line.along;
        if (x.dot(far.normal) <= 0.0) continue;
        const double w = std::asinh(x.dot(far.along) / x.dot(far.normal));
        if (w > begin && w < end) breaks.push_back(w);
      }
    };
    cut(far);
    if (sector.near.p > 0.0) cut(sector.near);
    std::sort(breaks.begin(), breaks.end());
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
      integrate(std::span(&l, 1), room, breaks[i], breaks[i + 1]);
  }
  for (std::size_t first = 0; first < whole.size(); first += kMaxGroup) {
    const std::span<const std::size_t> group =
        std::span(whole).subspan(first, std::min(kMaxGroup, whole.size() - first));
    integrate(group, kInfinity, begin, end);
  }
}

// Gauss-Kronrod with 7 and 15 nodes, halved until the two agree. For a smooth integrand the finer of the two
// is then far better: errors go as the 1.5th power (Piessens et al. 1983, (200 d)^1.5).
template <typename Integrand>
void PieceIntegral::adaptive(const Integrand& integrand, double from, double to, int depth,
                             std::span<Vec4d> sums) const {
  using Kronrod = boost::math::quadrature::gauss_kronrod<double, 15>;
  using Gauss = boost::math::quadrature::gauss<double, 7>;
  const auto& nodes = Kronrod::abscissa();
  const auto& weights = Kronrod::weights();
  const auto& gauss_weights = Gauss::weights();
  const double middle = 0.5 * (from + to);
  const double half = 0.5 * (to - from);
  std::array<Vec4d, kMaxGroup> fine;
  std::array<Vec4d, kMaxGroup> coarse;
  std::array<Vec4d, kMaxGroup> value;
  std::array<Vec4d, kMaxGroup> mirrored;
  const std::size_t n = sums.size();
  assert(n <= kMaxGroup);
  integrand(middle, std::span(value).first(n));
  for (std::size_t g = 0; g < n; ++g) {
    fine[g] = weights[0] * value[g];
    coarse[g] = gauss_weights[0] * value[g];
  }
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    integrand(middle - half * nodes[i], std::span(value).first(n));
    integrand(middle + half * nodes[i], std::span(mirrored).first(n));
    for (std::size_t g = 0; g < n; ++g) {
      const Vec4d pair = value[g] + mirrored[g];
      fine[g] += weights[i] * pair;
      if (i % 2 == 0) coarse[g] += gauss_weights[i / 2] * pair;
    }
  }
  const double light = accuracy_.largest_irradiance;
  const Vec4d unit(light, light, light, 1.0);
  bool agree = true;
  for (std::size_t g = 0; g < n; ++g) {
    const Vec4d error = ((fine[g] - coarse[g]) * half).cwiseAbs();
    const Vec4d allowed =
        accuracy_.quadrature_error * unit + Vec4d::Constant(1e-14 * (fine[g] * half).cwiseAbs().maxCoeff());
    agree = agree && (error.array() <= allowed.array()).all();
  }
  if (agree || depth >= kMaxDepth) {
    for (std::size_t g = 0; g < n; ++g) sums[g] += fine[g] * half;
    return;
  }
  adaptive(integrand, from, middle, depth + 1, sums);
  adaptive(integrand, middle, to, depth + 1, sums);
}

}  // namespace truescatter
