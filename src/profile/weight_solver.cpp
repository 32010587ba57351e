#include "profile/weight_solver.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

namespace truescatter {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A gradient below this, of a column's and the data's length, is rounding.
constexpr double kGradientRounding = 1e-13;

// R^-1 R^-T x, the inverse of the carried columns' Gram matrix.
VectorXd gram_inverse(const MatrixXd& triangular, const VectorXd& x) {
  const auto upper = triangular.triangularView<Eigen::Upper>();
  const VectorXd half = upper.transpose().solve(x);
  return upper.solve(half);
}

std::vector<int> usable_columns(const MatrixXd& design) {
  std::vector<int> columns;
  for (Eigen::Index i = 0; i < design.cols(); ++i)
    if (design.col(i).norm() > kVanishing) columns.push_back(static_cast<int>(i));
  return columns;
}

// The least squares over some columns, negative weights allowed.
struct Passive {
  std::vector<int> columns;
  MatrixXd basis;
  MatrixXd triangular;
  VectorXd weights;
  double multiplier = 0.0;  // of the total; design^T residual is equal to it in every passive column
};

Passive solve_passive(const MatrixXd& design, const VectorXd& data, std::vector<int> columns,
                      const std::optional<double>& total) {
  Passive passive;
  const auto count = static_cast<Eigen::Index>(columns.size());
  passive.basis = MatrixXd(design.rows(), 0);
  if (columns.empty()) return passive;
  const Eigen::HouseholderQR<MatrixXd> qr(design(Eigen::all, columns));
  passive.basis = qr.householderQ() * MatrixXd::Identity(design.rows(), count);
  passive.triangular = qr.matrixQR().topRows(count).triangularView<Eigen::Upper>();
  const VectorXd projected = passive.basis.transpose() * data;
  passive.weights = passive.triangular.triangularView<Eigen::Upper>().solve(projected);
  if (total) {
    const VectorXd towards = gram_inverse(passive.triangular, VectorXd::Ones(count));
    const double missing = *total - passive.weights.sum();
    passive.weights += towards * (missing / towards.sum());
    passive.multiplier = -missing / towards.sum();
  }
  passive.columns = std::move(columns);
  return passive;
}

LinearFit linear_fit(const MatrixXd& design, const VectorXd& data, Passive passive) {
  LinearFit fit;
  fit.weights = VectorXd::Zero(design.cols());
  for (std::size_t i = 0; i < passive.columns.size(); ++i)
    fit.weights[passive.columns[i]] = passive.weights[static_cast<Eigen::Index>(i)];
  fit.residual = data - design * fit.weights;
  fit.carried = std::move(passive.columns);
  fit.basis = std::move(passive.basis);
  fit.triangular = std::move(passive.triangular);
  return fit;
}

// The column outside `passive` along which the error falls fastest, for its length; -1: none does.
int steepest_column(const MatrixXd& design, const VectorXd& data, const Passive& passive,
                    const VectorXd& weights) {
  const VectorXd gradient = design.transpose() * (data - design * weights);
  int best = -1;
  double steepest = kGradientRounding * data.norm();
  for (Eigen::Index i = 0; i < design.cols(); ++i) {
    const int column = static_cast<int>(i);
    if (std::find(passive.columns.begin(), passive.columns.end(), column) != passive.columns.end()) continue;
    if (!(design.col(i).norm() > kVanishing)) continue;
    const double slope = (gradient[i] - passive.multiplier) / design.col(i).norm();
    if (slope <= steepest) continue;
    steepest = slope;
    best = column;
  }
  return best;
}

// Moves `weights` (feasible, 0 outside the passive columns) towards the passive solution, giving up columns
// whose weights reach 0, until all passive weights are positive.
Passive make_feasible(const MatrixXd& design, const VectorXd& data, const std::optional<double>& total,
                      Passive passive, VectorXd& weights) {
  while (passive.weights.size() > 0 && passive.weights.minCoeff() <= 0.0) {
    double step = 1.0;
    for (std::size_t i = 0; i < passive.columns.size(); ++i) {
      const double to = passive.weights[static_cast<Eigen::Index>(i)];
      const double from = weights[passive.columns[i]];
      if (to <= 0.0) step = std::min(step, from / (from - to));
    }
    std::vector<int> kept;
    for (std::size_t i = 0; i < passive.columns.size(); ++i) {
      double& weight = weights[passive.columns[i]];
      const double to = passive.weights[static_cast<Eigen::Index>(i)];
      weight += step * (to - weight);
      const bool reached_zero = to <= 0.0 && weight <= 1e-15 * weights.cwiseAbs().maxCoeff();
      if (reached_zero) weight = 0.0;
      if (!reached_zero) kept.push_back(passive.columns[i]);
    }
    if (kept.size() == passive.columns.size()) break;  // rounding: none of them is below 0 by more
    passive = solve_passive(design, data, std::move(kept), total);
  }
  weights.setZero();
  for (std::size_t i = 0; i < passive.columns.size(); ++i)
    weights[passive.columns[i]] = std::max(0.0, passive.weights[static_cast<Eigen::Index>(i)]);
  return passive;
}

// A feasible start: with a total, the one column that serves best with all of it.
Passive first_passive(const MatrixXd& design, const VectorXd& data, const std::optional<double>& total) {
  if (!total) return solve_passive(design, data, {}, total);
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const int i : usable_columns(design)) {
    const double error = (data - design.col(i) * *total).squaredNorm();
    if (error >= least) continue;
    least = error;
    best = i;
  }
  return solve_passive(design, data, {best}, total);
}

LinearFit solve_nonnegative(const MatrixXd& design, const VectorXd& data,
                            const std::optional<double>& total) {
  // Most often no weight is held at 0.
  Passive free = solve_passive(design, data, usable_columns(design), total);
  if (free.weights.size() > 0 && free.weights.minCoeff() > 0.0)
    return linear_fit(design, data, std::move(free));

  Passive passive = first_passive(design, data, total);
  VectorXd weights = VectorXd::Zero(design.cols());
  for (std::size_t i = 0; i < passive.columns.size(); ++i)
    weights[passive.columns[i]] = passive.weights[static_cast<Eigen::Index>(i)];
  double error = (data - design * weights).squaredNorm();
  while (true) {
    const int column = steepest_column(design, data, passive, weights);
    if (column < 0) break;
    std::vector<int> columns = passive.columns;
    columns.insert(std::upper_bound(columns.begin(), columns.end(), column), column);
    VectorXd trial_weights = weights;
    Passive trial = make_feasible(design, data, total, solve_passive(design, data, std::move(columns), total),
                                  trial_weights);
    const double trial_error = (data - design * trial_weights).squaredNorm();
    if (!(trial_error < error)) break;  // what is left to gain is rounding
    error = trial_error;
    weights = std::move(trial_weights);
    passive = std::move(trial);
  }
  return linear_fit(design, data, std::move(passive));
}

}  // namespace

LinearFit solve_weights(const MatrixXd& design, const VectorXd& data, const WeightRules& rules) {
  assert(design.rows() == data.size() && design.cols() <= design.rows());
  if (rules.nonnegative) return solve_nonnegative(design, data, rules.total);
  return linear_fit(design, data, solve_passive(design, data, usable_columns(design), rules.total));
}

// Of design^T (data - design w) = multiplier: gram dw = e_column (derivative . residual) - design^T
// derivative w_column - d(multiplier), with sum dw = 0 where there is a total.
VectorXd carried_derivative(const LinearFit& fit, const WeightRules& rules, int column,
                            const VectorXd& derivative) {
  const auto count = static_cast<Eigen::Index>(fit.carried.size());
  const auto place = std::find(fit.carried.begin(), fit.carried.end(), column);
  if (place == fit.carried.end()) return VectorXd::Zero(count);
  VectorXd side = -fit.weights[column] * (fit.triangular.transpose() * (fit.basis.transpose() * derivative));
  side[place - fit.carried.begin()] += derivative.dot(fit.residual);
  VectorXd change = gram_inverse(fit.triangular, side);
  if (rules.total) {
    const VectorXd towards = gram_inverse(fit.triangular, VectorXd::Ones(count));
    change -= towards * (change.sum() / towards.sum());
  }
  return change;
}

}  // namespace truescatter
