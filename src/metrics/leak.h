#pragma once

#include <cstddef>
#include <vector>

#include "core/image.h"

namespace truescatter {

// Light that crosses from one surface to another, measured with all surfaces dark but one. The truth of a
// dark surface is 0 exactly: light comes from its own connected piece of skin alone.
struct LitAlone {
  int component = 0;          // the lit surface
  std::size_t pixels = 0;     // of the dark surfaces
  double dark_light = 0.0;    // sum over them of |luminance| of the method's picture
  double largest_dark = 0.0;  // the largest of these
  double lit_light = 0.0;     // sum of the truth's luminance over the lit surface's measured pixels
};

// `exitance`: a method's, with one surface lit. `dark`: 1 on skin of the others. Sets what is known of these.
LitAlone measure_dark(int component, const Image& exitance, const Image& dark);

struct Leak {
  double energy = 0.0;  // sum over the lit surfaces of dark_light / sum of lit_light; NaN where that is 0
  double peak = 0.0;    // largest_dark of the worst / largest irradiance
};

// Over all surfaces, each lit once. NaN without one.
Leak total_leak(const std::vector<LitAlone>& surfaces, double largest_irradiance);

}  // namespace truescatter
