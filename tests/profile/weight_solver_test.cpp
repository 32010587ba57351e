#include "profile/weight_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace truescatter {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRows = 20;
constexpr int kColumns = 5;

struct RandomProblem {
  MatrixXd design{kRows, kColumns};
  VectorXd data{kRows};

  explicit RandomProblem(unsigned seed) {
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    for (Index i = 0; i < design.size(); ++i) design.data()[i] = normal(engine);
    for (Index i = 0; i < data.size(); ++i) data[i] = normal(engine);
  }
};

// The least squares over the columns of a subset, with a total by eliminating its last column's weight.
VectorXd over_subset(const RandomProblem& problem, unsigned subset, std::optional<double> total) {
  std::vector<int> columns;
  for (int i = 0; i < kColumns; ++i)
    if ((subset >> i) & 1u) columns.push_back(i);
  VectorXd weights = VectorXd::Zero(kColumns);
  MatrixXd design = problem.design(Eigen::all, columns);
  VectorXd data = problem.data;
  if (total) {
    const VectorXd last = design.rightCols(1);
    data -= *total * last;
    design = (design.leftCols(design.cols() - 1).colwise() - last).eval();
  }
  VectorXd some =
      design.cols() > 0 ? VectorXd(design.completeOrthogonalDecomposition().solve(data)) : VectorXd();
  if (total) {
    some.conservativeResize(some.size() + 1);
    some[some.size() - 1] = *total - some.head(some.size() - 1).sum();
  }
  for (std::size_t i = 0; i < columns.size(); ++i) weights[columns[i]] = some[static_cast<Index>(i)];
  return weights;
}

// Every subset of columns is tried: the best whose weights are not negative.
VectorXd by_exhaustion(const RandomProblem& problem, std::optional<double> total) {
  VectorXd best = VectorXd::Zero(kColumns);
  double least = total ? std::numeric_limits<double>::infinity() : problem.data.squaredNorm();
  for (unsigned subset = 1; subset < (1u << kColumns); ++subset) {
    const VectorXd weights = over_subset(problem, subset, total);
    const double error = (problem.data - problem.design * weights).squaredNorm();
    if (weights.minCoeff() < 0.0 || error >= least) continue;
    least = error;
    best = weights;
  }
  return best;
}

// Problems of a condition of some 10 and values of some 1: rounding is well below 1e-11.
constexpr double kRounding = 1e-11;

TEST(WeightSolver, NonNegativeWeightsAreTheBestOfEverySubset) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const RandomProblem problem(seed);
    for (const std::optional<double> total : {std::optional<double>(), std::optional<double>(0.8)}) {
      const LinearFit fit = solve_weights(problem.design, problem.data, {true, total});
      EXPECT_LT((fit.weights - by_exhaustion(problem, total)).norm(), kRounding) << seed;
      EXPECT_LT((problem.design * fit.weights + fit.residual - problem.data).norm(), kRounding) << seed;
    }
  }
}

TEST(WeightSolver, FreeWeightsAreThoseOfAllColumns) {
  const unsigned all = (1u << kColumns) - 1u;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const RandomProblem problem(seed);
    for (const std::optional<double> total : {std::optional<double>(), std::optional<double>(0.8)}) {
      const LinearFit fit = solve_weights(problem.design, problem.data, {false, total});
      EXPECT_LT((fit.weights - over_subset(problem, all, total)).norm(), kRounding) << seed;
    }
  }
}

// Against the central difference with a step of 1e-5: its third-order term is 1e-10 of the weights' third
// derivative (some 1e2 at most for these problems), and rounding is 1e-16 * 10 / 1e-5.
TEST(WeightSolver, DerivativesAreThoseOfDifferences) {
  constexpr double kStep = 1e-5;
  int compared = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const RandomProblem problem(seed);
    const VectorXd along = RandomProblem(seed + 1000).data;
    for (const WeightRules& rules :
         {WeightRules{true, {}}, WeightRules{true, 0.8}, WeightRules{false, {}}, WeightRules{false, 0.8}}) {
      const auto moved = [&](int column, double step) {
        MatrixXd design = problem.design;
        design.col(column) += step * along;
        return solve_weights(design, problem.data, rules);
      };
      const LinearFit fit = solve_weights(problem.design, problem.data, rules);
      for (int column = 0; column < kColumns; ++column) {
        const LinearFit forth = moved(column, kStep);
        const LinearFit back = moved(column, -kStep);
        if (forth.carried != fit.carried || back.carried != fit.carried) continue;  // a kink
        const VectorXd difference = (forth.weights - back.weights) / (2.0 * kStep);
        const VectorXd derivative = carried_derivative(fit, rules, column, along);
        for (std::size_t i = 0; i < fit.carried.size(); ++i) {
          EXPECT_NEAR(derivative[static_cast<Index>(i)], difference[fit.carried[i]], 2e-8) << seed;
          ++compared;
        }
      }
    }
  }
  EXPECT_GT(compared, 1000);
}

}  // namespace
}  // namespace truescatter
