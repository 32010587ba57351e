#include <cmath>
#include <memory>

#include "methods/method.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

// The manual stands at the head of screen_gaussian.frag.
PreparedMethod prepare(const MethodInputs& inputs) {
  struct State {
    ScreenResult screen;
    PassProgram blur;
    Target linear_irradiance;  // the frame's irradiance again, readable with a linear filter
  };
  const Frame& frame = inputs.frame;
  const auto state = std::make_shared<State>(
      State{ScreenResult(inputs), PassProgram(inputs.context, "screen_gaussian/screen_gaussian.frag"),
            Target(inputs.context, frame.camera.width_px, frame.camera.height_px, gpu::Format::rgba32f,
                   gpu::Filter::linear)});
  const std::vector<GaussianLevel> levels = gaussian_levels(inputs.profile);
  const Vec3d delta_weight = inputs.profile.delta_weight;
  const double slope_beta = inputs.settings.number("slope_beta");
  const double max_gradient_mm = inputs.settings.number("max_gradient_mm");

  const auto render = [=, &frame](Passes& passes) {
    const ScreenResult& screen = state->screen;
    screen.start(passes, frame, delta_weight);
    screen.first.draw(passes, frame, Vec3d::Ones(), state->linear_irradiance);
    const gpu::Texture* previous = &state->linear_irradiance.texture;
    double previous_variance_mm2 = 0.0;
    for (const GaussianLevel& level : levels) {
      const double step_mm = std::sqrt(level.variance_mm2 - previous_variance_mm2);
      const auto blur = [&](const gpu::Texture& from, const Target& to, int axis) {
        passes.draw(state->blur, to, [&](const gpu::Program& program) {
          program.set("source", from, 0);
          program.set("position", frame.position, 1);
          program.set("axis", axis);
          program.set("std_dev_mm", step_mm);
          program.set("focal_px", frame.camera.focal_px());
          program.set("slope_beta", slope_beta);
          program.set("max_gradient_mm", max_gradient_mm);
        });
      };
      blur(*previous, screen.horizontal, 0);
      blur(screen.horizontal.texture, screen.blurred, 1);
      screen.add(passes, frame, screen.blurred.texture, level.weight);
      previous = &screen.blurred.texture;
      previous_variance_mm2 = level.variance_mm2;
    }
  };
  return {render, &state->screen.result.texture};
}

}  // namespace

Method screen_gaussian_method() {
  Method method;
  method.name = "screen-gaussian";
  method.title = "Screen-space Gaussian";
  method.source = "Jimenez et al. 2009";
  method.masks_its_taps = false;
  method.limits = {.rounding = 2e-5, .identity_per_px = 2.0 * 0.76};
  method.settings = {
      {"slope_beta", "how much the width shrinks with the depth's gradient, in focal lengths", 1.0, 0.0,
       100.0},
      {"max_gradient_mm", "bound on the depth's gradient in mm per pixel; 0: none", 0.0, 0.0, 1e6}};
  method.own_target = [](const Profile&, const Settings&) { return OwnTarget{}; };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
