#pragma once

#include <optional>
#include <string>
#include <vector>

namespace truescatter {

// An error at each value of a difficulty, from the easy end to the hard one. What is not finite was not
// measured and is passed over.
struct DifficultyCurve {
  std::vector<double> axis;  // strictly growing or falling
  std::vector<double> error;
  bool log_axis = false;  // logarithmic between neighbouring values; they are positive then
};

struct BreakPoint {
  std::optional<double> value;
  std::string reason;  // why there is none
};

// Where the error first passes `level` on the way from easy to hard: interpolated between the last value at
// or below it and the first one above, linear in the error. None where the error never passes it, or is above
// it from the start.
BreakPoint break_point(const DifficultyCurve& curve, double level);

// Whether no error is below the one before it by more than `tolerance`.
bool only_rises(const DifficultyCurve& curve, double tolerance);

}  // namespace truescatter
