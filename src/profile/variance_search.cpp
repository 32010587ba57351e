#include "profile/variance_search.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/vec.h"

namespace truescatter {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Variances in the order and the range that is asked for, as a box: with theta_0 = low - gap and
// high_i = high - (k - i) gap, theta_i = theta_(i-1) + gap + x_i (high_i - theta_(i-1) - gap), 0 <= x_i <= 1.
struct OrderedBox {
  FitProblem::Range range;
  double gap;

  std::vector<double> log_variances(const double* x, Index count) const {
    std::vector<double> theta;
    double last = range.low - gap;
    for (Index i = 0; i < count; ++i) {
      last += gap + x[i] * room(last, i, count);
      theta.push_back(last);
    }
    return theta;
  }

  // d theta_i / d x_j, lower triangular.
  MatrixXd jacobian(const double* x, Index count) const {
    MatrixXd derivative = MatrixXd::Zero(count, count);
    double last = range.low - gap;
    for (Index i = 0; i < count; ++i) {
      const double left = room(last, i, count);
      if (i > 0) derivative.row(i) = (1.0 - x[i]) * derivative.row(i - 1);
      derivative(i, i) = left;
      last += gap + x[i] * left;
    }
    return derivative;
  }

  // The box's coordinates of variances, moved as little as the order and range ask for.
  std::vector<double> coordinates(std::span<const double> start) const {
    std::vector<double> theta(start.begin(), start.end());
    std::sort(theta.begin(), theta.end());
    std::vector<double> x;
    double last = range.low - gap;
    const auto count = static_cast<Index>(theta.size());
    for (Index i = 0; i < count; ++i) {
      const double left = room(last, i, count);
      const double at = left > 0.0 ? (theta[static_cast<std::size_t>(i)] - last - gap) / left : 0.0;
      x.push_back(std::clamp(at, 0.0, 1.0));
      last += gap + x.back() * left;
    }
    return x;
  }

 private:
  double room(double last, Index i, Index count) const {
    return range.high - static_cast<double>(count - 1 - i) * gap - last - gap;
  }
};

// data - design w of the best weights w, of all channels, as a function of the box's coordinates. (The base
// class is the library's.)
class ProjectedResidual : public ceres::CostFunction {
 public:
  ProjectedResidual(const FitProblem& problem, Index count)
      : problem_(problem), box_{problem.log_variance, problem.gap}, count_(count) {
    Index rows = 0;
    for (const FitChannel& channel : problem.channels) rows += channel.data.size();
    set_num_residuals(static_cast<int>(rows));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(count));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const std::vector<double> theta = box_.log_variances(parameters[0], count_);
    const bool wants_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    MatrixXd by_theta(wants_jacobian ? num_residuals() : 0, count_);
    Index row = 0;
    for (const FitChannel& channel : problem_.channels) {
      const MatrixXd design = design_of(channel, theta);
      const LinearFit fit = solve_weights(design, channel.data, channel.rules);
      const Index rows = channel.data.size();
      Eigen::Map<VectorXd>(residuals + row, rows) = fit.residual;
      if (wants_jacobian) by_theta.middleRows(row, rows) = derivative(channel, design, theta, fit);
      row += rows;
    }
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    if (wants_jacobian) {
      Eigen::Map<RowMajor>(jacobians[0], num_residuals(), count_) =
          by_theta * box_.jacobian(parameters[0], count_);
    }
    return true;
  }

 private:
  // By log v_i: dG/dlog v = (r^2 / 2v - 1) G in one column, and the weights that follow.
  MatrixXd derivative(const FitChannel& channel, const MatrixXd& design, const std::vector<double>& theta,
                      const LinearFit& fit) const {
    MatrixXd by_theta = MatrixXd::Zero(design.rows(), count_);
    for (const int i : fit.carried) {
      const VectorXd column =
          (channel.half_square_mm2.array() * std::exp(-theta[static_cast<std::size_t>(i)]) - 1.0) *
          design.col(i).array();
      by_theta.col(i) = -fit.weights[i] * column;
      by_theta.col(i) -= fit.basis * (fit.triangular * carried_derivative(fit, channel.rules, i, column));
    }
    return by_theta;
  }

  const FitProblem& problem_;
  OrderedBox box_;
  Index count_;
};

}  // namespace

VectorXd gaussian_column(const FitChannel& channel, double log_variance) {
  const double variance = std::exp(log_variance);
  return channel.scale.array() * (-channel.half_square_mm2.array() / variance).exp() / (2.0 * kPi * variance);
}

MatrixXd design_of(const FitChannel& channel, std::span<const double> log_variances) {
  MatrixXd design(channel.data.size(), static_cast<Index>(log_variances.size()));
  for (std::size_t i = 0; i < log_variances.size(); ++i)
    design.col(static_cast<Index>(i)) = gaussian_column(channel, log_variances[i]);
  return design;
}

FoundSum weighted(const FitProblem& problem, std::vector<double> log_variances) {
  FoundSum found;
  found.weights =
      MatrixXd(static_cast<Index>(log_variances.size()), static_cast<Index>(problem.channels.size()));
  for (std::size_t c = 0; c < problem.channels.size(); ++c) {
    const FitChannel& channel = problem.channels[c];
    const LinearFit fit = solve_weights(design_of(channel, log_variances), channel.data, channel.rules);
    found.weights.col(static_cast<Index>(c)) = fit.weights;
    found.cost += fit.residual.squaredNorm();
  }
  found.log_variances = std::move(log_variances);
  return found;
}

FoundSum descend(const FitProblem& problem, std::span<const double> start, const Effort& effort) {
  const OrderedBox box{problem.log_variance, problem.gap};
  const auto count = static_cast<Index>(start.size());
  std::vector<double> x = box.coordinates(start);
  ceres::Problem search;
  search.AddResidualBlock(new ProjectedResidual(problem, count), nullptr, x.data());
  for (int i = 0; i < static_cast<int>(count); ++i) {
    search.SetParameterLowerBound(x.data(), i, 0.0);
    search.SetParameterUpperBound(x.data(), i, 1.0);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = effort.steps;
  options.function_tolerance = effort.tolerance;
  options.parameter_tolerance = 1e-11;
  options.gradient_tolerance = 1e-16;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &search, &summary);
  return weighted(problem, box.log_variances(x.data(), count));
}

}  // namespace truescatter
