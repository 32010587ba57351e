#include "truth/geodesic_brute.h"

#include <algorithm>
#include <array>
#include <boost/math/tools/toms748_solve.hpp>
#include <cassert>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "truth/line_rule.h"

namespace truescatter {
namespace {

constexpr double kTailShare = 0.01;  // of the tolerance
constexpr double kAreaShare = 0.5;   // of the tolerance: what parts may err by and be left alone
constexpr int kDeepestCut = 100;     // halvings of an edge until it is short against s
// Of the radius: what distances are good to, of whichever kind.
constexpr double kDistanceRounding = 1e-10;
constexpr std::size_t kMostParts = 4'000'000;

// Of flat triangles; counter-clockwise.
struct Corners {
  Vec2d a;
  Vec2d b;
  Vec2d c;

  double area() const { return 0.5 * cross(b - a, c - a); }
  double longest_edge() const { return std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()}); }
  Vec2d centroid() const { return (a + b + c) / 3.0; }
  double radius() const {
    const Vec2d m = centroid();
    return std::max({(a - m).norm(), (b - m).norm(), (c - m).norm()});
  }
};

// Halves the longest edge.
std::array<Corners, 2> halves(const Corners& t) {
  const double ab = (t.b - t.a).squaredNorm();
  const double bc = (t.c - t.b).squaredNorm();
  const double ca = (t.a - t.c).squaredNorm();
  if (bc > ab && bc >= ca) return halves({t.b, t.c, t.a});
  if (ca > ab) return halves({t.c, t.a, t.b});
  const Vec2d middle = 0.5 * (t.a + t.b);
  return {Corners{t.a, middle, t.c}, Corners{middle, t.b, t.c}};
}

std::array<Corners, 4> quarters(const Corners& t) {
  const auto [first, second] = halves(t);
  const auto [a, b] = halves(first);
  const auto [c, d] = halves(second);
  return {a, b, c, d};
}

// A piece of the surface with its irradiance, and 1 for the mass, as i0 + g x in its face's frame.
struct LitPiece {
  std::size_t face = 0;
  Vec2d origin;
  Vec4d i0;
  Eigen::Matrix<double, 4, 2> gradient = Eigen::Matrix<double, 4, 2>::Zero();

  LitPiece(std::size_t on_face, const FlatPiece& piece) : face(on_face), origin(piece.corners_mm[0]) {
    const Vec2d e1 = piece.corners_mm[1] - origin;
    const Vec2d e2 = piece.corners_mm[2] - origin;
    const double twice_area = cross(e1, e2);
    const Vec3d d1 = piece.irradiance[1] - piece.irradiance[0];
    const Vec3d d2 = piece.irradiance[2] - piece.irradiance[0];
    i0 << piece.irradiance[0], 1.0;
    gradient.topRows<3>().col(0) = (d1 * e2.y() - d2 * e1.y()) / twice_area;
    gradient.topRows<3>().col(1) = (d2 * e1.x() - d1 * e2.x()) / twice_area;
  }

  Vec4d light(const Vec2d& x) const { return i0 + gradient * (x - origin); }
};

struct Part {
  Corners corners;
  std::size_t piece = 0;
  Vec4d value = Vec4d::Zero();
  double error = 0.0;  // in units of the light

  bool operator<(const Part& other) const { return error < other.error; }
};

// One Gaussian seen from one point.
class LayerIntegral {
 public:
  LayerIntegral(const DistanceTo& distance, double known_mm, const TruthLayer& layer, double tolerance,
                const Vec4d& unit)
      : distance_(distance),
        known_mm_(known_mm),
        layer_(layer),
        tail_mm_(layer.std_dev_mm * std::sqrt(-2.0 * std::log(kTailShare * tolerance))),
        tolerance_(tolerance),
        unit_(unit) {}

  // The pieces of one component, all over the surface.
  Vec4d value(const GeodesicSurface& surface, int component) {
    std::vector<Corners> whole;
    for (std::size_t face = 0; face < surface.mesh().face_count(); ++face) {
      for (const FlatPiece& piece : surface.pieces(face)) {
        const Corners corners{piece.corners_mm[0], piece.corners_mm[1], piece.corners_mm[2]};
        if (piece.component != component || !(corners.area() > 0.0) || beyond(face, corners)) continue;
        pieces_.emplace_back(face, piece);
        whole.push_back(corners);
        // No more of a plane than this is integrated: parts of at most s that come within reach.
        const double widest = reach_mm() + 2.0 * layer_.std_dev_mm;
        area_ += std::min(corners.area(), kPi * widest * widest);
      }
    }
    for (std::size_t i = 0; i < whole.size(); ++i) cut_short(whole[i], i, 0);
    refine();
    Vec4d sum = done_;
    for (const Part& part : heap_) sum += part.value;
    return sum;
  }

 private:
  double reach_mm() const { return std::min(tail_mm_, layer_.r_max_mm); }

  // The distance, or what is known of it: that it is no less.
  double distance(std::size_t face, const Vec2d& x) const { return std::min(distance_(face, x), known_mm_); }

  // Certainly out of reach: along a face the distance changes by no more than the way.
  bool beyond(std::size_t face, const Corners& t) const {
    return distance(face, t.centroid()) - t.radius() > reach_mm();
  }

  void cut_short(const Corners& t, std::size_t piece, int depth) {
    if (beyond(pieces_[piece].face, t)) return;
    if (t.longest_edge() <= std::min(layer_.std_dev_mm, 0.25 * layer_.r_max_mm)) {
      add(t, piece);
      return;
    }
    if (depth >= kDeepestCut)
      throw_run_error("a triangle is too large against the Gaussian for plain quadrature");
    for (const Corners& part : quarters(t)) cut_short(part, piece, depth + 1);
  }

  void add(const Corners& t, std::size_t piece) {
    Part part{t, piece};
    integrate(part);
    error_ += part.error;
    if (part.error == 0.0) {
      done_ += part.value;
      return;
    }
    heap_.push_back(part);
    std::push_heap(heap_.begin(), heap_.end());
  }

  // Cuts the worst parts until the errors sum to the tolerance.
  void refine() {
    while (error_ > tolerance_ && !heap_.empty()) {
      if (heap_.size() > kMostParts) {
        throw_run_error("plain quadrature does not reach the tolerance: {} parts still err by {}", kMostParts,
                        error_);
      }
      std::pop_heap(heap_.begin(), heap_.end());
      const Part worst = heap_.back();
      heap_.pop_back();
      error_ -= worst.error;
      for (const Corners& part : quarters(worst.corners)) {
        if (!beyond(pieces_[worst.piece].face, part)) add(part, worst.piece);
      }
    }
  }

  void integrate(Part& part) const {
    const Samples samples = sampled(part);
    const double allowed = kAreaShare * tolerance_ * part.corners.area() / area_;
    Vec4d coarse = integral(part, brute_rules()[0]);
    for (std::size_t k = 1; k < brute_rules().size(); ++k) {
      part.value = integral(part, brute_rules()[k]);
      part.error = in_units(part.value - coarse);
      if (part.error <= allowed) break;
      coarse = part.value;
    }
    part.error = std::max(part.error, unseen(part, samples));
  }

  double in_units(const Vec4d& light) const { return (light.cwiseAbs().array() / unit_.array()).maxCoeff(); }

  // The corners, the middles of the sides, and the centroid, with the distances there.
  struct Samples {
    std::array<Vec2d, 7> x;
    std::array<double, 7> d{};
  };
  Samples sampled(const Part& part) const {
    const Corners& t = part.corners;
    Samples samples{{t.a, t.b, t.c, 0.5 * (t.a + t.b), 0.5 * (t.b + t.c), 0.5 * (t.c + t.a), t.centroid()}};
    for (std::size_t i = 0; i < samples.x.size(); ++i)
      samples.d[i] = distance(pieces_[part.piece].face, samples.x[i]);
    return samples;
  }

  // Where paths come straight from one (unfolded) source s, d = o + |x - s|. Less the centroid's values that
  // reads e^2 - |q|^2 = -2 rho e - 2 s.q, with s from the centroid and rho = |s|: linear in (rho, s), six
  // equations for three unknowns. The source, if there is one.
  std::optional<Vec2d> one_source(const Samples& samples) const {
    Eigen::Matrix<double, 6, 3> left;
    Eigen::Matrix<double, 6, 1> right;
    double size_mm = 0.0;
    for (Eigen::Index i = 0; i < 6; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Vec2d q = samples.x[k] - samples.x[6];
      const double e = samples.d[k] - samples.d[6];
      left.row(i) << -2.0 * e, -2.0 * q.x(), -2.0 * q.y();
      right[i] = e * e - q.squaredNorm();
      size_mm = std::max(size_mm, q.norm());
    }
    const Vec3d found = left.colPivHouseholderQr().solve(right);
    const double rounding_mm = kDistanceRounding * known_mm_;
    const double allowed = 2.0 * (std::abs(found[0]) + size_mm) * rounding_mm;
    if ((left * found - right).cwiseAbs().maxCoeff() > allowed) return std::nullopt;
    return Vec2d(found[1], found[2]);
  }

  // What may be wrong with a part although its rules agree, as their nodes lie inside.
  // - A kink that parts a corner off, or passes a side's middle: then the samples have no one source, and a
  // rule
  //   that has its nodes at them (of degree 3: weights 1/20, 2/15, 9/20) differs by more than what was
  //   missed.
  // - A kink that meets the circle: there the whole part counts.
  // - The circle of the cut-off bulging in between two samples on a side of length l. Its arc of radius rho
  // is
  //   over a chord of l/2 at most, so holds l^3 / (96 rho), and leaves a sample within l^2 / (8 rho) of it.
  double unseen(const Part& part, const Samples& samples) const {
    const std::optional<Vec2d> source = one_source(samples);
    const bool is_cut = near_cut(part);
    if (source && !is_cut) return 0.0;
    const auto inside = static_cast<std::size_t>(
        std::count_if(samples.d.begin(), samples.d.end(), [&](double d) { return d < layer_.r_max_mm; }));
    const bool mixed = inside > 0 && inside < samples.d.size();
    if (!source) {
      if (!is_cut || inside == samples.d.size()) return in_units(part.value - closed_rule(part, samples));
      if (!mixed) return 0.0;
      double largest = 0.0;
      for (const Vec2d& x : samples.x) largest = std::max(largest, in_units(integrand(part.piece, x)));
      return part.corners.area() * largest;
    }
    double nearest = layer_.r_max_mm;
    for (const double d : samples.d) nearest = std::min(nearest, std::abs(d - layer_.r_max_mm));
    const double l = part.corners.longest_edge();
    const double rho = std::max(source->norm(), 1e-3 * l);
    if (mixed || nearest > l * l / (8.0 * rho)) return 0.0;
    return l * l * l / (96.0 * rho) * in_units(integrand(part.piece, samples.x[6]));
  }

  Vec4d closed_rule(const Part& part, const Samples& samples) const {
    Vec4d sum = Vec4d::Zero();
    for (std::size_t i = 0; i < samples.x.size(); ++i)
      sum += (i < 3 ? 1.0 / 20.0 : (i < 6 ? 2.0 / 15.0 : 9.0 / 20.0)) * integrand(part.piece, samples.x[i]);
    return part.corners.area() * sum;
  }

  // Neither certainly inside the cut-off nor certainly outside.
  bool near_cut(const Part& part) const {
    const double at_centroid = distance(pieces_[part.piece].face, part.corners.centroid());
    return std::abs(at_centroid - layer_.r_max_mm) <= part.corners.radius();
  }

  // Along lines from one corner to points of the opposite side: x = apex + u (side(v) - apex).
  Vec4d integral(const Part& part, const LineRule& rule) const {
    const std::size_t face = pieces_[part.piece].face;
    const bool is_cut = near_cut(part);
    const Corners t = is_cut ? turned_to_the_cut(face, part.corners) : part.corners;
    Vec4d sum = Vec4d::Zero();
    for (std::size_t j = 0; j < rule.nodes.size(); ++j) {
      const Vec2d along = t.b + rule.nodes[j] * (t.c - t.b) - t.a;
      const std::pair<double, double> inside = is_cut ? inside_cut(face, t.a, along) : std::pair(0.0, 1.0);
      const double length = inside.second - inside.first;
      if (!(length > 0.0)) continue;
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double u = inside.first + rule.nodes[i] * length;
        sum += rule.weights[j] * rule.weights[i] * length * u * integrand(part.piece, t.a + u * along);
      }
    }
    return 2.0 * t.area() * sum;
  }

  Vec4d integrand(std::size_t piece, const Vec2d& x) const {
    const double in_std_devs = distance(pieces_[piece].face, x) / layer_.std_dev_mm;
    const double variance = layer_.std_dev_mm * layer_.std_dev_mm;
    return std::exp(-0.5 * in_std_devs * in_std_devs) / (2.0 * kPi * variance) * pieces_[piece].light(x);
  }

  double over_cut(std::size_t face, const Vec2d& x) const { return distance(face, x) - layer_.r_max_mm; }

  // The corner that the circle parts from the others comes first, so that every line crosses the circle;
  // where it parts none, the one farthest from it.
  Corners turned_to_the_cut(std::size_t face, const Corners& t) const {
    const std::array<double, 3> over = {over_cut(face, t.a), over_cut(face, t.b), over_cut(face, t.c)};
    std::size_t apex = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const bool side = over[i] < 0.0;
      const bool next = over[(i + 1) % 3] < 0.0;
      const bool last = over[(i + 2) % 3] < 0.0;
      if (side != next && side != last) {
        apex = i;
        break;
      }
      if (std::abs(over[i]) > std::abs(over[apex])) apex = i;
    }
    if (apex == 0) return t;
    return apex == 1 ? Corners{t.b, t.c, t.a} : Corners{t.c, t.a, t.b};
  }

  // The part of apex + u along, u from 0 to 1, that lies within the cut-off.
  std::pair<double, double> inside_cut(std::size_t face, const Vec2d& apex, const Vec2d& along) const {
    const auto over = [&](double u) { return over_cut(face, apex + u * along); };
    const double at_apex = over(0.0);
    const double at_side = over(1.0);
    if (at_apex < 0.0 && at_side < 0.0) return {0.0, 1.0};
    if (at_apex >= 0.0 && at_side >= 0.0) return {0.0, 0.0};
    constexpr int kBits = 46;
    boost::uintmax_t iterations = 100;
    const auto [low, high] = boost::math::tools::toms748_solve(
        over, 0.0, 1.0, at_apex, at_side, boost::math::tools::eps_tolerance<double>(kBits), iterations);
    const double crossing = 0.5 * (low + high);
    return at_apex < 0.0 ? std::pair(0.0, crossing) : std::pair(crossing, 1.0);
  }

  const DistanceTo& distance_;
  double known_mm_;
  TruthLayer layer_;
  double tail_mm_;
  double tolerance_;
  Vec4d unit_;
  std::vector<LitPiece> pieces_;
  double area_ = 0.0;
  std::vector<Part> heap_;
  double error_ = 0.0;  // of all parts
  Vec4d done_ = Vec4d::Zero();
};

}  // namespace

DistanceFrom distances_by_windows(const IntrinsicMesh& mesh) {
  return [&mesh](const GeodesicPoint& source, double radius_mm) -> DistanceTo {
    const auto field = std::make_shared<GeodesicField>(mesh);
    field->propagate(source, radius_mm);
    return [field](std::size_t face, const Vec2d& x) { return field->distance(face, x); };
  };
}

DistanceFrom distances_by_cgal(const IntrinsicMesh& mesh, const CgalGeodesics& geodesics) {
  return [&mesh, &geodesics](const GeodesicPoint& source, double) -> DistanceTo {
    const auto from =
        std::make_shared<CgalGeodesics::From>(geodesics, MeshPoint{source.face, source.barycentric});
    return [&mesh, from](std::size_t face, const Vec2d& x) {
      const Vec2d e1 = mesh.corner(face, 1) - mesh.corner(face, 0);
      const Vec2d e2 = mesh.corner(face, 2) - mesh.corner(face, 0);
      const Vec2d d = x - mesh.corner(face, 0);
      const double b1 = cross(d, e2) / cross(e1, e2);
      const double b2 = cross(e1, d) / cross(e1, e2);
      return from->distance_mm({face, {1.0 - b1 - b2, b1, b2}});
    };
  };
}

GeodesicBruteEngine::GeodesicBruteEngine(const GeodesicSurface& surface, DistanceFrom distances,
                                         double tolerance)
    : surface_(surface),
      distances_(std::move(distances)),
      tolerance_(tolerance),
      unit_(Vec4d::Constant(surface.largest_irradiance())) {
  assert(tolerance > 0.0);
  unit_[3] = 1.0;
}

std::vector<Vec4d> GeodesicBruteEngine::convolve(const GeodesicTarget& target,
                                                 std::span<const TruthLayer> layers) const {
  double reach_mm = 0.0;
  for (const TruthLayer& layer : layers) {
    const double tail_mm = layer.std_dev_mm * std::sqrt(-2.0 * std::log(kTailShare * tolerance_));
    reach_mm = std::max(reach_mm, std::min(tail_mm, layer.r_max_mm));
  }
  // Twice as far, so that large parts out of reach are seen to be so from their middle.
  const double known_mm = 2.0 * reach_mm;
  const DistanceTo distance = distances_(target.point, known_mm);
  std::vector<Vec4d> sums;
  for (const TruthLayer& layer : layers) {
    sums.push_back(
        LayerIntegral(distance, known_mm, layer, tolerance_, unit_).value(surface_, target.component));
  }
  return sums;
}

}  // namespace truescatter
