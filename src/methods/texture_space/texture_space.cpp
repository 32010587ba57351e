#include <memory>

#include "methods/texture_space/uv_diffusion.h"

namespace truescatter {
namespace {

// The manual stands at the head of texture_space.frag.
struct State {
  UvDiffusion diffusion;
  DeltaPass first;
  PassProgram uv_irradiance;
  GatherPass gather;
  Target result;
};

PreparedMethod prepare(const MethodInputs& inputs) {
  const gpu::Context& context = inputs.context;
  const Frame& frame = inputs.frame;
  const Profile& profile = inputs.profile;
  const SurfaceBuffers& surface = inputs.surface;
  const auto state = std::make_shared<State>(
      State{UvDiffusion(inputs, false), DeltaPass(context),
            PassProgram(context, "texture_space/uv_irradiance.vert", "texture_space/uv_irradiance.frag", {}),
            GatherPass(inputs),
            Target(context, frame.camera.width_px, frame.camera.height_px, gpu::Format::rgba32f)});
  const auto render = [state, &frame, &profile, &surface](Passes& passes) {
    state->first.draw(passes, frame, profile.delta_weight, state->result);
    for (const SeenCharacter& character : state->diffusion.characters()) {
      const auto draw_irradiance = [&](Passes& to, const Target& map) {
        to.draw_geometry(
            state->uv_irradiance, map, [](const gpu::Program&) {},
            [&] { surface.draw_character(character.index); });
      };
      const auto gather = [&](std::size_t i) {
        state->gather.draw(passes, character, state->diffusion.current(), state->diffusion.levels()[i].weight,
                           state->result);
      };
      state->diffusion.run(
          passes, {character, draw_irradiance}, [](std::size_t) {}, gather);
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
  method.limits = {.rounding = 1e-5, .identity_per_texel = 1.42};
  // A result on the screen; the light, its stretch and the nearest texels in texture space, two maps each.
  method.memory = {.bytes_per_pixel = 16.0, .bytes_per_texel = 3.0 * 2.0 * 16.0};
  method.needs_uvs = true;
  method.settings = uv_diffusion_settings();
  method.own_target = [](const Profile&, const Settings&) { return OwnTarget{true, true, std::nullopt}; };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
