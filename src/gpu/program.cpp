#include "gpu/program.h"

#include <cstdlib>
#include <utility>

#include "core/error.h"

namespace truescatter::gpu {
namespace {

// A compiled stage; deleted once the program is linked.
class Shader {
 public:
  Shader(const Context& context, GLenum stage, const std::vector<ShaderText>& pieces,
         const std::vector<std::string>& defines)
      : context_(context), id_(context.gl().CreateShader(stage)) {
    // "#line 1 k" makes the compiler's messages say piece k, line within the piece.
    std::string source = "#version 450 core\n";
    for (const std::string& define : defines) source += "#define " + define + "\n";
    for (std::size_t k = 0; k < pieces.size(); ++k)
      source += fmt::format("#line 1 {}\n{}\n", k, pieces[k].text);
    const char* text = source.c_str();
    context.gl().ShaderSource(id_, 1, &text, nullptr);
    context.gl().CompileShader(id_);
    GLint compiled = 0;
    context.gl().GetShaderiv(id_, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return;
    std::string log(8192, '\0');
    GLsizei length = 0;
    context.gl().GetShaderInfoLog(id_, static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    context.gl().DeleteShader(id_);
    throw Error(ErrorKind::input, locate(log, pieces), "this shader does not compile: " + log);
  }
  ~Shader() { context_.gl().DeleteShader(id_); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;

  unsigned id() const { return id_; }

 private:
  // Mesa writes "piece:line(column): error: ...".
  static SourceLocation locate(const std::string& log, const std::vector<ShaderText>& pieces) {
    char* end = nullptr;
    const unsigned long piece = std::strtoul(log.c_str(), &end, 10);
    if (end == log.c_str() || *end != ':' || piece >= pieces.size()) return {pieces.back().name};
    const int line = static_cast<int>(std::strtol(end + 1, &end, 10));
    const int column = *end == '(' ? static_cast<int>(std::strtol(end + 1, nullptr, 10)) : 0;
    return {pieces[piece].name, line, column};
  }

  const Context& context_;
  unsigned id_;
};

}  // namespace

Program::Program(const Context& context, const std::vector<ShaderText>& vertex,
                 const std::vector<ShaderText>& fragment, const std::vector<std::string>& defines)
    : context_(&context) {
  const GlFunctions& gl = context.gl();
  const Shader vertex_shader(context, GL_VERTEX_SHADER, vertex, defines);
  const Shader fragment_shader(context, GL_FRAGMENT_SHADER, fragment, defines);
  id_ = gl.CreateProgram();
  gl.AttachShader(id_, vertex_shader.id());
  gl.AttachShader(id_, fragment_shader.id());
  gl.LinkProgram(id_);
  GLint linked = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return;
  std::string log(8192, '\0');
  GLsizei length = 0;
  gl.GetProgramInfoLog(id_, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  gl.DeleteProgram(id_);
  id_ = 0;
  throw Error(ErrorKind::input, {fragment.back().name}, "this shader does not link: " + log);
}

Program::~Program() {
  if (id_ != 0) context_->gl().DeleteProgram(id_);
}

Program::Program(Program&& other) noexcept { *this = std::move(other); }

Program& Program::operator=(Program&& other) noexcept {
  std::swap(context_, other.context_);
  std::swap(id_, other.id_);
  return *this;
}

void Program::use() const { context_->gl().UseProgram(id_); }

int Program::location(const char* name) const { return context_->gl().GetUniformLocation(id_, name); }

void Program::set(const char* name, int value) const { context_->gl().Uniform1i(location(name), value); }

void Program::set(const char* name, float value) const { context_->gl().Uniform1f(location(name), value); }

void Program::set(const char* name, const Vec2d& value) const {
  context_->gl().Uniform2f(location(name), static_cast<float>(value.x()), static_cast<float>(value.y()));
}

void Program::set(const char* name, const Vec3d& value) const {
  const Vec3f v = value.cast<float>();
  context_->gl().Uniform3f(location(name), v.x(), v.y(), v.z());
}

void Program::set(const char* name, const Mat4d& value) const {
  const Eigen::Matrix4f m = value.cast<float>();
  context_->gl().UniformMatrix4fv(location(name), 1, GL_FALSE, m.data());
}

void Program::set(const char* name, std::span<const float> values) const {
  context_->gl().Uniform1fv(location(name), static_cast<GLsizei>(values.size()), values.data());
}

void Program::set(const char* name, std::span<const Vec3f> values) const {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  context_->gl().Uniform3fv(location(name), static_cast<GLsizei>(values.size()), values.front().data());
}

void Program::set(const char* name, const Texture& texture, int unit) const {
  context_->gl().ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  context_->gl().BindTexture(GL_TEXTURE_2D, texture.id());
  set(name, unit);
  set((std::string(name) + "_texel_bytes").c_str(), static_cast<float>(bytes_per_texel(texture.format())));
}

FullScreen::FullScreen(const Context& context) : context_(context) {
  context.gl().GenVertexArrays(1, &vertex_array_);
}

FullScreen::~FullScreen() { context_.gl().DeleteVertexArrays(1, &vertex_array_); }

void FullScreen::draw() const {
  context_.gl().Disable(GL_DEPTH_TEST);
  context_.gl().BindVertexArray(vertex_array_);
  context_.gl().DrawArrays(GL_TRIANGLES, 0, 3);
}

ShaderText FullScreen::vertex_shader() {
  return {"gpu/full_screen.vert",
          "out vec2 uv;\n"
          "void main() {\n"
          "  uv = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);\n"
          "  gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);\n"
          "}\n"};
}

}  // namespace truescatter::gpu
