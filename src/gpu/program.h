#pragma once

#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/vec.h"
#include "gpu/texture.h"

namespace truescatter::gpu {

// One piece of GLSL and the name that the compiler's messages carry for it.
struct ShaderText {
  std::string name;
  std::string text;
};

// A uniform that a program uses.
struct Uniform {
  std::string name;  // of an array: without its "[0]"
  unsigned type;     // GL_FLOAT, GL_SAMPLER_2D, ...
  int size;          // elements of an array; 1 for others
};

// A linked vertex and fragment shader. Each stage is "#version 450 core", then a #define for every entry of
// `defines`, then its pieces in order. Throws Error (input) that names the piece and line and quotes
// the compiler.
class Program {
 public:
  Program() = default;
  Program(const Context& context, const std::vector<ShaderText>& vertex,
          const std::vector<ShaderText>& fragment, const std::vector<std::string>& defines = {});
  ~Program();
  Program(Program&& other) noexcept;
  Program& operator=(Program&& other) noexcept;

  void use() const;

  // What the compiler left of its uniforms.
  std::vector<Uniform> active_uniforms() const;

  // Uniforms of the program, which must be in use. A name that the compiler removed is ignored.
  void set(const char* name, int value) const;
  void set(const char* name, float value) const;
  void set(const char* name, double value) const { set(name, static_cast<float>(value)); }
  void set(const char* name, const Vec2d& value) const;
  void set(const char* name, const Vec3d& value) const;
  void set(const char* name, const Mat4d& value) const;
  void set(const char* name, std::span<const float> values) const;
  void set(const char* name, std::span<const Vec3f> values) const;
  // Binds a texture to a unit and the sampler to that unit. Where the program has a float
  // "<name>_texel_bytes", it becomes the size of the texture's texels.
  void set(const char* name, const Texture& texture, int unit) const;

 private:
  int location(const char* name) const;

  const Context* context_ = nullptr;
  unsigned id_ = 0;
};

// A triangle that covers the whole viewport: the geometry of every full-screen pass.
class FullScreen {
 public:
  explicit FullScreen(const Context& context);
  ~FullScreen();
  FullScreen(const FullScreen&) = delete;
  FullScreen& operator=(const FullScreen&) = delete;

  void draw() const;
  // Its vertex shader; gives `vec2 uv` in [0, 1].
  static ShaderText vertex_shader();

 private:
  const Context& context_;
  unsigned vertex_array_ = 0;
};

}  // namespace truescatter::gpu
