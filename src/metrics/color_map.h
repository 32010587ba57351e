#pragma once

#include "core/vec.h"

namespace truescatter {

// Colours of error maps, sRGB-encoded in [0, 1].

// For |error| / range in [0, 1]: black over purple and orange to pale yellow, of monotone lightness.
Vec3d magnitude_color(double value);

// For error / range in [-1, 1]: blue (too dark) over near-black to red-orange (too bright). Zero is dark, so
// that small errors do not drown in a bright field; both sides have the same lightness.
Vec3d signed_color(double value);

}  // namespace truescatter
