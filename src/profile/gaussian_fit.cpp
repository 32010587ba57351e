#include "profile/gaussian_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <span>
#include <utility>

#include "core/error.h"
#include "profile/area_search.h"
#include "profile/variance_search.h"

namespace truescatter {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Quadratic norms are smooth integrands: radial_nodes says how good this is. The area norm has kinks.
constexpr double kFitNodesPerUnit = 6.0;
constexpr double kFitNodesPerUnitOfArea = 16.0;
constexpr double kLeastGap = 0.05;  // of log variance, between neighbours
constexpr double kLeastGapOfFreeWeights = 0.22;
// An added Gaussian that lowers the cost by less, relatively, adds nothing.
constexpr double kLeastGain = 1e-4;
constexpr int kPlacesToTry = 64;
// That are followed to the end. The area norm has more least costs close to each other.
constexpr std::size_t kLeads = 2;
constexpr std::size_t kLeadsInArea = 6;
constexpr Effort kToSeeWhere{15, 1e-3};
constexpr Effort kToSeeWhereInArea{30, 1e-4};
constexpr Effort kToTheEnd{200, 1e-13};

// By how much one more Gaussian at each place would lower the cost at first order, for its length.
std::vector<double> gains(const FitProblem& problem, const std::vector<double>& log_variances,
                          const std::vector<double>& places) {
  std::vector<double> gain(places.size(), 0.0);
  for (const FitChannel& channel : problem.channels) {
    const VectorXd residual =
        log_variances.empty()
            ? channel.data
            : solve_weights(design_of(channel, log_variances), channel.data, channel.rules).residual;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const VectorXd column = gaussian_column(channel, places[i]);
      if (!(column.norm() > kVanishing)) continue;  // too narrow for this channel's nodes
      const double along = column.dot(residual) / column.norm();
      if (along > 0.0 || !channel.rules.nonnegative) gain[i] += along * along;
    }
  }
  return gain;
}

std::vector<double> places_to_try(const FitProblem& problem) {
  std::vector<double> places;
  const FitProblem::Range range = problem.log_variance;
  for (int i = 0; i < kPlacesToTry; ++i)
    places.push_back(range.low + (range.high - range.low) * (i + 0.5) / kPlacesToTry);
  return places;
}

std::vector<double> with(std::vector<double> values, double one_more) {
  values.insert(std::upper_bound(values.begin(), values.end(), one_more), one_more);
  return values;
}

// Every place at which one more Gaussian would help more than beside it.
std::vector<std::vector<double>> grown(const FitProblem& problem, const std::vector<double>& log_variances) {
  const std::vector<double> places = places_to_try(problem);
  const std::vector<double> gain = gains(problem, log_variances, places);
  std::vector<std::vector<double>> starts;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool above_left = i == 0 || gain[i] > gain[i - 1];
    const bool above_right = i + 1 == places.size() || gain[i] >= gain[i + 1];
    if (gain[i] > 0.0 && above_left && above_right) starts.push_back(with(log_variances, places[i]));
  }
  return starts;
}

std::vector<std::vector<double>> with_one_moved(const FitProblem& problem,
                                                const std::vector<double>& log_variances) {
  const std::vector<double> places = places_to_try(problem);
  std::vector<std::vector<double>> starts;
  for (std::size_t i = 0; i < log_variances.size(); ++i) {
    std::vector<double> rest = log_variances;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    const std::vector<double> gain = gains(problem, rest, places);
    const auto best = std::max_element(gain.begin(), gain.end()) - gain.begin();
    starts.push_back(with(rest, places[static_cast<std::size_t>(best)]));
  }
  return starts;
}

std::vector<std::vector<double>> at_random(const FitProblem& problem, int gaussians,
                                           const FitOptions& options) {
  std::mt19937_64 engine(options.seed);
  // Not std::uniform_real_distribution, whose numbers depend on the library.
  const auto uniform = [&] { return std::ldexp(static_cast<double>(engine() >> 11), -53); };
  std::vector<std::vector<double>> starts(static_cast<std::size_t>(options.random_starts));
  for (std::vector<double>& start : starts) {
    for (int i = 0; i < gaussians; ++i) {
      start = with(std::move(start), problem.log_variance.low +
                                         uniform() * (problem.log_variance.high - problem.log_variance.low));
    }
  }
  return starts;
}

FitChannel channel_data(const FitTarget& target, const FitOptions& options) {
  const bool area = options.norm == FitNorm::area;
  const std::vector<RadialNode> nodes =
      radial_nodes(target, area ? kFitNodesPerUnitOfArea : kFitNodesPerUnit);
  const auto count = static_cast<Index>(nodes.size());
  FitChannel channel;
  channel.half_square_mm2 = channel.value = channel.measure = VectorXd(count);
  channel.rules.nonnegative = options.nonnegative;
  if (options.keep_albedo) channel.rules.total = target.albedo;
  for (Index i = 0; i < count; ++i) {
    const RadialNode& node = nodes[static_cast<std::size_t>(i)];
    const double r = node.radius_mm;
    channel.half_square_mm2[i] = 0.5 * r * r;
    channel.value[i] = target.value(r);
    channel.measure[i] = node.weight_mm * (options.norm == FitNorm::r2 ? r * r : r);
  }
  // The area norm starts from squares relative to the profile: int (R - S)^2 / R dA bounds its square.
  channel.scale = channel.measure.cwiseSqrt();
  if (area) channel.scale.array() /= channel.value.array().abs().max(1e-300).sqrt();
  channel.scale /= (channel.scale.array() * channel.value.array()).matrix().norm();
  channel.data = channel.scale.array() * channel.value.array();
  return channel;
}

FitProblem make_problem(std::span<const FitTarget> targets, const FitOptions& options) {
  FitProblem problem{{}, {0.0, 0.0}, options.nonnegative ? kLeastGap : kLeastGapOfFreeWeights};
  double narrowest_mm = std::numeric_limits<double>::infinity();
  double widest_mm = 0.0;
  for (const FitTarget& target : targets) {
    problem.channels.push_back(channel_data(target, options));
    narrowest_mm = std::min(narrowest_mm, target.narrowest_mm);
    widest_mm = std::max(widest_mm, target.widest_mm);
  }
  const double least_mm2 = narrowest_mm * narrowest_mm;
  const double low_mm2 = options.min_variance_mm2.value_or(least_mm2);
  if (low_mm2 < least_mm2) {
    throw_input_error({}, "a least variance of {} mm^2 is below what the profile resolves, {:.3g} mm^2",
                      low_mm2, least_mm2);
  }
  const double high_mm2 = options.max_variance_mm2.value_or(widest_mm * widest_mm);
  problem.log_variance = {std::log(low_mm2), std::log(high_mm2)};
  return problem;
}

void require_fit_input(std::span<const FitTarget> targets, int gaussians, const FitOptions& options) {
  if (gaussians < 1 || gaussians > kMostGaussians) {
    throw_input_error({}, "{} Gaussians: a fit has 1 to {}", gaussians, kMostGaussians);
  }
  for (const FitTarget& target : targets) {
    require_finite(options.norm, target);
    const std::size_t points = target.breaks_mm.size();
    if (points > 0 && points < 2 * static_cast<std::size_t>(gaussians)) {
      throw_input_error({}, "{} Gaussians have {} unknowns a channel, and the table has {} points", gaussians,
                        2 * gaussians, points);
    }
  }
}

void require_room(const FitProblem& problem, int gaussians) {
  const FitProblem::Range range = problem.log_variance;
  if (range.high - range.low < problem.gap * (gaussians - 1)) {
    throw_input_error(
        {},
        "variances of {} to {} mm^2 leave no room for {} Gaussians: neighbours differ by {:.0f} % "
        "at least",
        std::exp(range.low), std::exp(range.high), gaussians, 100.0 * std::expm1(problem.gap));
  }
}

FoundSum better_of(FoundSum a, FoundSum b) { return b.cost < a.cost ? std::move(b) : std::move(a); }

// The best sums of 1, 2, ... Gaussians, each from the one before.
class Growth {
 public:
  Growth(std::span<const FitTarget> targets, const FitOptions& options)
      : targets_(targets), problem_(make_problem(targets, options)), options_(options) {}

  const FitProblem& problem() const { return problem_; }

  // One Gaussian more. `thoroughly`: from random places too, and with each one moved.
  FoundSum next(const std::vector<double>& before, bool thoroughly) const {
    std::vector<std::vector<double>> starts = grown(problem_, before);
    if (starts.empty())
      starts.push_back(with(before, 0.5 * (problem_.log_variance.low + problem_.log_variance.high)));
    FoundSum best = best_of(starts);
    if (!thoroughly) return best;
    best = better_of(best, best_of(at_random(problem_, static_cast<int>(before.size()) + 1, options_)));
    while (true) {
      FoundSum moved = best_of(with_one_moved(problem_, best.log_variances));
      const bool helped = moved.cost < best.cost * (1.0 - kLeastGain);
      best = better_of(std::move(best), std::move(moved));
      if (!helped) return best;
    }
  }

 private:
  // All are followed until it is clear where they lead, the most promising to the end.
  FoundSum best_of(const std::vector<std::vector<double>>& starts) const {
    std::vector<FoundSum> leads;
    const Effort effort = options_.norm == FitNorm::area ? kToSeeWhereInArea : kToSeeWhere;
    for (const std::vector<double>& start : starts) leads.push_back(descend(problem_, start, effort));
    std::sort(leads.begin(), leads.end(),
              [](const FoundSum& a, const FoundSum& b) { return a.cost < b.cost; });
    leads.resize(std::min(leads.size(), options_.norm == FitNorm::area ? kLeadsInArea : kLeads));
    FoundSum best{{}, {}, std::numeric_limits<double>::infinity()};
    for (const FoundSum& lead : leads) {
      best = better_of(std::move(best), options_.norm == FitNorm::area
                                            ? descend_in_area(targets_, problem_, lead.log_variances)
                                            : descend(problem_, lead.log_variances, kToTheEnd));
    }
    return best;
  }

  std::span<const FitTarget> targets_;
  FitProblem problem_;
  FitOptions options_;
};

// Whether a sum of one Gaussian more is nearer by more than rounding.
bool helps(const FoundSum& before, const FoundSum& after) {
  constexpr double kNothingLeft = 1e-24;  // an error of 1e-12
  return before.cost > kNothingLeft && after.cost < before.cost * (1.0 - kLeastGain);
}

// The best sums of 1, 2, ... up to one that `is_enough`, or until one more does not help.
struct Grown {
  FoundSum found;
  bool enough = false;
};

template <typename IsEnough>
Grown grow(const Growth& growth, int most, bool thoroughly_each, const IsEnough& is_enough) {
  Grown grown{{{}, {}, std::numeric_limits<double>::infinity()}, false};
  for (int count = 1; count <= most; ++count) {
    FoundSum next = growth.next(grown.found.log_variances, thoroughly_each || count == most);
    if (!helps(grown.found, next) && !thoroughly_each && count < most)
      next = growth.next(grown.found.log_variances, true);
    if (!helps(grown.found, next)) return grown;
    grown.found = std::move(next);
    grown.enough = is_enough(grown.found);
    if (grown.enough) return grown;
  }
  return grown;
}

// Per target.
using Sums = std::vector<std::vector<WeightedGaussian>>;

Sums sums_of(const FoundSum& found) {
  Sums sums(static_cast<std::size_t>(found.weights.cols()));
  for (std::size_t c = 0; c < sums.size(); ++c) {
    for (std::size_t i = 0; i < found.log_variances.size(); ++i) {
      sums[c].push_back(
          {std::exp(found.log_variances[i]), found.weights(static_cast<Index>(i), static_cast<Index>(c))});
    }
  }
  return sums;
}

double worst_error(std::span<const FitTarget> targets, const Sums& sums, FitNorm norm) {
  double worst = 0.0;
  for (std::size_t i = 0; i < targets.size(); ++i)
    worst = std::max(worst, fit_errors(targets[i], sums[i]).in(norm).value_or(0.0));
  return worst;
}

Sums fit_exactly(std::span<const FitTarget> targets, int gaussians, const FitOptions& options) {
  require_fit_input(targets, gaussians, options);
  const Growth growth(targets, options);
  require_room(growth.problem(), gaussians);
  const auto has_all = [&](const FoundSum& found) {
    return found.log_variances.size() == static_cast<std::size_t>(gaussians);
  };
  const Grown grown = grow(growth, gaussians, false, has_all);
  const Sums sums = sums_of(grown.found);
  if (!grown.enough) {
    throw_input_error(
        {},
        "{} Gaussians are more than the profile carries: {} reach an error of {:.3g} in the norm "
        "{}, and another{} adds nothing",
        gaussians, grown.found.log_variances.size(), worst_error(targets, sums, options.norm),
        name_of(options.norm), options.nonnegative ? " of positive weight" : "");
  }
  return sums;
}

Sums fit_within(std::span<const FitTarget> targets, double tolerance, const FitOptions& options) {
  require_fit_input(targets, 1, options);
  const Growth growth(targets, options);
  require_room(growth.problem(), 1);
  std::size_t most = kMostGaussians;
  for (const FitTarget& target : targets)
    if (!target.breaks_mm.empty()) most = std::min(most, target.breaks_mm.size() / 2);
  const double room = growth.problem().log_variance.high - growth.problem().log_variance.low;
  most = std::min(most, static_cast<std::size_t>(room / growth.problem().gap) + 1);
  const auto is_near = [&](const FoundSum& found) {
    return worst_error(targets, sums_of(found), options.norm) <= tolerance;
  };
  const Grown grown = grow(growth, static_cast<int>(most), true, is_near);
  Sums sums = sums_of(grown.found);
  if (!grown.enough) {
    throw_input_error({}, "a tolerance of {} in the norm {} is out of reach: {} Gaussians{} come to {:.3g}",
                      tolerance, name_of(options.norm), grown.found.log_variances.size(),
                      options.nonnegative ? " of non-negative weight" : "",
                      worst_error(targets, sums, options.norm));
  }
  return sums;
}

// `fit` gives the sums of some targets.
template <typename Fit>
GaussianFit fit_channels(const std::array<FitTarget, 3>& targets, bool shared, const Fit& fit) {
  Sums sums;
  if (shared) {
    sums = fit(std::span<const FitTarget>(targets));
  } else {
    for (const FitTarget& target : targets) sums.push_back(fit(std::span(&target, 1)).front());
  }
  std::map<double, Vec3d> levels;
  GaussianFit result;
  for (std::size_t c = 0; c < 3; ++c) {
    for (const WeightedGaussian& gaussian : sums[c]) {
      const auto [level, added] = levels.try_emplace(gaussian.variance_mm2, Vec3d::Zero());
      level->second[static_cast<Index>(c)] = gaussian.weight;
    }
    result.errors[c] = fit_errors(targets[c], sums[c]);
  }
  for (const auto& [variance_mm2, weight] : levels) result.levels.push_back({variance_mm2, weight});
  return result;
}

}  // namespace

std::vector<WeightedGaussian> GaussianFit::channel(std::size_t c) const {
  std::vector<WeightedGaussian> sum;
  for (const GaussianLevel& level : levels)
    sum.push_back({level.variance_mm2, level.weight[static_cast<Index>(c)]});
  return sum;
}

Vec3d GaussianFit::total_weight() const {
  Vec3d total = Vec3d::Zero();
  for (const GaussianLevel& level : levels) total += level.weight;
  return total;
}

double GaussianFit::worst(FitNorm norm) const {
  double worst = 0.0;
  for (const FitErrors& channel : errors) worst = std::max(worst, channel.in(norm).value_or(0.0));
  return worst;
}

bool is_dark(const GaussianFit& fit, std::size_t channel) {
  return std::all_of(fit.levels.begin(), fit.levels.end(), [&](const GaussianLevel& level) {
    return level.weight[static_cast<Index>(channel)] == 0.0;
  });
}

GaussianFit fit_gaussians(const std::array<FitTarget, 3>& targets, int gaussians, const FitOptions& options) {
  return fit_channels(targets, options.shared_variances,
                      [&](std::span<const FitTarget> some) { return fit_exactly(some, gaussians, options); });
}

GaussianFit fit_to_tolerance(const std::array<FitTarget, 3>& targets, double tolerance,
                             const FitOptions& options) {
  return fit_channels(targets, options.shared_variances,
                      [&](std::span<const FitTarget> some) { return fit_within(some, tolerance, options); });
}

}  // namespace truescatter
