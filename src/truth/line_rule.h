#pragma once

#include <array>
#include <vector>

namespace truescatter {

// The Gauss-Legendre rule of n nodes on [0, 1].
struct LineRule {
  std::vector<double> nodes;
  std::vector<double> weights;

  explicit LineRule(int n);
};

// The rules that plain quadrature compares in pairs: 3 and 5, then 5 and 8 nodes.
const std::array<LineRule, 3>& brute_rules();

}  // namespace truescatter
