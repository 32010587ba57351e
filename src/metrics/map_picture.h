#pragma once

#include <string>

#include "core/image.h"

namespace truescatter {

enum class MapKind { magnitude, signed_error };

// A map's luminance as a picture (sRGB-encoded RGB), with a colour bar below that says its range:
// [0, range] or [-range, range]. Pixels outside the mask are grey. `map` holds signed RGB errors.
Image map_picture(const Image& map, const Image& mask, MapKind kind, double range, const std::string& title);

// Where in an error map's picture the coloured part of its bar lies, from the picture's upper left; no
// columns where the map is too narrow for one.
struct ColorBar {
  int left_px;
  int top_px;
  int width_px;
  int height_px;
};
ColorBar color_bar(int map_width_px, int map_height_px);

// A linear RGB picture for the eye: exposed by `exposure`, sRGB-encoded, clipped. Same for every method.
Image display_picture(const Image& rgb, double exposure);

// The smallest of 1, 2, 5 times a power of ten that is at least `value` (> 0).
double round_range(double value);

}  // namespace truescatter
