#include <memory>

#include "methods/method.h"
#include "methods/pscbf/pscbf.h"
#include "methods/pscbf/taps.h"
#include "methods/screen_filter.h"

namespace truescatter {
namespace {

constexpr int kTapsPerAxis = 4;  // 16 in all

// The manual stands at the head of pscbf_transmit.frag.
struct State {
  PreparedMethod local;
  PassProgram draw_surface;
  PassProgram draw_light;
  PassProgram gather;
  Target back_surface;
  Target back_light;
  Target result;
  std::vector<TapUniforms> taps;
};

void draw_back(Passes& passes, const State& state, const Frame& frame, const SurfaceBuffers& surface) {
  const auto draw = [&](const PassProgram& program, const Target& to) {
    passes.draw_geometry(
        program, to,
        [&](const gpu::Program& used) {
          used.set("view", frame.view);
          used.set("projection", frame.projection);
        },
        [&] { surface.draw(); });
  };
  draw(state.draw_surface, state.back_surface);
  draw(state.draw_light, state.back_light);
}

PreparedMethod prepare(const MethodInputs& inputs) {
  const gpu::Context& context = inputs.context;
  const Frame& frame = inputs.frame;
  const Profile& profile = inputs.profile;
  const SurfaceBuffers& surface = inputs.surface;
  PreparedMethod local = pscbf_method().prepare(inputs);
  if (profile.terms.empty()) return local;
  const double r_max = r_max_mm(profile, inputs.settings);
  const int width = frame.camera.width_px;
  const int height = frame.camera.height_px;
  const auto back_program = [&](const std::vector<std::string>& defines) {
    return PassProgram(context, "frame/gbuffer.vert", "pscbf_transmit/back.frag", defines);
  };
  const auto back_target = [&] { return Target::with_depth(context, width, height, gpu::Format::rgba32f); };
  const auto state = std::make_shared<State>(State{
      std::move(local),
      back_program({"BACK_SURFACE"}),
      back_program({}),
      PassProgram::of_pieces(context, {}, {"filter_geometry.glsl", "pscbf_transmit/pscbf_transmit.frag"},
                             {fmt::format("TAPS {}", kTapsPerAxis)}),
      back_target(),
      back_target(),
      Target(context, width, height, gpu::Format::rgba32f),
      {}});
  for (const GaussianTerm& term : profile.terms)
    state->taps.emplace_back(
        equal_probability_taps(kTapsPerAxis, term.std_dev_mm(), tap_placement(inputs.settings)),
        term.variance_mm2, r_max);

  const auto render = [state, r_max, &frame, &profile, &surface](Passes& passes) {
    state->local.render(passes);
    draw_back(passes, *state, frame, surface);
    passes.show(state->back_surface.texture, "back-surface", "xyzd",
                "unit normal of the back faces, and d, their z in mm, view space");
    passes.show(state->back_light.texture, "back-light", "RGB", "irradiance of the back faces");
    for (std::size_t i = 0; i < profile.terms.size(); ++i) {
      passes.draw(
          state->gather, state->result,
          [&](const gpu::Program& program) {
            program.set("local", *state->local.output, 0);
            program.set("position", frame.position, 1);
            program.set("normal", frame.normal, 2);
            program.set("irradiance", frame.irradiance, 3);
            program.set("back_surface", state->back_surface.texture, 4);
            program.set("back_light", state->back_light.texture, 5);
            program.set("local_weight", i == 0 ? 1.0 : 0.0);
            program.set("r_max_mm", r_max);
            program.set("focal_px", frame.camera.focal_px());
            state->taps[i].set(program);
            program.set("weight", profile.terms[i].weight);
          },
          i > 0);
    }
  };
  return {render, &state->result.texture};
}

}  // namespace

Method pscbf_transmit_method() {
  Method method = pscbf_method();
  method.name = "pscbf-transmit";
  method.title = "Pseudo-separable filter with transmittance";
  method.source = "Mikkelsen 2010, section 6";
  // ScreenResult, two buffers with their depths, and the result.
  method.memory = {.bytes_per_pixel = 3.0 * 16.0 + 2.0 * 20.0 + 16.0};
  method.own_target = [](const Profile& profile, const Settings& settings) {
    return OwnTarget{.r_max_mm = r_max_mm(profile, settings), .transmittance = true};
  };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
