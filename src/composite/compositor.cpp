#include "composite/compositor.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <optional>
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

std::vector<std::string> lamp_defines(BeckmannEncoding encoding) {
  return encoding == BeckmannEncoding::power ? std::vector<std::string>{"POWER"} : std::vector<std::string>{};
}

}  // namespace

// Programs with the tables that they read.
namespace composite {

// For lights without size.
struct LampShading {
  LampShading(const gpu::Context& context, BeckmannEncoding encoding)
      : program(full_screen_program(context, "specular.frag", lamp_defines(encoding))),
        table(texture_of(context, make_beckmann_table(encoding).texels, gpu::Format::r32f,
                         gpu::Filter::linear)) {}

  gpu::Program program;
  gpu::Texture table;
};

struct EnvironmentShading {
  EnvironmentShading(const gpu::Context& context, const MomentTables& tables)
      : program(full_screen_program(context, "specular.frag", {"ENVIRONMENT"})),
        first(texture_of(context, tables.first, gpu::Format::rgba32f, gpu::Filter::linear)),
        second(texture_of(context, tables.second, gpu::Format::rgba32f, gpu::Filter::linear)) {}

  gpu::Program program;
  gpu::Texture first;
  gpu::Texture second;
};

}  // namespace composite

struct Compositor::Parts {
  const gpu::Context& context;
  CompositorSettings settings;
  gpu::FullScreen full_screen;
  gpu::Program compose;
  // Made for the first light of their kind.
  std::optional<composite::LampShading> lamps;
  std::optional<composite::EnvironmentShading> environments;
};

namespace {

// The passes of Compositor::specular_light, which share their textures.
class SpecularPasses {
 public:
  SpecularPasses(const gpu::Context& context, const gpu::FullScreen& full_screen,
                 const SpecularInputs& inputs)
      : context_(context),
        full_screen_(full_screen),
        world_to_view_(inputs.world_to_view),
        position_(texture_of(context, inputs.position, gpu::Format::rgba32f)),
        normal_(colour_texture(context, inputs.normal)),
        gloss_(texture_of(context, inputs.gloss, gpu::Format::rg32f)) {}

  void add_lamp(const SeenLight& seen, const composite::LampShading& by, double f0) const {
    const bool point = seen.light.kind == LightKind::point;
    const Vec3d world = point ? seen.light.position_mm : seen.light.direction;
    const Vec4d view = world_to_view_ * Vec4d(world.x(), world.y(), world.z(), point ? 1.0 : 0.0);
    draw(by.program, seen.map, [&] {
      by.program.set("beckmann", by.table, 4);
      by.program.set("light", Vec3d(view.head<3>()));
      by.program.set("is_point", point ? 1.0 : 0.0);
      by.program.set("f0", f0);
    });
  }

  void add_environment(const SeenLight& seen, const composite::EnvironmentShading& by) const {
    std::array<Vec3f, 9> coefficients;
    for (std::size_t i = 0; i < coefficients.size(); ++i)
      coefficients[i] = seen.light.color.cwiseProduct(seen.light.environment[i]).cast<float>();
    Mat4d view_to_world = Mat4d::Identity();
    view_to_world.topLeftCorner<3, 3>() = world_to_view_.topLeftCorner<3, 3>().transpose();
    draw(by.program, seen.map, [&] {
      by.program.set("moments_first", by.first, 4);
      by.program.set("moments_second", by.second, 5);
      by.program.set("environment", std::span<const Vec3f>(coefficients));
      by.program.set("view_to_world", view_to_world);
    });
  }

 private:
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
  const gpu::FullScreen& full_screen_;
  Mat4d world_to_view_;
  gpu::Texture position_;
  gpu::Texture normal_;
  gpu::Texture gloss_;
};

}  // namespace

Compositor::Compositor(const gpu::Context& context, const CompositorSettings& settings)
    : parts_(new Parts{
          context, settings, gpu::FullScreen(context),
          full_screen_program(context, "composite.frag",
                              settings.curve == ToneCurve::filmic ? std::vector<std::string>{"FILMIC"}
                                                                  : std::vector<std::string>{}),
          std::nullopt, std::nullopt}) {}

Compositor::~Compositor() = default;

Image Compositor::specular_light(const SpecularInputs& inputs) const {
  Parts& parts = *parts_;
  const bool environments =
      std::any_of(inputs.lights.begin(), inputs.lights.end(),
                  [](const SeenLight& seen) { return seen.light.kind == LightKind::environment; });
  const bool lamps = std::any_of(inputs.lights.begin(), inputs.lights.end(), [](const SeenLight& seen) {
    return seen.light.kind != LightKind::environment;
  });
  if (lamps && !parts.lamps) parts.lamps.emplace(parts.context, parts.settings.encoding);
  if (environments && !parts.environments)
    parts.environments.emplace(parts.context, make_moment_tables(parts.settings.f0));

  const gpu::Texture target(parts.context, inputs.normal.width(), inputs.normal.height(),
                            gpu::Format::rgba32f);
  const gpu::Framebuffer framebuffer(parts.context, {&target});
  framebuffer.clear();
  framebuffer.bind();
  const gpu::GlFunctions& gl = parts.context.gl();
  const SpecularPasses passes(parts.context, parts.full_screen, inputs);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE);
  for (const SeenLight& seen : inputs.lights) {
    if (seen.light.kind == LightKind::environment) {
      passes.add_environment(seen, *parts.environments);
    } else {
      passes.add_lamp(seen, *parts.lamps, parts.settings.f0);
    }
  }
  gl.Disable(GL_BLEND);
  parts.context.check("specular light");
  return framebuffer.read(0, 3);
}

Image Compositor::picture(const CompositeInputs& inputs, const Image& exitance) const {
  const Parts& parts = *parts_;
  const gpu::Texture scattered = colour_texture(parts.context, exitance);
  const gpu::Texture albedo = colour_texture(parts.context, inputs.albedo);
  const gpu::Texture specular = colour_texture(parts.context, inputs.specular);
  const gpu::Texture target(parts.context, exitance.width(), exitance.height(), gpu::Format::rgba32f);
  const gpu::Framebuffer framebuffer(parts.context, {&target});
  framebuffer.bind();
  parts.compose.use();
  parts.compose.set("exitance", scattered, 0);
  parts.compose.set("albedo", albedo, 1);
  parts.compose.set("specular", specular, 2);
  parts.compose.set("exposure", inputs.exposure);
  parts.full_screen.draw();
  parts.context.check("composite");
  return framebuffer.read(0, 3);
}

}  // namespace truescatter
