#include "composite/tone.h"

#include <algorithm>

namespace truescatter {

double tone(ToneCurve curve, double light) {
  const double x = std::max(light, 0.0);
  if (curve == ToneCurve::linear) return std::min(x, 1.0);
  return std::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

}  // namespace truescatter
