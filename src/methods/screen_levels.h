#pragma once

#include "methods/method.h"

namespace truescatter {

// The first layer of a result: w_0 I on skin, the plain irradiance elsewhere (first.frag).
class DeltaPass {
 public:
  explicit DeltaPass(const gpu::Context& context) : program_(context, "first.frag") {}

  void draw(Passes& passes, const Frame& frame, const Vec3d& delta_weight, const Target& to) const {
    passes.draw(program_, to, [&](const gpu::Program& program) {
      program.set("irradiance", frame.irradiance, 0);
      program.set("delta_weight", delta_weight);
    });
  }

 private:
  PassProgram program_;
};

// Adds a blurred level, times its weight, to a result (accumulate.frag).
class LevelPass {
 public:
  explicit LevelPass(const gpu::Context& context) : program_(context, "accumulate.frag") {}

  void draw(Passes& passes, const Frame& frame, const gpu::Texture& level, const Vec3d& weight,
            const Target& to) const {
    passes.draw(
        program_, to,
        [&](const gpu::Program& program) {
          program.set("irradiance", frame.irradiance, 0);
          program.set("level", level, 1);
          program.set("weight", weight);
        },
        true);
  }

 private:
  PassProgram program_;
};

// What the screen-space methods share: a result that starts as w_0 I and to which blurred levels are added.
struct ScreenResult {
  DeltaPass first;
  LevelPass accumulate;
  Target horizontal;  // after the first of two one-dimensional passes
  Target blurred;     // after the second
  Target result;

  // `format`: of what is drawn into.
  explicit ScreenResult(const MethodInputs& inputs, gpu::Format format = gpu::Format::rgba32f)
      : first(inputs.context),
        accumulate(inputs.context),
        horizontal(target(inputs, format)),
        blurred(target(inputs, format)),
        result(target(inputs, format)) {}

  void start(Passes& passes, const Frame& frame, const Vec3d& delta_weight) const {
    first.draw(passes, frame, delta_weight, result);
  }

  void add(Passes& passes, const Frame& frame, const gpu::Texture& level, const Vec3d& weight) const {
    passes.show(level, "level", "RGB", "the frame's light, blurred, before its weight");
    accumulate.draw(passes, frame, level, weight, result);
  }

 private:
  // Linear filtering serves the methods that ask for it; read_texel is not filtered whatever the mode.
  static Target target(const MethodInputs& inputs, gpu::Format format) {
    return {inputs.context, inputs.frame.camera.width_px, inputs.frame.camera.height_px, format,
            gpu::Filter::linear};
  }
};

}  // namespace truescatter
