#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gpu/framebuffer.h"
#include "gpu/program.h"

namespace truescatter {

// A texture that is drawn into, with its framebuffer.
struct Target {
  gpu::Texture texture;
  gpu::Texture depth;  // valid where drawing into it tests depths
  gpu::Framebuffer framebuffer;

  Target(const gpu::Context& context, int width, int height, gpu::Format format,
         gpu::Filter filter = gpu::Filter::nearest)
      : texture(context, width, height, format, filter), framebuffer(context, {&texture}) {}

  static Target with_depth(const gpu::Context& context, int width, int height, gpu::Format format) {
    return {gpu::Texture(context, width, height, format),
            gpu::Texture(context, width, height, gpu::Format::depth32f), context};
  }

 private:
  Target(gpu::Texture color, gpu::Texture tested, const gpu::Context& context)
      : texture(std::move(color)), depth(std::move(tested)), framebuffer(context, {&texture}, &depth) {}
};

// A pass's fragment shader: as it is timed, and its variant that counts texture reads.
struct PassProgram {
  gpu::Program plain;
  gpu::Program counting;

  // `fragment`: path below src/methods/. common.glsl comes first.
  PassProgram(const gpu::Context& context, std::string_view fragment,
              const std::vector<std::string>& defines = {});
  // With a vertex shader of its own, for passes that draw geometry.
  PassProgram(const gpu::Context& context, std::string_view vertex, std::string_view fragment,
              const std::vector<std::string>& defines);
  // With pieces of GLSL between common.glsl and the shader proper, which is the last. An empty `vertex` is
  // the full-screen pass's.
  static PassProgram of_pieces(const gpu::Context& context, std::string_view vertex,
                               const std::vector<std::string>& fragment,
                               const std::vector<std::string>& defines = {});
  // The same of texts that are not part of the program, for a full-screen pass.
  static PassProgram of_texts(const gpu::Context& context, const std::vector<gpu::ShaderText>& fragment,
                              const std::vector<std::string>& defines);

 private:
  PassProgram(gpu::Program timed, gpu::Program counted)
      : plain(std::move(timed)), counting(std::move(counted)) {}
};

// A rectangle of pixels of a target; its bottom row is OpenGL's lowest.
struct PixelBox {
  int left = 0;
  int bottom = 0;
  int width = 0;
  int height = 0;
};

// What a texture of a method's own holds at some moment of a frame.
struct NamedTexture {
  std::string name;  // its own within the frame: what is named again gets a number, level, level-2, ...
  std::string
      channels;  // a letter for each of the image's: RGB is light in units of irradiance, others are numbers
  std::string shows;  // in words, units included
  Image image;        // row 0 at the top: the texture's last row
};

// How a method draws: keeps count of its passes and, when asked to, of its texture reads.
class Passes {
 public:
  explicit Passes(const gpu::Context& context) : context_(context), full_screen_(context) {}

  using SetUniforms = std::function<void(const gpu::Program&)>;

  // A full-screen pass into `target`; `add` blends onto what is there instead of replacing it. Pixels outside
  // `within` (null: none) are left as they are.
  void draw(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms,
            bool add = false, const PixelBox* within = nullptr);
  // The same with the caller's geometry, into a cleared target.
  void draw_geometry(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms,
                     const std::function<void()>& geometry);

  const gpu::Context& context() const { return context_; }

  struct Counts {
    int passes = 0;
    double texels_read = 0.0;
    double bytes_read = 0.0;
  };
  // Counts what `work` does; runs it with the counting shaders.
  Counts count(const std::function<void()>& work);

  // Names what a texture holds now, before it is drawn over. Only while recording anything comes of it: timed
  // and counted frames read nothing back. `name`: letters, digits and '-', as it becomes part of a file's
  // name.
  void show(const gpu::Texture& texture, const std::string& name, std::string_view channels,
            std::string_view shows);
  // Whether what is shown is taken: what is drawn only to be shown is drawn then alone.
  bool recording() const { return static_cast<bool>(take_); }
  // Hands what `work` names on to `take`, one texture after the other, as each is drawn.
  using Take = std::function<void(const NamedTexture&)>;
  void record(const std::function<void()>& work, const Take& take);

 private:
  void run(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms, bool add,
           bool clear, const std::function<void()>& geometry);

  const gpu::Context& context_;
  gpu::FullScreen full_screen_;
  bool counting_ = false;
  Counts counts_;
  Take take_;                         // while recording
  std::map<std::string, int> shown_;  // how often each name was given
};

}  // namespace truescatter
