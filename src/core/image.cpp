#include "core/image.h"

#include <algorithm>
#include <cmath>

namespace truescatter {

Image::Image(int width, int height, int channels, float value)
    : width_(width),
      height_(height),
      channels_(channels),
      data_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                static_cast<std::size_t>(channels),
            value) {
  assert(width >= 0 && height >= 0 && channels >= 0);
}

void Image::set_rgb(int x, int y, const Vec3d& value) {
  for (int c = 0; c < 3; ++c) at(x, y, c) = static_cast<float>(value[c]);
}

double srgb_encode(double linear) {
  const double v = std::clamp(linear, 0.0, 1.0);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
}

double srgb_decode(double encoded) {
  const double v = std::clamp(encoded, 0.0, 1.0);
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

}  // namespace truescatter
