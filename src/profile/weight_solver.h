#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

namespace truescatter {

struct WeightRules {
  bool nonnegative = true;
  std::optional<double> total;  // what the weights sum to; nothing: free
};

// Columns that are shorter have no digits left.
constexpr double kVanishing = 1e-140;

// The weights w that minimise |data - design w|^2 under the rules.
struct LinearFit {
  Eigen::VectorXd weights;
  Eigen::VectorXd residual;  // data - design w
  std::vector<int> carried;  // columns whose weight is not held at 0, ascending
  Eigen::MatrixXd basis;     // orthonormal, of the carried columns: design_carried = basis * triangular
  Eigen::MatrixXd triangular;
};

// Free weights by QR; non-negative ones by Lawson and Hanson's active sets (Solving Least Squares Problems,
// 1974, chapter 23), in which the total is an equality with a Lagrange multiplier. There are no more columns
// than rows; one that vanishes (kVanishing) is held at 0, and one at least does not.
LinearFit solve_weights(const Eigen::MatrixXd& design, const Eigen::VectorXd& data, const WeightRules& rules);

// How the carried weights of `fit` change with a parameter that moves column `column` of the design along
// `derivative`: by differentiating the normal equations (and the total). 0 if the column is not carried.
Eigen::VectorXd carried_derivative(const LinearFit& fit, const WeightRules& rules, int column,
                                   const Eigen::VectorXd& derivative);

}  // namespace truescatter
