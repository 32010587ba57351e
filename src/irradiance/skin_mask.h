#pragma once

#include "core/image.h"
#include "core/vec.h"

namespace truescatter {

// Which part of the surface is skin: a texture in UV, white on skin. Without an image all is skin.
class SkinMask {
 public:
  SkinMask() = default;
  // The image's first channel, v up; values of 0.5 and more are skin. Not empty.
  explicit SkinMask(Image image);

  bool everywhere() const { return image_.empty(); }
  // Bilinear reading at texel centres, repeated beyond [0, 1].
  double value(const Vec2d& uv) const;
  bool is_skin(const Vec2d& uv) const { return everywhere() || value(uv) >= 0.5; }

 private:
  Image image_;
};

}  // namespace truescatter
