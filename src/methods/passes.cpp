#include "methods/passes.h"

#include "methods/shader_files.h"

namespace truescatter {

// Defined by the build from the module's GLSL files.
namespace methods {
std::string embedded(std::string_view path);

gpu::ShaderText shader_file(std::string_view path) {
  const std::string name = "methods/" + std::string(path);
  std::string text = embedded(name);
  assert(!text.empty());
  return {"src/" + name, std::move(text)};
}
}  // namespace methods

namespace {

gpu::Program build(const gpu::Context& context, const gpu::ShaderText& vertex, std::string_view fragment,
                   std::vector<std::string> defines, bool counting) {
  if (counting) defines.emplace_back("INSTRUMENT");
  return {context, {vertex}, {methods::shader_file("common.glsl"), methods::shader_file(fragment)}, defines};
}

}  // namespace

PassProgram::PassProgram(const gpu::Context& context, std::string_view fragment,
                         const std::vector<std::string>& defines)
    : plain(build(context, gpu::FullScreen::vertex_shader(), fragment, defines, false)),
      counting(build(context, gpu::FullScreen::vertex_shader(), fragment, defines, true)) {}

PassProgram::PassProgram(const gpu::Context& context, std::string_view vertex, std::string_view fragment,
                         const std::vector<std::string>& defines)
    : plain(build(context, methods::shader_file(vertex), fragment, defines, false)),
      counting(build(context, methods::shader_file(vertex), fragment, defines, true)) {}

void Passes::draw(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms,
                  bool add) {
  run(program, target, set_uniforms, add, false, [&] { full_screen_.draw(); });
}

void Passes::draw_geometry(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms,
                           const std::function<void()>& geometry) {
  run(program, target, set_uniforms, false, true, geometry);
}

void Passes::run(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms, bool add,
                 bool clear, const std::function<void()>& geometry) {
  const gpu::GlFunctions& gl = context_.gl();
  ++counts_.passes;
  const auto submit = [&](const gpu::Program& used, const gpu::Framebuffer& framebuffer) {
    if (clear) framebuffer.clear();
    framebuffer.bind();
    used.use();
    set_uniforms(used);
    geometry();
  };
  if (counting_) {
    // Counts go to a texture of their own; drawn without blending, for a blended result plays no part here.
    const gpu::Texture scratch(context_, target.texture.width(), target.texture.height(),
                               target.texture.format());
    const gpu::Texture counts(context_, target.texture.width(), target.texture.height(),
                              gpu::Format::rgba32f);
    const gpu::Framebuffer framebuffer(context_, {&scratch, &counts});
    framebuffer.clear();
    submit(program.counting, framebuffer);
    const Image image = framebuffer.read(1, 2);
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        counts_.texels_read += static_cast<double>(image.at(x, y, 0));
        counts_.bytes_read += static_cast<double>(image.at(x, y, 1));
      }
    }
  }
  if (add) {
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE);
  }
  submit(program.plain, target.framebuffer);
  if (add) gl.Disable(GL_BLEND);
}

Passes::Counts Passes::count(const std::function<void()>& work) {
  counts_ = {};
  counting_ = true;
  work();
  counting_ = false;
  context_.check("counting texture reads");
  return counts_;
}

}  // namespace truescatter
