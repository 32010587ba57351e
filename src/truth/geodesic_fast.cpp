#include "truth/geodesic_fast.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "truth/face_integral.h"
#include "truth/quadrature.h"

namespace truescatter {
namespace {

constexpr double kTailShare = 0.1;        // of the tolerance
constexpr double kQuadratureShare = 0.4;  // of the tolerance
constexpr double kKinkShare = 0.3;        // of the tolerance
// Where a kink lies among a face's nodes is as good as random, so the faces' errors add as independent ones
// do.
constexpr double kDeviations = 3.0;
constexpr double kFormulaShare = 1e-3;  // of the tolerance, for each stretch of an edge
constexpr std::size_t kTaskTargets = 256;

struct PieceBounds {
  Vec2d centroid_mm;
  double radius_mm;
};

PieceBounds bounds_of(const FlatPiece& piece) {
  const Vec2d centroid = (piece.corners_mm[0] + piece.corners_mm[1] + piece.corners_mm[2]) / 3.0;
  double radius = 0.0;
  for (const Vec2d& corner : piece.corners_mm) radius = std::max(radius, (corner - centroid).norm());
  return {centroid, radius};
}

// What does not depend on the target.
struct Plan {
  std::vector<TruthLayer> layers;                      // widest first
  std::vector<std::size_t> order;                      // of the caller's layers
  std::vector<double> reach_mm;                        // by layer
  std::vector<std::vector<std::vector<Split>>> split;  // by face, its piece, layer
  std::vector<std::vector<PieceBounds>> bounds;        // by face, its piece
};

Plan make_plan(const GeodesicSurface& surface, double tolerance, std::span<const TruthLayer> layers) {
  Plan plan;
  plan.order.resize(layers.size());
  std::iota(plan.order.begin(), plan.order.end(), std::size_t{0});
  std::stable_sort(plan.order.begin(), plan.order.end(),
                   [&](std::size_t a, std::size_t b) { return layers[a].std_dev_mm > layers[b].std_dev_mm; });
  const double tail = std::sqrt(-2.0 * std::log(kTailShare * tolerance));
  for (const std::size_t l : plan.order) {
    plan.layers.push_back(layers[l]);
    plan.reach_mm.push_back(std::min(tail * layers[l].std_dev_mm, layers[l].r_max_mm));
  }
  const RuleChooser chooser(kQuadratureShare * tolerance);
  const std::size_t faces = surface.mesh().face_count();
  plan.split.resize(faces);
  plan.bounds.resize(faces);
  for (std::size_t f = 0; f < faces; ++f) {
    for (const FlatPiece& piece : surface.pieces(f)) {
      plan.bounds[f].push_back(bounds_of(piece));
      std::vector<Split> splits;
      for (const TruthLayer& layer : plan.layers)
        splits.push_back(chooser.choose(plan.bounds[f].back().radius_mm / layer.std_dev_mm));
      plan.split[f].push_back(std::move(splits));
    }
  }
  return plan;
}

// The shortest path to a point among a face's windows, and how strong a kink may lie within `radius_mm`.
struct Shortest {
  double distance_mm = std::numeric_limits<double>::infinity();
  double kink = 0.0;  // |difference of the two gradients|
};

class TargetConvolution {
 public:
  TargetConvolution(const GeodesicSurface& surface, double tolerance, const Plan& plan)
      : surface_(surface), tolerance_(tolerance), plan_(plan), field_(surface.mesh()) {}

  // In the order of the plan's layers.
  std::vector<Vec4d> at(const GeodesicTarget& target) {
    const double reach_mm = *std::max_element(plan_.reach_mm.begin(), plan_.reach_mm.end());
    field_.propagate(target.point, reach_mm);
    std::vector<Vec4d> total(plan_.layers.size(), Vec4d::Zero());
    kinked_.clear();
    double kink_variance = 0.0;
    for (const std::int32_t face : field_.faces()) {
      FaceSums sums = add_face(static_cast<std::size_t>(face), target.component);
      for (std::size_t l = 0; l < total.size(); ++l) total[l] += sums.layer[l];
      if (sums.kink_error > 0.0) {
        kink_variance += sums.kink_error * sums.kink_error;
        kinked_.push_back(std::move(sums));
      }
    }
    const double budget = kKinkShare / kDeviations * tolerance_;
    if (kink_variance > budget * budget) mend_kinks(target.component, kink_variance, budget * budget, total);
    return total;
  }

 private:
  struct FaceSums {
    std::size_t face = 0;
    double kink_error = 0.0;
    std::vector<Vec4d> layer;
  };

  FaceSums add_face(std::size_t face, int component) {
    FaceSums sums{face, 0.0, std::vector<Vec4d>(plan_.layers.size(), Vec4d::Zero())};
    windows_.clear();
    for (std::int32_t i = field_.first_window(face); i >= 0; i = field_.window(i).next)
      windows_.push_back(field_.window(i));
    const std::span<const FlatPiece> pieces = surface_.pieces(face);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (pieces[i].component == component) add_piece(face, i, pieces[i], sums);
    }
    return sums;
  }

  void add_piece(std::size_t face, std::size_t index, const FlatPiece& piece, FaceSums& sums) {
    const PieceBounds& bounds = plan_.bounds[face][index];
    double nearest = std::numeric_limits<double>::infinity();
    double farthest = 0.0;
    for (const GeodesicWindow& window : windows_) {
      const double length = window.distance(bounds.centroid_mm);
      nearest = std::min(nearest, length - bounds.radius_mm);
      farthest = std::max(farthest, length + bounds.radius_mm);
    }
    by_nodes_.clear();
    const Split* finest = nullptr;
    for (std::size_t l = 0; l < plan_.layers.size(); ++l) {
      if (nearest > plan_.reach_mm[l]) continue;
      const Split& split = plan_.split[face][index][l];
      const bool cut = farthest > plan_.layers[l].r_max_mm;
      if (split.rule == nullptr || cut) {
        FaceIntegral formula(surface_.mesh(), field_, face, kFormulaShare * tolerance_);
        formula.add(std::span(&piece, 1), piece.component, std::span(&plan_.layers[l], 1),
                    std::span(&sums.layer[l], 1));
      } else {
        by_nodes_.push_back(l);
        if (finest == nullptr || split.node_count() > finest->node_count()) finest = &split;
      }
    }
    if (finest != nullptr) add_nodes(piece, bounds.radius_mm / finest->parts, *finest, sums);
  }

  void add_nodes(const FlatPiece& piece, double part_radius_mm, const Split& split, FaceSums& sums) {
    const int n = split.parts;
    const double part_area = piece.area_mm2() / (n * n);
    const auto visit_part = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
      for (const TriangleNode& node : split.rule->nodes) {
        const Vec3d at = node.barycentric[0] * a + node.barycentric[1] * b + node.barycentric[2] * c;
        add_node(piece, at, node.weight * part_area, part_radius_mm, split.rule->kink_error, sums);
      }
    };
    const auto corner = [&](int i, int j) { return Vec3d(Vec3d(n - i - j, i, j) / n); };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        visit_part(corner(i, j), corner(i + 1, j), corner(i, j + 1));
        if (i + j + 1 < n) visit_part(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
      }
    }
  }

  void add_node(const FlatPiece& piece, const Vec3d& at, double area, double part_radius_mm,
                double rule_error, FaceSums& sums) {
    const Vec2d x = at[0] * piece.corners_mm[0] + at[1] * piece.corners_mm[1] + at[2] * piece.corners_mm[2];
    const Shortest shortest = shortest_to(x, part_radius_mm);
    const double d = shortest.distance_mm;
    const Vec3d irradiance =
        at[0] * piece.irradiance[0] + at[1] * piece.irradiance[1] + at[2] * piece.irradiance[2];
    const Vec4d weight(area * irradiance.x(), area * irradiance.y(), area * irradiance.z(), area);
    double worst = 0.0;
    for (const std::size_t l : by_nodes_) {
      const double s = plan_.layers[l].std_dev_mm;
      const double q = d / s;
      if (q > 8.6) continue;
      const double g = std::exp(-0.5 * q * q) / (2.0 * kPi * s * s);
      sums.layer[l] += g * weight;
      worst = std::max(worst, g * q / s);
    }
    // A jump J of the gradient is J/2 times the distance from the kink, on top of something smooth.
    sums.kink_error += 0.5 * shortest.kink * worst * area * part_radius_mm * rule_error;
  }

  Shortest shortest_to(const Vec2d& x, double radius_mm) const {
    Shortest shortest;
    const GeodesicWindow* owner = nullptr;
    const double slack = 1e-11 * field_radius();
    for (const GeodesicWindow& window : windows_) {
      if (window.beyond_rays(x) > slack) continue;
      const double length = window.distance(x);
      if (length < shortest.distance_mm) {
        shortest.distance_mm = length;
        owner = &window;
      }
    }
    // Rounding may leave a point between two windows; the field's own query settles it.
    if (owner == nullptr) return shortest;
    const Vec2d along = (x - owner->source).normalized();
    for (const GeodesicWindow& window : windows_) {
      if (&window == owner || window.beyond_rays(x) > slack) continue;
      const double jump = ((x - window.source).normalized() - along).norm();
      // The two lengths agree no nearer than this.
      if (window.distance(x) - shortest.distance_mm < jump * radius_mm && jump > 1e-9)
        shortest.kink = std::max(shortest.kink, jump);
    }
    return shortest;
  }

  double field_radius() const { return plan_.reach_mm.front(); }

  // The faces whose kinks matter most take the exact formula, until what is left is within the budget.
  void mend_kinks(int component, double variance, double budget, std::vector<Vec4d>& total) {
    std::sort(kinked_.begin(), kinked_.end(), [](const FaceSums& a, const FaceSums& b) {
      return a.kink_error != b.kink_error ? a.kink_error > b.kink_error : a.face < b.face;
    });
    for (const FaceSums& sums : kinked_) {
      if (variance <= budget) break;
      variance -= sums.kink_error * sums.kink_error;
      std::vector<Vec4d> exact(plan_.layers.size(), Vec4d::Zero());
      FaceIntegral formula(surface_.mesh(), field_, sums.face, kFormulaShare * tolerance_);
      formula.add(surface_.pieces(sums.face), component, plan_.layers, exact);
      for (std::size_t l = 0; l < total.size(); ++l) total[l] += exact[l] - sums.layer[l];
    }
  }

  const GeodesicSurface& surface_;
  double tolerance_;
  const Plan& plan_;
  GeodesicField field_;
  std::vector<GeodesicWindow> windows_;  // of the current face
  std::vector<std::size_t> by_nodes_;    // layers of the current piece
  std::vector<FaceSums> kinked_;
};

}  // namespace

GeodesicFastEngine::GeodesicFastEngine(const GeodesicSurface& surface, double tolerance)
    : surface_(surface), tolerance_(tolerance) {
  assert(tolerance > 0.0);
}

double GeodesicFastEngine::tail_bound() const { return 2.0 * kTailShare * tolerance_; }

TruthValues GeodesicFastEngine::convolve(std::span<const GeodesicTarget> targets,
                                         std::span<const TruthLayer> layers,
                                         const std::function<void(std::size_t)>& advance) const {
  TruthValues values(layers.size(), std::vector<Vec4d>(targets.size(), Vec4d::Zero()));
  if (layers.empty()) return values;
  const Plan plan = make_plan(surface_, tolerance_, layers);
  parallel_for((targets.size() + kTaskTargets - 1) / kTaskTargets, [&](std::size_t task) {
    TargetConvolution convolution(surface_, tolerance_, plan);
    const std::size_t end = std::min(targets.size(), (task + 1) * kTaskTargets);
    for (std::size_t i = task * kTaskTargets; i < end; ++i) {
      const std::vector<Vec4d> sums = convolution.at(targets[i]);
      for (std::size_t l = 0; l < sums.size(); ++l) values[plan.order[l]][i] = sums[l];
      if (advance) advance(layers.size());
    }
  });
  return values;
}

}  // namespace truescatter
