#pragma once

#include <Eigen/Dense>
#include <span>
#include <vector>

#include "profile/fit_norms.h"
#include "profile/fit_target.h"
#include "profile/weight_solver.h"

namespace truescatter {

// One channel at its quadrature's nodes: the squares of scale * (value - sum w G) sum to the squared relative
// error.
struct FitChannel {
  Eigen::VectorXd half_square_mm2;  // r^2 / 2
  Eigen::VectorXd value;
  Eigen::VectorXd measure;  // the quadrature's weight times the norm's power of r
  Eigen::VectorXd scale;
  Eigen::VectorXd data;  // scale * value
  WeightRules rules;
};

// What does not change while variances are sought.
struct FitProblem {
  struct Range {
    double low;
    double high;
  };
  std::vector<FitChannel> channels;
  Range log_variance;
  double gap;  // of log variance, between neighbours at least
};

// Variances and, in a row for each and a column for each channel, weights.
struct FoundSum {
  std::vector<double> log_variances;  // ascending
  Eigen::MatrixXd weights;
  double cost = 0.0;  // sum over channels of the squared relative errors
};

// scale * G(exp(log_variance), r) at every node.
Eigen::VectorXd gaussian_column(const FitChannel& channel, double log_variance);
// The same for each variance, in a column.
Eigen::MatrixXd design_of(const FitChannel& channel, std::span<const double> log_variances);

// The best weights of given variances.
FoundSum weighted(const FitProblem& problem, std::vector<double> log_variances);

// How far a descent goes.
struct Effort {
  int steps;
  double tolerance;  // of the cost, relative, at which it ends
};

// From some variances to a least cost nearby, within the problem's range and gap: Levenberg and Marquardt's
// method (Ceres) over variances alone, with the exact Jacobian of variable projection (Golub & Pereyra 1973).
FoundSum descend(const FitProblem& problem, std::span<const double> start, const Effort& effort);

}  // namespace truescatter
