#pragma once

#include "core/image.h"
#include "core/vec.h"

namespace truescatter {

// An image over UV, repeated beyond [0, 1]; v up, so that v = 1 is the image's row 0.
class UvTexture {
 public:
  UvTexture() = default;
  // Not empty.
  explicit UvTexture(Image image);

  bool empty() const { return image_.empty(); }
  int channels() const { return image_.channels(); }
  // Bilinear reading: a texel's value stands at its centre.
  double value(const Vec2d& uv, int channel) const;
  // The first three channels, which there must be.
  Vec3d rgb(const Vec2d& uv) const { return {value(uv, 0), value(uv, 1), value(uv, 2)}; }

 private:
  Image image_;
};

}  // namespace truescatter
