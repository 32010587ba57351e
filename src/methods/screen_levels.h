#pragma once

#include "methods/method.h"

namespace truescatter {

// What the screen-space methods share: a result that starts as w_0 I and to which blurred levels are added.
struct ScreenResult {
  PassProgram first;
  PassProgram accumulate;
  Target horizontal;  // after the first of two one-dimensional passes
  Target blurred;     // after the second
  Target result;

  // `format`: of what is drawn into.
  explicit ScreenResult(const MethodInputs& inputs, gpu::Format format = gpu::Format::rgba32f)
      : first(inputs.context, "first.frag"),
        accumulate(inputs.context, "accumulate.frag"),
        horizontal(target(inputs, format)),
        blurred(target(inputs, format)),
        result(target(inputs, format)) {}

  void start(Passes& passes, const Frame& frame, const Vec3d& delta_weight) const {
    passes.draw(first, result, [&](const gpu::Program& program) {
      program.set("irradiance", frame.irradiance, 0);
      program.set("delta_weight", delta_weight);
    });
  }

  void add(Passes& passes, const Frame& frame, const gpu::Texture& level, const Vec3d& weight) const {
    passes.draw(
        accumulate, result,
        [&](const gpu::Program& program) {
          program.set("irradiance", frame.irradiance, 0);
          program.set("level", level, 1);
          program.set("weight", weight);
        },
        true);
  }

 private:
  // Linear filtering serves the methods that ask for it; read_texel is not filtered whatever the mode.
  static Target target(const MethodInputs& inputs, gpu::Format format) {
    return {inputs.context, inputs.frame.camera.width_px, inputs.frame.camera.height_px, format,
            gpu::Filter::linear};
  }
};

}  // namespace truescatter
