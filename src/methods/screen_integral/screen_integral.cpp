#include <memory>

#include "methods/method.h"
#include "methods/screen_filter.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

constexpr std::string_view kName = "screen-integral";

bool is_raw(const Settings& settings) { return settings.word("sum") == "raw"; }

std::vector<std::string> defines(const Settings& settings) {
  std::vector<std::string> names;
  if (!is_raw(settings)) names.emplace_back("NORMALISED");
  if (settings.word("area") == "constant") names.emplace_back("CONSTANT_AREA");
  return names;
}

// The manual stands at the head of screen_integral.frag.
PreparedMethod prepare(const MethodInputs& inputs) {
  struct State {
    DeltaPass first;
    WeightedLight weighted;
    PassProgram gather;
    Target result;
    std::vector<DenseTerm> terms;
  };
  const double r_max = r_max_mm(inputs.profile, inputs.settings);
  const std::vector<DenseTerm> terms = dense_terms(inputs.profile, r_max);
  check_reach(inputs, kName, terms);
  const gpu::Context& context = inputs.context;
  const Frame& frame = inputs.frame;
  const std::vector<std::string> names = defines(inputs.settings);
  const auto state = std::make_shared<State>(
      State{DeltaPass(context), WeightedLight(inputs, names),
            PassProgram::of_pieces(
                context, {},
                {"filter_geometry.glsl", "pixel_mean.glsl", "screen_integral/screen_integral.frag"}, names),
            Target(context, frame.camera.width_px, frame.camera.height_px, gpu::Format::rgba32f), terms});
  const Vec3d delta_weight = inputs.profile.delta_weight;
  const bool raw = is_raw(inputs.settings);

  const auto render = [=, &frame](Passes& passes) {
    state->first.draw(passes, frame, delta_weight, state->result);
    state->weighted.draw(passes, frame);
    for (const DenseTerm& term : state->terms) {
      passes.draw(
          state->gather, state->result,
          [&](const gpu::Program& program) {
            program.set("position", frame.position, 0);
            program.set("face_normal", frame.face_normal, 1);
            program.set("weighted", state->weighted.light(), 2);
            program.set("focal_px", frame.camera.focal_px());
            program.set("scale", raw ? term.raw_scale() : term.weight);
            term.set(program, r_max);
          },
          true);
    }
  };
  return {render, &state->result.texture};
}

}  // namespace

Method screen_integral_method() {
  Method method;
  method.name = kName;
  method.title = "Integral over the picture";
  method.source = "Mikkelsen 2010, equations 1-3";
  method.reads_all_within_r_max = true;
  method.limits = {.rounding = 1e-5, .raw_rim = 3.0};
  method.settings = {
      r_max_setting(),
      {"sum", "divided by its own weights, or not", 0.0, 0.0, 0.0, false, {"raw", "normalised"}},
      {"area",
       "w(p) of each pixel, or of the pixel itself for all",
       0.0,
       0.0,
       0.0,
       false,
       {"face", "constant"}}};
  method.own_target = [](const Profile& profile, const Settings& settings) {
    return OwnTarget{false, !is_raw(settings), r_max_mm(profile, settings)};
  };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
