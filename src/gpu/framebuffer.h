#pragma once

#include <cstdint>
#include <initializer_list>
#include <vector>

#include "gpu/texture.h"

namespace truescatter::gpu {

// A framebuffer that draws into textures of one size: colour attachments in order, and a depth texture
// (or null). The textures must outlive it.
class Framebuffer {
 public:
  Framebuffer() = default;
  Framebuffer(const Context& context, std::vector<const Texture*> colors, const Texture* depth = nullptr);
  ~Framebuffer();
  Framebuffer(Framebuffer&& other) noexcept;
  Framebuffer& operator=(Framebuffer&& other) noexcept;

  // Makes it the target of drawing, with the viewport on all of it.
  void bind() const;
  // Sets every float attachment to 0, every integer attachment to 0, depth to 1.
  void clear() const;

  // The first `channels` channels of a float attachment, row 0 at the top.
  Image read(int attachment, int channels) const;
  // All four channels of an unsigned-integer attachment, row 0 at the top: 4 values a pixel.
  std::vector<std::uint32_t> read_uint(int attachment) const;

 private:
  const Context* context_ = nullptr;
  unsigned id_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<Format> formats_;
  bool has_depth_ = false;
};

// The first `channels` channels of a texture, row 0 at the top.
Image read_texture(const Context& context, const Texture& texture, int channels);

}  // namespace truescatter::gpu
