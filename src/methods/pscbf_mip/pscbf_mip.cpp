#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "methods/method.h"
#include "methods/pscbf/taps.h"
#include "methods/screen_filter.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

constexpr int kMostLevels = 8;  // samplers level0 .. level7 of pscbf_mip.frag

// Mip maps along one axis, finest first.
using Chain = std::vector<Target>;

Chain make_chain(const MethodInputs& inputs, int levels, int axis) {
  Chain chain;
  for (int level = 0; level < levels; ++level) {
    const auto halved = [&](int size, int along) {
      return along == axis ? (size + (1 << level) - 1) >> level : size;
    };
    chain.emplace_back(inputs.context, halved(inputs.frame.camera.width_px, 0),
                       halved(inputs.frame.camera.height_px, 1), gpu::Format::rgba32f);
  }
  return chain;
}

// Enough for bins as wide as r_max at the median depth.
int levels_for(const MethodInputs& inputs, double r_max_mm) {
  if (inputs.median_skin_depth_mm <= 0.0) return 1;
  const double reach_px = r_max_mm * inputs.frame.camera.focal_px() / inputs.median_skin_depth_mm;
  return std::clamp(1 + static_cast<int>(std::ceil(std::log2(std::max(reach_px, 1.0)))), 1, kMostLevels);
}

struct TermTaps {
  TapUniforms taps;
  std::vector<float> widths;  // of the bins within r_max, as shares of it
};

TermTaps taps_of(const GaussianTerm& term, const Settings& settings, double r_max_mm) {
  const std::vector<GaussianTap> taps =
      equal_probability_taps(settings.whole("taps"), term.std_dev_mm(), tap_placement(settings));
  TermTaps result{TapUniforms(taps, term.variance_mm2, r_max_mm), {}};
  for (const GaussianTap& tap : taps) {
    const double width_mm = std::min(tap.high_mm, r_max_mm) - std::max(tap.low_mm, -r_max_mm);
    result.widths.push_back(static_cast<float>(std::max(width_mm, 0.0) / r_max_mm));
  }
  return result;
}

// The manual stands at the head of pscbf_mip.frag.
struct State {
  ScreenResult screen;
  PassProgram pack;
  PassProgram halve;
  PassProgram filter;
  std::array<Chain, 2> chains;  // horizontal, vertical
  std::vector<TermTaps> terms;
  double r_max_mm;
  double gap_mm;

  void build(Passes& passes, const Frame& frame, const gpu::Texture& source, int axis) const {
    const Chain& chain = chains[static_cast<std::size_t>(axis)];
    passes.draw(pack, chain.front(), [&](const gpu::Program& program) {
      program.set("source", source, 0);
      program.set("position", frame.position, 1);
    });
    for (std::size_t level = 1; level < chain.size(); ++level) {
      passes.draw(halve, chain[level], [&](const gpu::Program& program) {
        program.set("finer", chain[level - 1].texture, 0);
        program.set("axis", axis);
        program.set("gap_mm", gap_mm);
      });
      passes.show(chain[level].texture, axis == 0 ? "mip-across" : "mip-down", "RGB",
                  "irradiance on a mip map that knows of depth, halved along one axis");
    }
  }

  void blur(Passes& passes, const Frame& frame, const TermTaps& term, const gpu::Texture& source,
            const Target& to, int axis) const {
    const Chain& chain = chains[static_cast<std::size_t>(axis)];
    passes.draw(filter, to, [&](const gpu::Program& program) {
      program.set("source", source, 0);
      program.set("position", frame.position, 1);
      program.set("normal", frame.normal, 2);
      for (int level = 0; level < kMostLevels; ++level) {
        const std::size_t made = std::min(static_cast<std::size_t>(level), chain.size() - 1);
        program.set(fmt::format("level{}", level).c_str(), chain[made].texture, 3 + level);
      }
      program.set("levels", static_cast<int>(chain.size()));
      program.set("axis", axis);
      program.set("r_max_mm", r_max_mm);
      program.set("focal_px", frame.camera.focal_px());
      program.set("tap_count", static_cast<int>(term.widths.size()));
      program.set("tap_width", term.widths);
      term.taps.set(program);
    });
  }
};

PreparedMethod prepare(const MethodInputs& inputs) {
  const Profile& profile = inputs.profile;
  const double r_max = r_max_mm(profile, inputs.settings);
  const int levels = levels_for(inputs, r_max);
  const auto state = std::make_shared<State>(
      State{ScreenResult(inputs),
            PassProgram(inputs.context, "pscbf_mip/pack.frag"),
            PassProgram(inputs.context, "pscbf_mip/halve.frag"),
            PassProgram::of_pieces(inputs.context, {}, {"filter_geometry.glsl", "pscbf_mip/pscbf_mip.frag"},
                                   {fmt::format("MAX_TAPS {}", kMaxTaps)}),
            {make_chain(inputs, levels, 0), make_chain(inputs, levels, 1)},
            {},
            r_max,
            profile.widest_std_dev_mm()});
  for (const GaussianTerm& term : profile.terms)
    state->terms.push_back(taps_of(term, inputs.settings, r_max));
  const Frame& frame = inputs.frame;

  const auto render = [state, &frame, &profile](Passes& passes) {
    const ScreenResult& screen = state->screen;
    show_filter_geometry(passes, frame, state->r_max_mm);
    screen.start(passes, frame, profile.delta_weight);
    state->build(passes, frame, frame.irradiance, 0);
    for (std::size_t i = 0; i < profile.terms.size(); ++i) {
      state->blur(passes, frame, state->terms[i], frame.irradiance, screen.horizontal, 0);
      state->build(passes, frame, screen.horizontal.texture, 1);
      state->blur(passes, frame, state->terms[i], screen.horizontal.texture, screen.blurred, 1);
      screen.add(passes, frame, screen.blurred.texture, profile.terms[i].weight);
    }
  };
  return {render, &state->screen.result.texture};
}

}  // namespace

Method pscbf_mip_method() {
  Method method;
  method.name = "pscbf-mip";
  method.title = "Pseudo-separable filter on mip maps";
  method.source = "Mikkelsen 2010, section 7";
  method.limits = {.rounding = 2e-5, .identity_per_px = 1.6};
  // Those of ScreenResult, and two chains of maps that halve along one axis: twice the first.
  method.memory = {.bytes_per_pixel = 3.0 * 16.0 + 2.0 * 2.0 * 16.0};
  method.settings = {taps_setting(), placement_setting(), r_max_setting()};
  method.own_target = [](const Profile& profile, const Settings& settings) {
    return OwnTarget{false, true, r_max_mm(profile, settings)};
  };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
