#include <memory>

#include "methods/method.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

// The manual stands at the head of blur2d.frag.
PreparedMethod prepare(const MethodInputs& inputs) {
  struct State {
    ScreenResult screen;
    PassProgram blur;
  };
  const auto state =
      std::make_shared<State>(State{ScreenResult(inputs), PassProgram(inputs.context, "blur2d/blur2d.frag")});
  const Frame& frame = inputs.frame;
  const double px_per_mm =
      inputs.median_skin_depth_mm > 0.0 ? frame.camera.focal_px() / inputs.median_skin_depth_mm : 0.0;
  const std::vector<GaussianLevel> levels = gaussian_levels(inputs.profile);
  const Vec3d delta_weight = inputs.profile.delta_weight;

  const auto render = [state, &frame, px_per_mm, levels, delta_weight](Passes& passes) {
    state->screen.start(passes, frame, delta_weight);
    for (const GaussianLevel& level : levels) {
      const auto blur = [&](const gpu::Texture& from, const Target& to, int axis) {
        passes.draw(state->blur, to, [&](const gpu::Program& program) {
          program.set("source", from, 0);
          program.set("axis", axis);
          program.set("std_dev_px", std::max(1e-3, level.std_dev_mm() * px_per_mm));
        });
      };
      blur(frame.irradiance, state->screen.horizontal, 0);
      blur(state->screen.horizontal.texture, state->screen.blurred, 1);
      state->screen.add(passes, frame, state->screen.blurred.texture, level.weight);
    }
  };
  return {render, &state->screen.result.texture};
}

}  // namespace

Method blur2d_method() {
  Method method;
  method.name = "blur2d";
  method.title = "2D Gaussian, fixed size";
  method.source = "Mikkelsen 2010, figure 3a";
  method.masks_its_taps = false;
  method.limits = {.rounding = 2e-6};
  method.own_target = [](const Profile&, const Settings&) { return OwnTarget{}; };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
