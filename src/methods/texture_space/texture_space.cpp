#include <cmath>
#include <memory>

#include "methods/method.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

// The manual stands at the head of texture_space.frag.
PreparedMethod prepare(const MethodInputs& inputs) {
  struct State {
    PassProgram first;
    PassProgram uv_irradiance;
    PassProgram uv_stretch;
    PassProgram blur;
    PassProgram gather;
    Target irradiance;
    Target stretch;
    Target half_blurred;
    Target blurred;
    Target result;
  };
  const gpu::Context& context = inputs.context;
  const Frame& frame = inputs.frame;
  const SurfaceBuffers& surface = inputs.surface;
  const int size = inputs.settings.whole("texture_size");
  const auto map = [&] { return Target(context, size, size, gpu::Format::rgba32f, gpu::Filter::linear); };
  const auto state = std::make_shared<State>(
      State{PassProgram(context, "first.frag"),
            PassProgram(context, "texture_space/uv_irradiance.vert", "texture_space/uv_irradiance.frag", {}),
            PassProgram(context, "texture_space/uv_irradiance.vert", "texture_space/uv_stretch.frag", {}),
            PassProgram(context, "texture_space/texture_space.frag"),
            PassProgram(context, "texture_space/gather.frag"), map(), map(), map(), map(),
            Target(context, frame.camera.width_px, frame.camera.height_px, gpu::Format::rgba32f)});
  const double mean_texels_per_mm =
      inputs.settings.word("stretch") == "off" ? size / surface.mean_mm_per_uv_unit() : 0.0;
  const std::vector<GaussianLevel> levels = gaussian_levels(inputs.profile);
  const Vec3d delta_weight = inputs.profile.delta_weight;

  const auto render = [=, &frame, &surface](Passes& passes) {
    const auto draw_surface = [&] { surface.draw(); };
    passes.draw_geometry(
        state->uv_irradiance, state->irradiance, [](const gpu::Program&) {}, draw_surface);
    if (mean_texels_per_mm == 0.0) {
      passes.draw_geometry(
          state->uv_stretch, state->stretch, [](const gpu::Program&) {}, draw_surface);
    }
    passes.draw(state->first, state->result, [&](const gpu::Program& program) {
      program.set("irradiance", frame.irradiance, 0);
      program.set("delta_weight", delta_weight);
    });
    const gpu::Texture* previous = &state->irradiance.texture;
    double previous_variance_mm2 = 0.0;
    for (const GaussianLevel& level : levels) {
      const double step_mm = std::sqrt(level.variance_mm2 - previous_variance_mm2);
      const auto blur = [&](const gpu::Texture& from, const Target& to, int axis) {
        passes.draw(state->blur, to, [&](const gpu::Program& program) {
          program.set("source", from, 0);
          program.set("stretch", state->stretch.texture, 1);
          program.set("axis", axis);
          program.set("std_dev_mm", step_mm);
          program.set("mean_texels_per_mm", mean_texels_per_mm);
        });
      };
      blur(*previous, state->half_blurred, 0);
      blur(state->half_blurred.texture, state->blurred, 1);
      passes.draw(
          state->gather, state->result,
          [&](const gpu::Program& program) {
            program.set("irradiance", frame.irradiance, 0);
            program.set("surface_uv", frame.uv, 1);
            program.set("level", state->blurred.texture, 2);
            program.set("weight", level.weight);
          },
          true);
      previous = &state->blurred.texture;
      previous_variance_mm2 = level.variance_mm2;
    }
  };
  return {render, &state->result.texture};
}

}  // namespace

Method texture_space_method() {
  Method method;
  method.name = "texture-space";
  method.title = "Texture-space diffusion";
  method.source = "d'Eon & Luebke 2007; Yang et al.";
  method.limits = {.rounding = 1e-5, .identity_per_texel = 0.71};
  method.needs_uvs = true;
  method.settings = {{"texture_size", "texels along each side of the maps", 1024.0, 16.0, 8192.0, true},
                     {"stretch", "correction of the UV map's stretch", 0.0, 0.0, 0.0, false, {"raw", "off"}}};
  method.own_target = [](const Profile&, const Settings&) { return OwnTarget{true, true, std::nullopt}; };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
