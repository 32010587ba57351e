#include "gpu/texture.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace truescatter::gpu {
namespace {

struct FormatInfo {
  GLint internal;
  GLenum format;
  GLenum type;
  int channels;
  int bytes;
};

FormatInfo info(Format format) {
  switch (format) {
    case Format::r32f:
      return {GL_R32F, GL_RED, GL_FLOAT, 1, 4};
    case Format::rg32f:
      return {GL_RG32F, GL_RG, GL_FLOAT, 2, 8};
    case Format::rgba32f:
      return {GL_RGBA32F, GL_RGBA, GL_FLOAT, 4, 16};
    case Format::rgba16f:
      return {GL_RGBA16F, GL_RGBA, GL_FLOAT, 4, 8};
    case Format::rgba32ui:
      return {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 4, 16};
    case Format::depth32f:
      return {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 1, 4};
  }
  assert(false);
  return {};
}

}  // namespace

int bytes_per_texel(Format format) { return info(format).bytes; }

Texture::Texture(const Context& context, int width, int height, Format format, Filter filter)
    : context_(&context), width_(width), height_(height), format_(format) {
  const GlFunctions& gl = context.gl();
  const FormatInfo f = info(format);
  gl.GenTextures(1, &id_);
  gl.BindTexture(GL_TEXTURE_2D, id_);
  const GLint mode = filter == Filter::linear ? GL_LINEAR : GL_NEAREST;
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, mode);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, mode);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TexImage2D(GL_TEXTURE_2D, 0, f.internal, width, height, 0, f.format, f.type, nullptr);
  context.check("creating a texture");
}

Texture::~Texture() {
  if (id_ != 0) context_->gl().DeleteTextures(1, &id_);
}

Texture::Texture(Texture&& other) noexcept { *this = std::move(other); }

Texture& Texture::operator=(Texture&& other) noexcept {
  std::swap(context_, other.context_);
  std::swap(id_, other.id_);
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
  std::swap(format_, other.format_);
  return *this;
}

void Texture::upload(const Image& image) {
  const FormatInfo f = info(format_);
  assert(f.type == GL_FLOAT && image.width() == width_ && image.height() == height_ &&
         image.channels() == f.channels);
  std::vector<float> rows(image.data().size());
  const std::size_t row = static_cast<std::size_t>(width_) * static_cast<std::size_t>(f.channels);
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y) {
    std::copy_n(
        image.data().begin() + static_cast<std::ptrdiff_t>(y * row), row,
        rows.begin() + static_cast<std::ptrdiff_t>((static_cast<std::size_t>(height_) - 1 - y) * row));
  }
  const GlFunctions& gl = context_->gl();
  gl.BindTexture(GL_TEXTURE_2D, id_);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage2D(GL_TEXTURE_2D, 0, f.internal, width_, height_, 0, f.format, f.type, rows.data());
  context_->check("filling a texture");
}

}  // namespace truescatter::gpu
