#include "metrics/error_spread.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace truescatter {

// Welford's update: equal errors leave the mean, and so the squares, untouched to the last bit.
void ErrorSpread::add(std::size_t point, double error) {
  assert(point < of_point_.size());
  Moments& moments = of_point_[point];
  ++moments.views;
  const double from_old_mean = error - moments.mean;
  moments.mean =
      moments.views == 1 ? error : moments.mean + from_old_mean / static_cast<double>(moments.views);
  if (moments.views > 1) moments.squares += from_old_mean * (error - moments.mean);
}

SpreadStats ErrorSpread::stats() const {
  std::vector<double> spreads;
  double squares = 0.0;
  for (const Moments& moments : of_point_) {
    if (moments.views < 2) continue;
    const double variance = moments.squares / static_cast<double>(moments.views);
    squares += variance;
    spreads.push_back(std::sqrt(variance));
  }
  SpreadStats stats;
  stats.points = spreads.size();
  if (spreads.empty()) {
    stats.rms = stats.p95 = stats.max = std::numeric_limits<double>::quiet_NaN();
    return stats;
  }
  std::sort(spreads.begin(), spreads.end());
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(spreads.size())));
  stats.rms = std::sqrt(squares / static_cast<double>(spreads.size()));
  stats.p95 = spreads[std::max<std::size_t>(rank, 1) - 1];
  stats.max = spreads.back();
  return stats;
}

}  // namespace truescatter
