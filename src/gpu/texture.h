#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"
#include "gpu/context.h"

namespace truescatter::gpu {

enum class Format { r32f, rg32f, rgba32f, rgba16f, rgba32ui, depth32f };
enum class Filter { nearest, linear };

// Bytes that a texel of this format occupies.
int bytes_per_texel(Format format);

// A 2D texture, clamped at its border. Row 0 is the bottom, as OpenGL has it.
class Texture {
 public:
  Texture() = default;
  Texture(const Context& context, int width, int height, Format format, Filter filter = Filter::nearest);
  ~Texture();
  Texture(Texture&& other) noexcept;
  Texture& operator=(Texture&& other) noexcept;

  unsigned id() const { return id_; }
  int width() const { return width_; }
  int height() const { return height_; }
  Format format() const { return format_; }
  bool valid() const { return id_ != 0; }

  // Replaces the contents by an image of as many channels as the format has; flips rows, so that the image's
  // top row is the texture's last.
  void upload(const Image& image);

 private:
  const Context* context_ = nullptr;
  unsigned id_ = 0;
  int width_ = 0;
  int height_ = 0;
  Format format_ = Format::rgba32f;
};

}  // namespace truescatter::gpu
