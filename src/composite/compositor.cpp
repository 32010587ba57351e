#include "composite/compositor.h"

#include <array>
#include <cassert>
#include <span>
#include <string>

#include "gpu/framebuffer.h"
#include "gpu/program.h"
#include "gpu/texture.h"

namespace truescatter {

namespace composite {
// Defined by the build from the module's GLSL files.
std::string embedded(std::string_view path);
}  // namespace composite

namespace {

gpu::Program full_screen_program(const gpu::Context& context, const std::string& file,
                                 const std::vector<std::string>& defines) {
  std::string text = composite::embedded("composite/" + file);
  assert(!text.empty());
  return {context, {gpu::FullScreen::vertex_shader()}, {{"src/composite/" + file, std::move(text)}}, defines};
}

gpu::Texture texture_of(const gpu::Context& context, const Image& image, gpu::Format format,
                        gpu::Filter filter = gpu::Filter::nearest) {
  gpu::Texture texture(context, image.width(), image.height(), format, filter);
  texture.upload(image);
  return texture;
}

// Textures of colours have four channels.
gpu::Texture colour_texture(const gpu::Context& context, const Image& rgb) {
  Image padded(rgb.width(), rgb.height(), 4);
  for (std::size_t i = 0; i < rgb.pixel_count(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) padded.data()[4 * i + c] = rgb.data()[3 * i + c];
  }
  return texture_of(context, padded, gpu::Format::rgba32f);
}

// The passes of specular_light, which share their textures.
class SpecularPasses {
 public:
  SpecularPasses(const gpu::Context& context, const SpecularInputs& inputs)
      : context_(context),
        inputs_(inputs),
        full_screen_(context),
        position_(texture_of(context, inputs.position, gpu::Format::rgba32f)),
        normal_(colour_texture(context, inputs.normal)),
        gloss_(texture_of(context, inputs.gloss, gpu::Format::rg32f)) {}

  void add(const SeenLight& seen) const {
    if (seen.light.kind == LightKind::environment) {
      add_environment(seen);
    } else {
      add_lamp(seen);
    }
  }

 private:
  void add_lamp(const SeenLight& seen) const {
    const bool power = inputs_.encoding == BeckmannEncoding::power;
    const gpu::Program program = full_screen_program(
        context_, "specular.frag", power ? std::vector<std::string>{"POWER"} : std::vector<std::string>{});
    const gpu::Texture table = texture_of(context_, make_beckmann_table(inputs_.encoding).texels,
                                          gpu::Format::r32f, gpu::Filter::linear);
    const bool point = seen.light.kind == LightKind::point;
    const Vec3d world = point ? seen.light.position_mm : seen.light.direction;
    const Vec4d view = inputs_.world_to_view * Vec4d(world.x(), world.y(), world.z(), point ? 1.0 : 0.0);
    draw(program, seen.map, [&] {
      program.set("beckmann", table, 4);
      program.set("light", Vec3d(view.head<3>()));
      program.set("is_point", point ? 1.0 : 0.0);
      program.set("f0", inputs_.f0);
    });
  }

  void add_environment(const SeenLight& seen) const {
    const gpu::Program program = full_screen_program(context_, "specular.frag", {"ENVIRONMENT"});
    const MomentTables tables = make_moment_tables(inputs_.f0);
    const gpu::Texture first = texture_of(context_, tables.first, gpu::Format::rgba32f, gpu::Filter::linear);
    const gpu::Texture second =
        texture_of(context_, tables.second, gpu::Format::rgba32f, gpu::Filter::linear);
    std::array<Vec3f, 9> coefficients;
    for (std::size_t i = 0; i < coefficients.size(); ++i)
      coefficients[i] = seen.light.color.cwiseProduct(seen.light.environment[i]).cast<float>();
    Mat4d view_to_world = Mat4d::Identity();
    view_to_world.topLeftCorner<3, 3>() = inputs_.world_to_view.topLeftCorner<3, 3>().transpose();
    draw(program, seen.map, [&] {
      program.set("moments_first", first, 4);
      program.set("moments_second", second, 5);
      program.set("environment", std::span<const Vec3f>(coefficients));
      program.set("view_to_world", view_to_world);
    });
  }

  // Filling a texture binds it: all are there before the first is set.
  template <typename SetUniforms>
  void draw(const gpu::Program& program, const Image& map, const SetUniforms& set_uniforms) const {
    const gpu::Texture light_map = colour_texture(context_, map);
    program.use();
    set_uniforms();
    program.set("position", position_, 0);
    program.set("normal", normal_, 1);
    program.set("gloss", gloss_, 2);
    program.set("light_map", light_map, 3);
    full_screen_.draw();
  }

  const gpu::Context& context_;
  const SpecularInputs& inputs_;
  gpu::FullScreen full_screen_;
  gpu::Texture position_;
  gpu::Texture normal_;
  gpu::Texture gloss_;
};

}  // namespace

Image specular_light(const gpu::Context& context, const SpecularInputs& inputs) {
  const int width = inputs.normal.width();
  const int height = inputs.normal.height();
  const gpu::Texture target(context, width, height, gpu::Format::rgba32f);
  const gpu::Framebuffer framebuffer(context, {&target});
  framebuffer.clear();
  framebuffer.bind();
  const gpu::GlFunctions& gl = context.gl();
  const SpecularPasses passes(context, inputs);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE);
  for (const SeenLight& seen : inputs.lights) passes.add(seen);
  gl.Disable(GL_BLEND);
  context.check("specular light");
  return framebuffer.read(0, 3);
}

Image composite_picture(const gpu::Context& context, const CompositeInputs& inputs, const Image& exitance) {
  const bool filmic = inputs.curve == ToneCurve::filmic;
  const gpu::Program program = full_screen_program(
      context, "composite.frag", filmic ? std::vector<std::string>{"FILMIC"} : std::vector<std::string>{});
  const gpu::Texture scattered = colour_texture(context, exitance);
  const gpu::Texture albedo = colour_texture(context, inputs.albedo);
  const gpu::Texture specular = colour_texture(context, inputs.specular);
  const gpu::Texture target(context, exitance.width(), exitance.height(), gpu::Format::rgba32f);
  const gpu::Framebuffer framebuffer(context, {&target});
  framebuffer.bind();
  program.use();
  program.set("exitance", scattered, 0);
  program.set("albedo", albedo, 1);
  program.set("specular", specular, 2);
  program.set("exposure", inputs.exposure);
  const gpu::FullScreen full_screen(context);
  full_screen.draw();
  context.check("composite");
  return framebuffer.read(0, 3);
}

}  // namespace truescatter
