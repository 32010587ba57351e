#include "gpu/framebuffer.h"

#include <array>
#include <cassert>
#include <utility>

#include "core/error.h"

namespace truescatter::gpu {

Framebuffer::Framebuffer(const Context& context, std::vector<const Texture*> colors, const Texture* depth)
    : context_(&context),
      width_(colors.front()->width()),
      height_(colors.front()->height()),
      has_depth_(depth != nullptr) {
  const GlFunctions& gl = context.gl();
  gl.GenFramebuffers(1, &id_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, id_);
  std::vector<GLenum> buffers;
  for (const Texture* color : colors) {
    assert(color->width() == width_ && color->height() == height_);
    const GLenum attachment = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(buffers.size());
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, color->id(), 0);
    buffers.push_back(attachment);
    formats_.push_back(color->format());
  }
  if (depth != nullptr) {
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth->id(), 0);
  }
  gl.DrawBuffers(static_cast<GLsizei>(buffers.size()), buffers.data());
  const GLenum status = gl.CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) throw_run_error("OpenGL: incomplete framebuffer (0x{:04X})", status);
}

Framebuffer::~Framebuffer() {
  if (id_ != 0) context_->gl().DeleteFramebuffers(1, &id_);
}

Framebuffer::Framebuffer(Framebuffer&& other) noexcept { *this = std::move(other); }

Framebuffer& Framebuffer::operator=(Framebuffer&& other) noexcept {
  std::swap(context_, other.context_);
  std::swap(id_, other.id_);
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
  std::swap(formats_, other.formats_);
  std::swap(has_depth_, other.has_depth_);
  return *this;
}

void Framebuffer::bind() const {
  context_->gl().BindFramebuffer(GL_FRAMEBUFFER, id_);
  context_->gl().Viewport(0, 0, width_, height_);
}

void Framebuffer::clear() const {
  static constexpr std::array<float, 4> kZero = {};
  static constexpr std::array<unsigned, 4> kZeroUint = {};
  bind();
  for (std::size_t i = 0; i < formats_.size(); ++i) {
    if (formats_[i] == Format::rgba32ui) {
      context_->gl().ClearBufferuiv(GL_COLOR, static_cast<GLint>(i), kZeroUint.data());
    } else {
      context_->gl().ClearBufferfv(GL_COLOR, static_cast<GLint>(i), kZero.data());
    }
  }
  const float far = 1.0F;
  if (has_depth_) context_->gl().ClearBufferfv(GL_DEPTH, 0, &far);
}

Image Framebuffer::read(int attachment, int channels) const {
  assert(channels >= 1 && channels <= 4);
  const GlFunctions& gl = context_->gl();
  gl.BindFramebuffer(GL_FRAMEBUFFER, id_);
  gl.ReadBuffer(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachment));
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  Image rgba(width_, height_, 4);
  gl.ReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, rgba.data().data());
  context_->check("reading a framebuffer");
  Image image(width_, height_, channels);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      for (int c = 0; c < channels; ++c) image.at(x, height_ - 1 - y, c) = rgba.at(x, y, c);
    }
  }
  return image;
}

std::vector<std::uint32_t> Framebuffer::read_uint(int attachment) const {
  const GlFunctions& gl = context_->gl();
  gl.BindFramebuffer(GL_FRAMEBUFFER, id_);
  gl.ReadBuffer(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachment));
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  const std::size_t row = 4 * static_cast<std::size_t>(width_);
  std::vector<std::uint32_t> bottom_up(row * static_cast<std::size_t>(height_));
  gl.ReadPixels(0, 0, width_, height_, GL_RGBA_INTEGER, GL_UNSIGNED_INT, bottom_up.data());
  context_->check("reading an integer framebuffer");
  std::vector<std::uint32_t> values;
  values.reserve(bottom_up.size());
  for (std::size_t y = static_cast<std::size_t>(height_); y-- > 0;) {
    values.insert(values.end(), bottom_up.begin() + static_cast<std::ptrdiff_t>(y * row),
                  bottom_up.begin() + static_cast<std::ptrdiff_t>((y + 1) * row));
  }
  return values;
}

Image read_texture(const Context& context, const Texture& texture, int channels) {
  return Framebuffer(context, {&texture}).read(0, channels);
}

}  // namespace truescatter::gpu
