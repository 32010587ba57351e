#include "metrics/leak.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace truescatter {

LitAlone measure_dark(int component, const Image& exitance, const Image& dark) {
  assert(exitance.pixel_count() == dark.pixel_count());
  LitAlone result;
  result.component = component;
  for (int y = 0; y < dark.height(); ++y) {
    for (int x = 0; x < dark.width(); ++x) {
      if (dark.at(x, y, 0) == 0.0F) continue;
      const double light = std::abs(luminance(exitance.rgb(x, y)));
      ++result.pixels;
      result.dark_light += light;
      result.largest_dark = std::max(result.largest_dark, light);
    }
  }
  return result;
}

Leak total_leak(const std::vector<LitAlone>& surfaces, double largest_irradiance) {
  assert(largest_irradiance > 0.0);
  if (surfaces.empty()) return {kNan, kNan};
  double dark = 0.0;
  double lit = 0.0;
  double largest = 0.0;
  for (const LitAlone& surface : surfaces) {
    dark += surface.dark_light;
    lit += surface.lit_light;
    largest = std::max(largest, surface.largest_dark);
  }
  return {lit > 0.0 ? dark / lit : kNan, largest / largest_irradiance};
}

}  // namespace truescatter
