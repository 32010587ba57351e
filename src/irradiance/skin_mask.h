#pragma once

#include <utility>

#include "scene/uv_texture.h"

namespace truescatter {

// Which part of the surface is skin: a texture in UV, white on skin. Without an image all is skin.
class SkinMask {
 public:
  SkinMask() = default;
  // The image's first channel; values of 0.5 and more are skin. Not empty.
  explicit SkinMask(Image image) : texture_(std::move(image)) {}

  bool everywhere() const { return texture_.empty(); }
  bool is_skin(const Vec2d& uv) const { return everywhere() || texture_.value(uv, 0) >= 0.5; }

 private:
  UvTexture texture_;
};

}  // namespace truescatter
