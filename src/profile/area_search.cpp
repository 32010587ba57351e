#include "profile/area_search.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/vec.h"
#include "profile/fit_norms.h"

namespace truescatter {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMajorants = 8;
constexpr Effort kAFewSteps{4, 1e-8};
// Of the mean relative error: where the error crosses 0 the majorant would be infinitely steep.
constexpr double kFloorOfError = 1e-2;
constexpr int kRestarts = 20;
constexpr double kConverged = 1e-9;           // of the cost, relative
constexpr double kSearchNodesPerUnit = 32.0;  // no two zeros of R - S between neighbouring nodes

// Weighs the squares anew, so that they touch the area norm where the sum is `found`.
void reweight(const FoundSum& found, std::vector<FitChannel>& channels) {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    FitChannel& channel = channels[c];
    const VectorXd residual =
        channel.data - design_of(channel, found.log_variances) * found.weights.col(static_cast<Index>(c));
    const VectorXd error = (residual.array() / channel.scale.array()).abs();
    const double whole = channel.measure.dot(channel.value.cwiseAbs());
    const double relative = channel.measure.dot(error) / whole;
    const double faint = 1e-9 * whole / channel.measure.sum();
    const VectorXd floor = kFloorOfError * relative * (channel.value.array().abs() + faint);
    channel.scale = (channel.measure.array() / (whole * error.cwiseMax(floor).array())).sqrt();
    channel.data = channel.scale.array() * channel.value.array();
  }
}

// A channel's weights as functions of parameters that may have any value: exponentials where weights are not
// negative, shares of the total where there is one.
VectorXd weights_of(const WeightRules& rules, const VectorXd& u) {
  if (rules.nonnegative && rules.total) {
    const VectorXd shares = (u.array() - u.maxCoeff()).exp();
    return shares * (*rules.total / shares.sum());
  }
  if (rules.nonnegative) return u.array().exp();
  if (rules.total) return u.array() + (*rules.total - u.sum()) / static_cast<double>(u.size());
  return u;
}

VectorXd gradient_of_parameters(const WeightRules& rules, const VectorXd& weights, const VectorXd& gradient) {
  if (rules.nonnegative && rules.total)
    return weights.array() * (gradient.array() - gradient.dot(weights) / *rules.total);
  if (rules.nonnegative) return weights.array() * gradient.array();
  if (rules.total) return gradient.array() - gradient.mean();
  return gradient;
}

VectorXd parameters_of(const WeightRules& rules, const VectorXd& weights) {
  // What is held at 0 is left there: far down the exponential, its slope is 0 as well.
  return rules.nonnegative ? VectorXd(weights.array().max(1e-12 * weights.maxCoeff()).log()) : weights;
}

struct AreaError {
  double relative = 0.0;
  VectorXd by_log_variance;
  VectorXd by_weight;
};

AreaError area_error(const FitTarget& target, std::span<const RadialNode> nodes, double whole,
                     const std::vector<double>& log_variances, const VectorXd& weights) {
  const auto count = static_cast<Index>(log_variances.size());
  std::vector<WeightedGaussian> sum;
  for (Index i = 0; i < count; ++i)
    sum.push_back({std::exp(log_variances[static_cast<std::size_t>(i)]), weights[i]});
  const std::vector<double> ends = stretches_of_one_sign(
      target, nodes, [&](double r_mm) { return target.value(r_mm) - sum_value(sum, r_mm); });

  AreaError error{0.0, VectorXd::Zero(count), VectorXd::Zero(count)};
  // F of R - S at the end of a stretch, and its derivatives by log variances and weights.
  struct AtEnd {
    double antiderivative;
    VectorXd by_log_variance;
    VectorXd by_weight;
  };
  const auto at = [&](double r_mm) {
    AtEnd end{target.antiderivative(r_mm) - sum_antiderivative(sum, r_mm), VectorXd(count), VectorXd(count)};
    for (Index i = 0; i < count; ++i) {
      const WeightedGaussian& gaussian = sum[static_cast<std::size_t>(i)];
      const double exponent = 0.5 * r_mm * r_mm / gaussian.variance_mm2;
      end.by_weight[i] = std::exp(-exponent) / (2.0 * kPi);
      end.by_log_variance[i] = gaussian.weight * exponent * end.by_weight[i];
    }
    return end;
  };
  AtEnd before = at(ends.front());
  const AtEnd nowhere{0.0, VectorXd::Zero(count), VectorXd::Zero(count)};  // infinitely far
  for (std::size_t j = 1; j <= ends.size(); ++j) {
    AtEnd here = j < ends.size() ? at(ends[j]) : nowhere;
    const double light = here.antiderivative - before.antiderivative;
    const double sign = light < 0.0 ? -1.0 / whole : 1.0 / whole;
    error.relative += sign * light;
    error.by_log_variance += sign * (here.by_log_variance - before.by_log_variance);
    error.by_weight += sign * (here.by_weight - before.by_weight);
    before = std::move(here);
  }
  return error;
}

// The sum over channels of the relative errors. Its parameters: for each variance t of log v = low +
// (high - low) / (1 + exp(-t)), then each channel's of weights_of. (The base class is the library's.)
class AreaCost : public ceres::FirstOrderFunction {
 public:
  AreaCost(std::span<const FitTarget> targets, const FitProblem& problem, Index count)
      : targets_(targets), problem_(problem), count_(count) {
    for (const FitTarget& target : targets) {
      nodes_.push_back(radial_nodes(target, kSearchNodesPerUnit));
      wholes_.push_back(absolute_light(target, nodes_.back()));
    }
  }

  int NumParameters() const override {
    return static_cast<int>(count_ * static_cast<Index>(1 + targets_.size()));
  }

  std::vector<double> parameters(const FoundSum& found) const {
    std::vector<double> x;
    for (const double theta : found.log_variances) {
      const double at = std::clamp((theta - low()) / length(), 1e-9, 1.0 - 1e-9);
      x.push_back(std::log(at / (1.0 - at)));
    }
    for (std::size_t c = 0; c < targets_.size(); ++c) {
      const VectorXd u = parameters_of(problem_.channels[c].rules, found.weights.col(static_cast<Index>(c)));
      x.insert(x.end(), u.begin(), u.end());
    }
    return x;
  }

  FoundSum found(const double* x) const {
    FoundSum found{log_variances(x), MatrixXd(count_, static_cast<Index>(targets_.size())), 0.0};
    for (std::size_t c = 0; c < targets_.size(); ++c)
      found.weights.col(static_cast<Index>(c)) = weights_of(problem_.channels[c].rules, block(x, c));
    Evaluate(x, &found.cost, nullptr);
    return found;
  }

  bool Evaluate(const double* x, double* cost, double* gradient) const override {
    const std::vector<double> theta = log_variances(x);
    VectorXd by_theta = VectorXd::Zero(count_);
    *cost = 0.0;
    for (std::size_t c = 0; c < targets_.size(); ++c) {
      const WeightRules& rules = problem_.channels[c].rules;
      const VectorXd weights = weights_of(rules, block(x, c));
      if (!weights.allFinite()) return false;  // too long a step
      const AreaError error = area_error(targets_[c], nodes_[c], wholes_[c], theta, weights);
      *cost += error.relative;
      by_theta += error.by_log_variance;
      if (gradient == nullptr) continue;
      Eigen::Map<VectorXd>(gradient + count_ * static_cast<Index>(1 + c), count_) =
          gradient_of_parameters(rules, weights, error.by_weight);
    }
    if (gradient == nullptr) return std::isfinite(*cost);
    for (Index i = 0; i < count_; ++i) {
      const double at = (theta[static_cast<std::size_t>(i)] - low()) / length();
      gradient[i] = by_theta[i] * length() * at * (1.0 - at);
    }
    return std::isfinite(*cost);
  }

 private:
  double low() const { return problem_.log_variance.low; }
  double length() const { return problem_.log_variance.high - low(); }

  std::vector<double> log_variances(const double* x) const {
    std::vector<double> theta;
    for (Index i = 0; i < count_; ++i) theta.push_back(low() + length() / (1.0 + std::exp(-x[i])));
    return theta;
  }

  Eigen::Map<const VectorXd> block(const double* x, std::size_t channel) const {
    return {x + count_ * static_cast<Index>(1 + channel), count_};
  }

  std::span<const FitTarget> targets_;
  const FitProblem& problem_;
  Index count_;
  std::vector<std::vector<RadialNode>> nodes_;
  std::vector<double> wholes_;
};

bool keeps_gaps(const FitProblem& problem, const std::vector<double>& log_variances) {
  for (std::size_t i = 1; i < log_variances.size(); ++i)
    if (!(log_variances[i] - log_variances[i - 1] >= problem.gap * (1.0 - 1e-9))) return false;
  return true;
}

}  // namespace

FoundSum descend_in_area(std::span<const FitTarget> targets, FitProblem problem,
                         std::span<const double> start) {
  FoundSum near = weighted(problem, {start.begin(), start.end()});
  for (int i = 0; i < kMajorants; ++i) {
    reweight(near, problem.channels);
    near = descend(problem, near.log_variances, kAFewSteps);
  }
  auto cost = std::make_unique<AreaCost>(targets, problem, static_cast<Index>(start.size()));
  const AreaCost& area = *cost;
  std::vector<double> x = area.parameters(near);
  near.cost = area.found(x.data()).cost;

  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::BFGS;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 500;
  options.function_tolerance = 1e-13;
  options.parameter_tolerance = 1e-13;
  options.gradient_tolerance = 1e-12;
  const ceres::GradientProblem search(cost.release());
  FoundSum found = near;
  // A line search that ends where two zeros meet is taken up again.
  for (int i = 0; i < kRestarts; ++i) {
    ceres::GradientProblemSolver::Summary summary;
    ceres::Solve(options, search, x.data(), &summary);
    const double before = found.cost;
    found = area.found(x.data());
    if (!(found.cost < before * (1.0 - kConverged))) break;
  }
  return found.cost < near.cost && keeps_gaps(problem, found.log_variances) ? found : near;
}

}  // namespace truescatter
