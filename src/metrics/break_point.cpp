#include "metrics/break_point.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace truescatter {
namespace {

struct Measured {
  double at;
  double error;
};

std::vector<Measured> measured(const DifficultyCurve& curve) {
  assert(curve.axis.size() == curve.error.size());
  std::vector<Measured> points;
  for (std::size_t i = 0; i < curve.axis.size(); ++i) {
    if (std::isfinite(curve.error[i])) points.push_back({curve.axis[i], curve.error[i]});
  }
  return points;
}

}  // namespace

BreakPoint break_point(const DifficultyCurve& curve, double level) {
  const std::vector<Measured> points = measured(curve);
  if (points.empty()) return {std::nullopt, "nothing was measured"};
  if (points.front().error > level)
    return {std::nullopt,
            fmt::format("above from the start: {:.2g} % at the easy end", 100.0 * points.front().error)};
  const auto above =
      std::find_if(points.begin(), points.end(), [&](const Measured& p) { return p.error > level; });
  if (above == points.end()) {
    const auto most = std::max_element(
        points.begin(), points.end(), [](const Measured& a, const Measured& b) { return a.error < b.error; });
    return {std::nullopt, fmt::format("never: {:.2g} % at most", 100.0 * most->error)};
  }
  const Measured& below = *(above - 1);
  const double share = (level - below.error) / (above->error - below.error);
  const auto scaled = [&](double at) { return curve.log_axis ? std::log(at) : at; };
  const double at = scaled(below.at) + share * (scaled(above->at) - scaled(below.at));
  return {curve.log_axis ? std::exp(at) : at, ""};
}

bool only_rises(const DifficultyCurve& curve, double tolerance) {
  const std::vector<Measured> points = measured(curve);
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].error < points[i - 1].error - tolerance) return false;
  }
  return true;
}

}  // namespace truescatter
