#include <memory>

#include "methods/method.h"
#include "methods/screen_filter.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

constexpr std::string_view kName = "cbf";

std::vector<std::string> defines(const Settings& settings) {
  std::vector<std::string> names;
  if (settings.word("bound") == "disc") names.emplace_back("DISC");
  if (settings.word("spacing") == "proportional") names.emplace_back("PROPORTIONAL");
  return names;
}

// The manual stands at the head of cbf.frag.
PreparedMethod prepare(const MethodInputs& inputs) {
  struct State {
    DeltaPass first;
    LinearSum gather;
    Target result;
    std::vector<DenseTerm> terms;
  };
  const double r_max = r_max_mm(inputs.profile, inputs.settings);
  const std::vector<DenseTerm> terms = dense_terms(inputs.profile, r_max);
  check_reach(inputs, kName, terms);
  const Frame& frame = inputs.frame;
  const auto state = std::make_shared<State>(State{
      DeltaPass(inputs.context), LinearSum(inputs.context, "cbf/cbf.frag", defines(inputs.settings)),
      Target(inputs.context, frame.camera.width_px, frame.camera.height_px, gpu::Format::rgba32f), terms});
  const Vec3d delta_weight = inputs.profile.delta_weight;

  const auto render = [=, &frame](Passes& passes) {
    show_filter_geometry(passes, frame, r_max);
    state->first.draw(passes, frame, delta_weight, state->result);
    for (const DenseTerm& term : state->terms)
      state->gather.add(passes, frame, {frame.position, frame.irradiance}, term, term.weight, r_max,
                        state->result);
  };
  return {render, &state->result.texture};
}

}  // namespace

Method cbf_method() {
  Method method;
  method.name = kName;
  method.title = "Cross bilateral filter";
  method.source = "Mikkelsen 2010, equation 8";
  method.reads_all_within_r_max = true;
  method.limits = {.rounding = 1e-5};
  method.settings = {r_max_setting(),
                     {"bound", "what cuts the filter off", 0.0, 0.0, 0.0, false, {"disc", "ball"}},
                     {"spacing",
                      "distance for pixels: by K, or by shares of d'",
                      0.0,
                      0.0,
                      0.0,
                      false,
                      {"k", "proportional"}}};
  method.own_target = [](const Profile& profile, const Settings& settings) {
    return OwnTarget{false, true, r_max_mm(profile, settings)};
  };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
