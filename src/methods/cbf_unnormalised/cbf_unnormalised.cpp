#include <memory>

#include "methods/method.h"
#include "methods/screen_filter.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

constexpr std::string_view kName = "cbf-unnormalised";

// A surface behind the first one.
struct Layer {
  Target position;
  Target weighted;
};

Layer make_layer(const MethodInputs& inputs) {
  const auto target = [&] {
    return Target::with_depth(inputs.context, inputs.frame.camera.width_px, inputs.frame.camera.height_px,
                              gpu::Format::rgba32f);
  };
  return {target(), target()};
}

PassProgram peeling_program(const gpu::Context& context, const std::vector<std::string>& defines) {
  return PassProgram::of_pieces(context, "frame/gbuffer.vert",
                                {"filter_geometry.glsl", "cbf_unnormalised/peel.frag"}, defines);
}

// The manual stands at the head of cbf_unnormalised.frag.
PreparedMethod prepare(const MethodInputs& inputs) {
  struct State {
    DeltaPass first;
    WeightedLight weighted;
    PassProgram peel_position;
    PassProgram peel_weighted;
    LinearSum gather;
    Target result;
    std::vector<Layer> behind;
    std::vector<DenseTerm> terms;
  };
  const double r_max = r_max_mm(inputs.profile, inputs.settings);
  const std::vector<DenseTerm> terms = dense_terms(inputs.profile, r_max);
  check_reach(inputs, kName, terms);
  const gpu::Context& context = inputs.context;
  const Frame& frame = inputs.frame;
  const SurfaceBuffers& surface = inputs.surface;
  const auto state = std::make_shared<State>(
      State{DeltaPass(context),
            WeightedLight(inputs),
            peeling_program(context, {"PEEL_POSITION"}),
            peeling_program(context, {}),
            LinearSum(context, "cbf_unnormalised/cbf_unnormalised.frag", {}),
            Target(context, frame.camera.width_px, frame.camera.height_px, gpu::Format::rgba32f),
            {},
            terms});
  for (int l = 1; l < inputs.settings.whole("layers"); ++l) state->behind.push_back(make_layer(inputs));
  const Vec3d delta_weight = inputs.profile.delta_weight;

  const auto peel = [state, &frame, &surface](Passes& passes, const Layer& layer,
                                              const gpu::Texture& previous) {
    const auto draw = [&](const PassProgram& program, const Target& to) {
      passes.draw_geometry(
          program, to,
          [&](const gpu::Program& used) {
            used.set("view", frame.view);
            used.set("projection", frame.projection);
            used.set("previous", previous, 0);
          },
          [&] { surface.draw(); });
    };
    draw(state->peel_position, layer.position);
    draw(state->peel_weighted, layer.weighted);
  };

  const auto render = [=, &frame](Passes& passes) {
    show_filter_geometry(passes, frame, r_max);
    state->first.draw(passes, frame, delta_weight, state->result);
    state->weighted.draw(passes, frame);
    passes.show(state->weighted.light(), "light", "RGBw",
                "irradiance times the area weight w(p), and w(p), mm^2");
    const auto add_light_of = [&](const LightLayer& layer) {
      for (const DenseTerm& term : state->terms) {
        state->gather.add(
            passes, frame, layer, term, term.raw_scale(), r_max, state->result,
            [&](const gpu::Program& program) { program.set("center_light", state->weighted.light(), 5); });
      }
    };
    add_light_of({frame.position, state->weighted.light()});
    const gpu::Texture* previous = &frame.position;
    for (const Layer& layer : state->behind) {
      peel(passes, layer, *previous);
      passes.show(layer.position.texture, "layer-position", "XYZ",
                  "view-space position on the next layer behind, mm");
      passes.show(layer.weighted.texture, "layer-light", "RGBw", "its irradiance times w(p), and w(p), mm^2");
      add_light_of({layer.position.texture, layer.weighted.texture});
      previous = &layer.position.texture;
    }
  };
  return {render, &state->result.texture};
}

}  // namespace

Method cbf_unnormalised_method() {
  Method method;
  method.name = kName;
  method.title = "Cross bilateral filter, unnormalised";
  method.source = "Mikkelsen 2010, equations 4-7";
  method.limits = {.rounding = 1e-5, .raw_rim = 3.0, .raw_perspective = 1.25};
  // Positions and light of two layers with a depth each, and the result.
  method.reads_all_within_r_max = true;
  method.memory = {.bytes_per_pixel = 2.0 * 2.0 * 20.0 + 16.0};
  method.settings = {r_max_setting(), {"layers", "surfaces behind each other", 1.0, 1.0, 8.0, true}};
  method.own_target = [](const Profile& profile, const Settings& settings) {
    return OwnTarget{false, false, r_max_mm(profile, settings)};
  };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
