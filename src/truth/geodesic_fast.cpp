#include "truth/geodesic_fast.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "truth/piece_integral.h"
#include "truth/piece_nodes.h"

namespace truescatter {
namespace {

constexpr double kTailShare = 0.1;        // of the tolerance
constexpr double kQuadratureShare = 0.3;  // of the tolerance
constexpr double kKinkShare = 0.5;        // of the tolerance
// Kinks' errors have mean 0 and are independent, for where a kink lies among a part's nodes is as good as
// random: the sum of many is normal, and 4 deviations hold but for 6e-5 of the points. 4 deviations of a
// single one are more than its bound (TriangleRule::kink_rms).
constexpr double kDeviations = 4.0;
// A piece whose kinks matter is divided by that much more; if that is not enough it takes the formula.
constexpr int kFiner = 3;
constexpr std::size_t kMaxFinerNodes = 800;
constexpr double kFormulaShare = 1e-3;  // of the tolerance, for each sector
// Down to this tolerance nodes are summed in single precision, and closed forms need be good to 1e-7 only.
constexpr double kSinglePrecision = 1e-5;
// A piece with one source takes the closed form rather than more nodes than that.
constexpr std::size_t kMaxNodes = 96;
constexpr std::size_t kTaskTargets = 512;

// What does not depend on the target.
template <typename Scalar>
struct Plan {
  std::vector<TruthLayer> layers;  // widest first
  std::vector<std::size_t> order;  // of the caller's layers
  std::vector<double> reach_mm;    // by layer
  std::vector<Vec2d> centroid_mm;  // by piece
  std::vector<double> radius_mm;   // by piece
  std::vector<std::int8_t> split;  // by piece, layer: index into `splits`, or -1: no rule will do
  std::vector<SplitNodes<Scalar>> splits;
  std::vector<std::int8_t> finer;  // of each split: index into `splits`, or -1: too many nodes
};

template <typename Scalar>
Plan<Scalar> make_plan(const GeodesicSurface& surface, double tolerance, std::span<const TruthLayer> layers) {
  Plan<Scalar> plan;
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
  std::map<std::pair<const TriangleRule*, int>, std::int8_t> known;
  for (const FlatPiece& piece : surface.pieces()) {
    plan.centroid_mm.push_back(piece.centroid_mm());
    plan.radius_mm.push_back(piece.radius_mm());
    for (const TruthLayer& layer : plan.layers) {
      const Split split = chooser.choose(plan.radius_mm.back() / layer.std_dev_mm);
      if (split.rule == nullptr) {
        plan.split.push_back(-1);
        continue;
      }
      const auto [entry, is_new] =
          known.try_emplace({split.rule, split.parts}, static_cast<std::int8_t>(plan.splits.size()));
      if (is_new) plan.splits.emplace_back(split);
      plan.split.push_back(entry->second);
    }
  }
  const std::size_t count = plan.splits.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Split finer = chooser.finer(plan.splits[i].split, kFiner);
    plan.finer.push_back(finer.node_count() > kMaxFinerNodes ? std::int8_t{-1}
                                                             : static_cast<std::int8_t>(plan.splits.size()));
    if (plan.finer.back() >= 0) plan.splits.emplace_back(finer);
  }
  return plan;
}

template <typename Scalar>
class TargetConvolution {
 public:
  TargetConvolution(const GeodesicSurface& surface, double tolerance, const Plan<Scalar>& plan)
      : surface_(surface),
        tolerance_(tolerance),
        plan_(plan),
        field_(surface.mesh()),
        formula_({tolerance < kSinglePrecision, kFormulaShare * tolerance,
                  std::sqrt(-2.0 * std::log(kTailShare * tolerance)), surface.largest_irradiance()}),
        reach_mm_(*std::max_element(plan.reach_mm.begin(), plan.reach_mm.end())),
        // A place is known to some roundings of the radius, so a ray may miss it by that.
        slack_mm_(reach_mm_ * 16.0 * static_cast<double>(std::numeric_limits<Scalar>::epsilon())) {}

  // In the order of the plan's layers.
  std::vector<Vec4d> at(const GeodesicTarget& target) {
    field_.propagate(target.point, reach_mm_);
    total_.assign(plan_.layers.size(), Vec4d::Zero());
    kinked_.clear();
    kinked_windows_.clear();
    kink_variance_.assign(plan_.layers.size(), 0.0);
    for (const std::int32_t face : field_.faces()) {
      const auto f = static_cast<std::size_t>(face);
      windows_.clear();
      for (std::int32_t i = field_.first_window(f); i >= 0; i = field_.window(i).next)
        windows_.push_back(&field_.window(i));
      const std::size_t first = surface_.first_piece(f);
      const std::size_t count = surface_.pieces(f).size();
      for (std::size_t i = first; i < first + count; ++i) {
        if (surface_.pieces()[i].component == target.component) add_piece(i);
      }
    }
    mend_kinks();
    return total_;
  }

 private:
  // A piece and layer whose quadrature meets kinks, with what it added.
  struct Kinked {
    std::size_t piece;
    std::size_t layer;
    double variance;
    Vec4d sum;
    std::size_t first_window;  // into kinked_windows_
    std::size_t window_count;
  };

  // A window's path to the centroid of the current piece.
  struct Arrival {
    const GeodesicWindow* window;
    double length_mm;
    double rho_mm;  // of this, beyond the source
    Vec2d direction;
  };

  // Adds a piece to the total, and to kink_variance_ what its kinks may have.
  void add_piece(std::size_t index) {
    const FlatPiece& piece = surface_.pieces()[index];
    const Vec2d& centroid = plan_.centroid_mm[index];
    const double radius = plan_.radius_mm[index];
    if (!choose_windows(centroid, radius)) return;
    double nearest = std::numeric_limits<double>::infinity();
    double farthest = 0.0;
    for (const GeodesicWindow* window : chosen_) {
      nearest = std::min(nearest, window->distance(centroid) - radius);
      farthest = std::max(farthest, window->distance(centroid) + radius);
    }
    const bool simple = chosen_.size() == 1 && chosen_.front()->offset_mm == 0.0;
    by_formula_.clear();
    const SplitNodes<Scalar>* prepared = nullptr;
    bool is_kinked = false;
    const std::size_t first_window = kinked_windows_.size();
    for (std::size_t l = 0; l < plan_.layers.size(); ++l) {
      if (nearest > plan_.reach_mm[l]) continue;
      const std::int8_t chosen = plan_.split[index * plan_.layers.size() + l];
      const SplitNodes<Scalar>* nodes =
          chosen < 0 ? nullptr : &plan_.splits[static_cast<std::size_t>(chosen)];
      const bool cut = farthest > plan_.layers[l].r_max_mm;
      if (nodes == nullptr || cut || (simple && nodes->split.node_count() > kMaxNodes)) {
        by_formula_.push_back(l);
        continue;
      }
      if (nodes != prepared) {
        nodes_.prepare(piece, *nodes, chosen_, slack_mm_);
        prepared = nodes;
      }
      const Vec4d sum = nodes_.sum(plan_.layers[l]);
      total_[l] += sum;
      if (simple) continue;
      const double variance = nodes_.kink_variance(plan_.layers[l]);
      if (variance <= 0.0) continue;
      kink_variance_[l] += variance;
      kinked_.push_back({index, l, variance, sum, first_window, chosen_.size()});
      is_kinked = true;
    }
    if (!by_formula_.empty()) add_formula(piece, chosen_, by_formula_);
    if (is_kinked) kinked_windows_.insert(kinked_windows_.end(), chosen_.begin(), chosen_.end());
  }

  // Those of the face's windows that may hold a shortest path to a point of a piece: within its circle two
  // lengths' difference changes by at most the radius times the largest difference of their directions, and a
  // direction turns by at most radius / (rho - radius), rho being the way from the source to the centroid.
  bool choose_windows(const Vec2d& centroid, double radius) {
    chosen_.clear();
    arrivals_.clear();
    std::optional<std::size_t> covering;  // the shortest of those that cover the whole circle
    for (const GeodesicWindow* window : windows_) {
      const double beyond = window->beyond_rays(centroid);
      if (beyond > radius) continue;
      const Vec2d along = centroid - window->source;
      const double rho = along.norm();
      const double length = window->offset_mm + rho;
      if (length - radius > reach_mm_) continue;
      const bool covers = beyond <= -radius || window->all_round;
      if (covers && (!covering || length < arrivals_[*covering].length_mm)) covering = arrivals_.size();
      arrivals_.push_back({window, length, rho, rho > 0.0 ? Vec2d(along / rho) : along});
    }
    const Arrival* best = covering ? &arrivals_[*covering] : nullptr;
    for (const Arrival& arrival : arrivals_) {
      if (best != nullptr && &arrival != best) {
        const double room = std::min(arrival.rho_mm, best->rho_mm) - radius;
        const double turned = room > radius ? 2.0 * radius / room : 2.0;
        const double apart = std::min(2.0, (arrival.direction - best->direction).norm() + turned);
        if (arrival.length_mm - best->length_mm > apart * radius) continue;
      }
      chosen_.push_back(arrival.window);
    }
    return !chosen_.empty();
  }

  void add_formula(const FlatPiece& piece, std::span<const GeodesicWindow* const> windows,
                   std::span<const std::size_t> layers) {
    formula_layers_.clear();
    for (const std::size_t l : layers) formula_layers_.push_back(plan_.layers[l]);
    formula_sums_.assign(layers.size(), Vec4d::Zero());
    formula_.add(piece, windows, formula_layers_, formula_sums_);
    for (std::size_t i = 0; i < layers.size(); ++i) total_[layers[i]] += formula_sums_[i];
  }

  // The pieces whose kinks matter most are done again, until what is left is within each layer's budget.
  void mend_kinks() {
    const double budget = std::pow(kKinkShare / kDeviations * tolerance_, 2);
    std::sort(kinked_.begin(), kinked_.end(), [](const Kinked& a, const Kinked& b) {
      return a.variance != b.variance ? a.variance > b.variance
             : a.piece != b.piece     ? a.piece < b.piece
                                      : a.layer < b.layer;
    });
    for (Kinked& kinked : kinked_) {
      if (kink_variance_[kinked.layer] > budget) divide(kinked);
    }
    for (const Kinked& kinked : kinked_) {
      if (kink_variance_[kinked.layer] <= budget) continue;
      kink_variance_[kinked.layer] -= kinked.variance;
      total_[kinked.layer] -= kinked.sum;
      add_formula(surface_.pieces()[kinked.piece], windows_of(kinked), std::span(&kinked.layer, 1));
    }
  }

  std::span<const GeodesicWindow* const> windows_of(const Kinked& kinked) const {
    return std::span(kinked_windows_).subspan(kinked.first_window, kinked.window_count);
  }

  void divide(Kinked& kinked) {
    const std::int8_t split = plan_.split[kinked.piece * plan_.layers.size() + kinked.layer];
    const std::int8_t finer = plan_.finer[static_cast<std::size_t>(split)];
    if (finer < 0) return;
    nodes_.prepare(surface_.pieces()[kinked.piece], plan_.splits[static_cast<std::size_t>(finer)],
                   windows_of(kinked), slack_mm_);
    const TruthLayer& layer = plan_.layers[kinked.layer];
    const Vec4d sum = nodes_.sum(layer);
    const double variance = nodes_.kink_variance(layer);
    total_[kinked.layer] += sum - kinked.sum;
    kink_variance_[kinked.layer] += variance - kinked.variance;
    kinked.sum = sum;
    kinked.variance = variance;
  }

  const GeodesicSurface& surface_;
  double tolerance_;
  const Plan<Scalar>& plan_;
  GeodesicField field_;
  PieceIntegral formula_;
  PieceNodes<Scalar> nodes_;
  double reach_mm_;
  double slack_mm_;
  std::vector<Vec4d> total_;
  std::vector<const GeodesicWindow*> windows_;  // of the current face
  std::vector<const GeodesicWindow*> chosen_;   // of the current piece
  std::vector<Arrival> arrivals_;
  std::vector<std::size_t> by_formula_;  // layers of the current piece
  std::vector<TruthLayer> formula_layers_;
  std::vector<Vec4d> formula_sums_;
  std::vector<Kinked> kinked_;
  std::vector<const GeodesicWindow*> kinked_windows_;
  std::vector<double> kink_variance_;  // by layer
};

template <typename Scalar>
TruthValues convolve_all(const GeodesicSurface& surface, double tolerance,
                         std::span<const GeodesicTarget> targets, std::span<const TruthLayer> layers,
                         const std::function<void(std::size_t)>& advance) {
  TruthValues values(layers.size(), std::vector<Vec4d>(targets.size(), Vec4d::Zero()));
  const Plan<Scalar> plan = make_plan<Scalar>(surface, tolerance, layers);
  parallel_for((targets.size() + kTaskTargets - 1) / kTaskTargets, [&](std::size_t task) {
    TargetConvolution<Scalar> convolution(surface, tolerance, plan);
    const std::size_t end = std::min(targets.size(), (task + 1) * kTaskTargets);
    for (std::size_t i = task * kTaskTargets; i < end; ++i) {
      const std::vector<Vec4d> sums = convolution.at(targets[i]);
      for (std::size_t l = 0; l < sums.size(); ++l) values[plan.order[l]][i] = sums[l];
      if (advance) advance(layers.size());
    }
  });
  return values;
}

}  // namespace

GeodesicFastEngine::GeodesicFastEngine(const GeodesicSurface& surface, double tolerance)
    : surface_(surface), tolerance_(tolerance) {
  assert(tolerance > 0.0);
}

double GeodesicFastEngine::tail_bound() const { return 2.0 * kTailShare * tolerance_; }

TruthValues GeodesicFastEngine::convolve(std::span<const GeodesicTarget> targets,
                                         std::span<const TruthLayer> layers,
                                         const std::function<void(std::size_t)>& advance) const {
  if (layers.empty()) return {};
  return tolerance_ < kSinglePrecision ? convolve_all<double>(surface_, tolerance_, targets, layers, advance)
                                       : convolve_all<float>(surface_, tolerance_, targets, layers, advance);
}

}  // namespace truescatter
