#pragma once

#include <cassert>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// The one image type: 32-bit float, channels interleaved, row 0 at the top, values linear.
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels, float value = 0.0F);

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  bool empty() const { return data_.empty(); }
  std::size_t pixel_count() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }

  float& at(int x, int y, int c) { return data_[index(x, y, c)]; }
  float at(int x, int y, int c) const { return data_[index(x, y, c)]; }
  // The pixel's first three channels.
  Vec3d rgb(int x, int y) const { return {at(x, y, 0), at(x, y, 1), at(x, y, 2)}; }
  void set_rgb(int x, int y, const Vec3d& value);

  std::span<float> data() & { return data_; }
  std::span<const float> data() const& { return data_; }
  void data() && = delete;  // the span would outlive the image
  void data() const&& = delete;

 private:
  std::size_t index(int x, int y, int c) const {
    assert(x >= 0 && x < width_ && y >= 0 && y < height_ && c >= 0 && c < channels_);
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels_) +
           static_cast<std::size_t>(c);
  }

  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<float> data_;
};

// Linear value in [0, 1] to its sRGB-encoded value in [0, 1] (IEC 61966-2-1); clamps outside.
double srgb_encode(double linear);
// The inverse.
double srgb_decode(double encoded);

}  // namespace truescatter
