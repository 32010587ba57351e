#include "gpu/program.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <sstream>
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
    std::string source = "#version 450 core\n";
    for (const std::string& define : defines) source += "#define " + define + "\n";
    for (std::size_t k = 0; k < pieces.size(); ++k)
      source += fmt::format("#line {}\n{}\n", k * kLinesPerPiece + 1, pieces[k].text);
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
    throw Error(ErrorKind::input, locate(log, pieces),
                "this shader does not compile:\n" + with_names(log, pieces));
  }
  ~Shader() { context_.gl().DeleteShader(id_); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;

  unsigned id() const { return id_; }

 private:
  // A compiler's messages give lines of what it was given as one text: Mesa has "#line" change the line but
  // not the source's number. So the line says the piece too. (Columns are those of the preprocessed text.)
  static constexpr std::size_t kLinesPerPiece = 100000;

  // A place at the beginning of a compiler's message: Mesa writes "0:line(column): error: ...", others
  // "0(line) : error ...". `end`: where the rest of the message begins.
  static std::optional<SourceLocation> place(const char* message, const std::vector<ShaderText>& pieces,
                                             const char*& end) {
    char* after = nullptr;
    std::strtoul(message, &after, 10);
    if (after == message || (*after != ':' && *after != '(')) return std::nullopt;
    const bool mesa = *after == ':';
    const char* digits = after + 1;
    const unsigned long line = std::strtoul(digits, &after, 10);
    const std::size_t piece = (std::max(line, 1UL) - 1) / kLinesPerPiece;
    if (after == digits || piece >= pieces.size()) return std::nullopt;
    if (mesa && *after == '(') std::strtoul(after + 1, &after, 10);
    if (*after == ')') ++after;
    end = after;
    return SourceLocation{pieces[piece].name, static_cast<int>(line - piece * kLinesPerPiece)};
  }

  static SourceLocation locate(const std::string& log, const std::vector<ShaderText>& pieces) {
    const char* end = nullptr;
    return place(log.c_str(), pieces, end).value_or(SourceLocation{pieces.back().name});
  }

  // The compiler's lines, with the pieces' names for their numbers.
  static std::string with_names(const std::string& log, const std::vector<ShaderText>& pieces) {
    std::string text;
    std::istringstream lines(log);
    for (std::string line; std::getline(lines, line);) {
      const char* rest = line.c_str();
      const std::optional<SourceLocation> where = place(line.c_str(), pieces, rest);
      text += (text.empty() ? "" : "\n") + (where ? where->str() : "") + rest;
    }
    return text;
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

std::vector<Uniform> Program::active_uniforms() const {
  const GlFunctions& gl = context_->gl();
  GLint count = 0;
  gl.GetProgramiv(id_, GL_ACTIVE_UNIFORMS, &count);
  std::vector<Uniform> uniforms;
  for (GLint i = 0; i < count; ++i) {
    std::array<char, 256> text{};
    GLsizei length = 0;
    GLint size = 0;
    GLenum type = 0;
    gl.GetActiveUniform(id_, static_cast<GLuint>(i), static_cast<GLsizei>(text.size()), &length, &size, &type,
                        text.data());
    std::string name(text.data(), static_cast<std::size_t>(length));
    uniforms.push_back({name.substr(0, name.find('[')), type, size});
  }
  return uniforms;
}

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
