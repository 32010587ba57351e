#include "truth/line_rule.h"

#include <cmath>
#include <utility>

#include "core/vec.h"

namespace truescatter {

// The roots of the Legendre polynomial by Newton's method.
LineRule::LineRule(int n) {
  for (int i = 0; i < n; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5));
    double slope = 1.0;
    for (int iteration = 0; iteration < 20; ++iteration) {
      double below = 1.0;
      double value = x;
      for (int k = 2; k <= n; ++k) {
        below = std::exchange(value, ((2 * k - 1) * x * value - (k - 1) * below) / k);
      }
      slope = n * (x * value - below) / (x * x - 1.0);
      x -= value / slope;
    }
    nodes.push_back(0.5 * (1.0 + x));
    weights.push_back(1.0 / ((1.0 - x * x) * slope * slope));
  }
}

const std::array<LineRule, 3>& brute_rules() {
  static const std::array<LineRule, 3> rules = {LineRule(3), LineRule(5), LineRule(8)};
  return rules;
}

}  // namespace truescatter
