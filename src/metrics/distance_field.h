#pragma once

#include <cstddef>
#include <vector>

namespace truescatter {

// For every pixel, row by row, the exact squared distance in pixels to the nearest flagged one (between
// centres; infinite if none is flagged), and which one that is.
struct DistanceField {
  std::vector<double> squared_px;
  std::vector<std::size_t> nearest;
};

// In time linear in the pixels: the lower envelope of parabolas along columns, then rows (Felzenszwalb &
// Huttenlocher 2012). `flagged` has width * height entries.
DistanceField distance_to(const std::vector<char>& flagged, int width, int height);

}  // namespace truescatter
