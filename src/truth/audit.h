#pragma once

#include <cstdint>
#include <span>

#include "truth/surface.h"

namespace truescatter {

// Pixels with less than this of the mass that a kernel has on a plane are counted apart (README,
// Definitions).
inline constexpr double kSmallMass = 0.5;

// What an audit of a fast engine against the exact one found, in units of the scene's largest irradiance.
struct Certificate {
  std::size_t audited = 0;  // points compared, every layer at each
  double max_error = 0.0;  // largest |fast - exact| of a raw channel, of the mass, or of a normalised channel
                           // times the plane's mass
  double tolerance = 0.0;  // what `fast` had promised
  double tail_bound = 0.0;  // light beyond the search radius, bounded
  double weight = 1.0;  // how much a sum of layers may multiply both: its largest sum of |weights|, 1 or more
  double approximation = 0.0;  // how far the sum may be from the profile that it stands for
  double open_share = 0.0;  // with 95 % confidence, at most this share of the points is worse than max_error

  bool passed() const { return max_error <= tolerance; }
  // The uncertainty of every value of this truth (README, Definitions).
  double uncertainty() const { return weight * (max_error + tail_bound) + approximation; }
};

// What the fast engine promised and what was drawn.
struct AuditTerms {
  double tolerance = 0.0;
  double tail_bound = 0.0;
  double largest_irradiance = 1.0;
  std::size_t random_count = 0;  // the first points of the audited ones are a random sample of all points;
                                 // they alone carry the statement about the share
  double plane_mass = 1.0;       // the layer's mass on a plane: below 1 where its kernel is cut
};

// How many standard deviations the exact engine need reach in an audit: beyond lies at most a hundredth of
// the tolerance of a plane's mass, and never more than the 1.5e-8 of 6, at half the cost of going to
// rounding.
double audit_reach_std_devs(double tolerance);

// Compares one layer of the fast engine, `values` of every point, with the exact engine's values of the
// points `audited` (indices into `values`). Normalised values are compared where the mass is at least
// kSmallMass of the plane's: elsewhere they are reported apart anyway. They are compared in units of raw ones
// (times the plane's mass), in which they are known equally well. A value that is not finite is infinitely
// wrong.
Certificate audit(std::span<const Vec4d> values, std::span<const Vec4d> exact,
                  std::span<const std::uint32_t> audited, const AuditTerms& terms);

}  // namespace truescatter
