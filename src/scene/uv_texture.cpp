#include "scene/uv_texture.h"

#include <cmath>
#include <utility>

namespace truescatter {

UvTexture::UvTexture(Image image) : image_(std::move(image)) { assert(!image_.empty()); }

double UvTexture::value(const Vec2d& uv, int channel) const {
  const int width = image_.width();
  const int height = image_.height();
  const double x = uv.x() * width - 0.5;
  const double y = (1.0 - uv.y()) * height - 0.5;  // row 0 is the top, v is up
  const double x0 = std::floor(x);
  const double y0 = std::floor(y);
  const auto texel = [&](double column, double row) {
    const auto wrap = [](double i, int n) { return static_cast<int>(i - n * std::floor(i / n)); };
    return static_cast<double>(image_.at(wrap(column, width), wrap(row, height), channel));
  };
  const double fx = x - x0;
  const double fy = y - y0;
  return (1.0 - fy) * ((1.0 - fx) * texel(x0, y0) + fx * texel(x0 + 1.0, y0)) +
         fy * ((1.0 - fx) * texel(x0, y0 + 1.0) + fx * texel(x0 + 1.0, y0 + 1.0));
}

}  // namespace truescatter
