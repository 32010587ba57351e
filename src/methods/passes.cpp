#include "methods/passes.h"

#include <fmt/format.h>

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

gpu::Program build(const gpu::Context& context, const gpu::ShaderText& vertex,
                   const std::vector<gpu::ShaderText>& fragment, std::vector<std::string> defines,
                   bool counting) {
  if (counting) defines.emplace_back("INSTRUMENT");
  std::vector<gpu::ShaderText> pieces = {methods::shader_file("common.glsl")};
  pieces.insert(pieces.end(), fragment.begin(), fragment.end());
  return {context, {vertex}, pieces, defines};
}

}  // namespace

PassProgram PassProgram::of_pieces(const gpu::Context& context, std::string_view vertex,
                                   const std::vector<std::string>& fragment,
                                   const std::vector<std::string>& defines) {
  const gpu::ShaderText first =
      vertex.empty() ? gpu::FullScreen::vertex_shader() : methods::shader_file(vertex);
  std::vector<gpu::ShaderText> pieces;
  for (const std::string& piece : fragment) pieces.push_back(methods::shader_file(piece));
  return {build(context, first, pieces, defines, false), build(context, first, pieces, defines, true)};
}

PassProgram PassProgram::of_texts(const gpu::Context& context, const std::vector<gpu::ShaderText>& fragment,
                                  const std::vector<std::string>& defines) {
  const gpu::ShaderText vertex = gpu::FullScreen::vertex_shader();
  return {build(context, vertex, fragment, defines, false), build(context, vertex, fragment, defines, true)};
}

PassProgram::PassProgram(const gpu::Context& context, std::string_view fragment,
                         const std::vector<std::string>& defines)
    : PassProgram(of_pieces(context, {}, {std::string(fragment)}, defines)) {}

PassProgram::PassProgram(const gpu::Context& context, std::string_view vertex, std::string_view fragment,
                         const std::vector<std::string>& defines)
    : PassProgram(of_pieces(context, vertex, {std::string(fragment)}, defines)) {}

void Passes::draw(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms, bool add,
                  const PixelBox* within) {
  const gpu::GlFunctions& gl = context_.gl();
  run(program, target, set_uniforms, add, false, [&] {
    if (within != nullptr) {
      gl.Enable(GL_SCISSOR_TEST);
      gl.Scissor(within->left, within->bottom, within->width, within->height);
    }
    full_screen_.draw();
    if (within != nullptr) gl.Disable(GL_SCISSOR_TEST);
  });
}

void Passes::draw_geometry(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms,
                           const std::function<void()>& geometry) {
  run(program, target, set_uniforms, false, true, geometry);
}

void Passes::run(const PassProgram& program, const Target& target, const SetUniforms& set_uniforms, bool add,
                 bool clear, const std::function<void()>& geometry) {
  const gpu::GlFunctions& gl = context_.gl();
  ++counts_.passes;
  if (target.depth.valid()) gl.Enable(GL_DEPTH_TEST);
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
    const gpu::Texture depth =
        target.depth.valid()
            ? gpu::Texture(context_, target.texture.width(), target.texture.height(), gpu::Format::depth32f)
            : gpu::Texture();
    const gpu::Framebuffer framebuffer(context_, {&scratch, &counts}, depth.valid() ? &depth : nullptr);
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
  if (target.depth.valid()) gl.Disable(GL_DEPTH_TEST);
}

Passes::Counts Passes::count(const std::function<void()>& work) {
  counts_ = {};
  counting_ = true;
  work();
  counting_ = false;
  context_.check("counting texture reads");
  return counts_;
}

void Passes::show(const gpu::Texture& texture, const std::string& name, std::string_view channels,
                  std::string_view shows) {
  if (!take_) return;
  const int times = ++shown_[name];
  take_({times == 1 ? name : fmt::format("{}-{}", name, times), std::string(channels), std::string(shows),
         gpu::read_texture(context_, texture, static_cast<int>(channels.size()))});
}

void Passes::record(const std::function<void()>& work, const Take& take) {
  take_ = take;
  shown_.clear();
  work();
  take_ = {};
  context_.check("recording a method's textures");
}

}  // namespace truescatter
