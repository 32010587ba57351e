#pragma once

#include <cstdint>
#include <span>

#include "truth/fast.h"

namespace truescatter {

// What an audit of `fast` against `exact` found, in units of the scene's largest irradiance.
struct Certificate {
  std::size_t audited = 0;  // points compared, every layer at each
  double max_error = 0.0;  // largest |fast - exact| of a raw channel, of the mass, or of a normalised channel
  double tolerance = 0.0;  // what `fast` had promised
  double tail_bound = 0.0;  // light beyond the search radius, bounded
  double weight = 1.0;  // how much a sum of layers may multiply both: its largest sum of |weights|, 1 or more
  double open_share = 0.0;  // with 95 % confidence, at most this share of the points is worse than max_error

  bool passed() const { return max_error <= tolerance; }
  // The uncertainty of every value of this truth (DESIGN section 1).
  double uncertainty() const { return weight * (max_error + tail_bound); }
};

// Recomputes the points `audited` (indices into `points`) with the exact engine and compares. Of these, the
// first `random_count` are a random sample of all points; they alone carry the statement about the share.
// Normalised values are compared where the mass is at least 0.5: elsewhere they are reported apart anyway.
Certificate audit(const Surface& surface, std::span<const SurfacePoint> points,
                  std::span<const TruthLayer> layers, const TruthValues& values, double tolerance,
                  double tail_bound, std::span<const std::uint32_t> audited, std::size_t random_count);

}  // namespace truescatter
