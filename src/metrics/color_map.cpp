#include "metrics/color_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace truescatter {
namespace {

Vec3d interpolate(std::span<const std::array<double, 3>> stops, double value) {
  const double at = std::clamp(value, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  const double f = at - static_cast<double>(i);
  Vec3d color;
  for (std::size_t c = 0; c < 3; ++c) {
    color[static_cast<Eigen::Index>(c)] = (1.0 - f) * stops[i][c] + f * stops[i + 1][c];
  }
  return color;
}

// Nine stops along matplotlib's "inferno" (van der Walt & Smith, CC0).
constexpr std::array<std::array<double, 3>, 9> kInferno = {{{0.001, 0.000, 0.014},
                                                            {0.122, 0.047, 0.283},
                                                            {0.342, 0.062, 0.429},
                                                            {0.550, 0.134, 0.413},
                                                            {0.736, 0.216, 0.330},
                                                            {0.888, 0.341, 0.202},
                                                            {0.968, 0.528, 0.047},
                                                            {0.976, 0.755, 0.154},
                                                            {0.988, 0.998, 0.645}}};

constexpr std::array<std::array<double, 3>, 5> kTooBright = {
    {{0.07, 0.07, 0.08}, {0.42, 0.10, 0.08}, {0.80, 0.22, 0.10}, {0.98, 0.52, 0.25}, {1.00, 0.87, 0.62}}};
constexpr std::array<std::array<double, 3>, 5> kTooDark = {
    {{0.07, 0.07, 0.08}, {0.06, 0.20, 0.48}, {0.11, 0.415, 0.86}, {0.33, 0.665, 0.97}, {0.72, 0.915, 1.00}}};

}  // namespace

Vec3d magnitude_color(double value) { return interpolate(kInferno, value); }

Vec3d signed_color(double value) {
  return value >= 0.0 ? interpolate(kTooBright, value) : interpolate(kTooDark, -value);
}

}  // namespace truescatter
