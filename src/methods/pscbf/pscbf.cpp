#include "methods/pscbf/pscbf.h"

#include <cmath>
#include <limits>
#include <memory>

#include "methods/pscbf/taps.h"
#include "methods/screen_filter.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

double normal_density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi); }

// Inverse of normal_cdf by bisection: a few dozen values per run, so plainness beats speed. Symmetric, so
// that taps mirror each other exactly.
double normal_quantile(double probability) {
  if (probability <= 0.0) return -std::numeric_limits<double>::infinity();
  if (probability >= 1.0) return std::numeric_limits<double>::infinity();
  if (probability == 0.5) return 0.0;
  if (probability > 0.5) return -normal_quantile(1.0 - probability);
  double low = -40.0;
  double high = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_cdf(middle) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct TermTaps {
  TapUniforms taps;
  double narrowest_mm;
  double widest_mm;
};

std::vector<GaussianTap> taps_of(const GaussianTerm& term, const Settings& settings) {
  const TapPlacement placement = tap_placement(settings);
  const int count = settings.whole("taps");
  if (settings.word("sharing") == "none")
    return equal_probability_taps_per_channel(count, term.std_dev_mm(), placement);
  return equal_probability_taps(count, term.std_dev_mm(), placement);
}

std::vector<std::string> defines(const Settings& settings) {
  std::vector<std::string> names = {fmt::format("MAX_TAPS {}", 3 * kMaxTaps)};
  if (settings.word("sampling") == "dense") names.emplace_back("DENSE");
  return names;
}

// The manual stands at the head of pscbf.frag.
PreparedMethod prepare(const MethodInputs& inputs) {
  struct State {
    ScreenResult screen;
    PassProgram filter;
    std::vector<TermTaps> terms;
  };
  const auto state = std::make_shared<State>(
      State{ScreenResult(inputs, inputs.settings.word("targets") == "16-bit" ? gpu::Format::rgba16f
                                                                             : gpu::Format::rgba32f),
            PassProgram::of_pieces(inputs.context, {}, {"filter_geometry.glsl", "pscbf/pscbf.frag"},
                                   defines(inputs.settings)),
            {}});
  const Profile& profile = inputs.profile;
  const double r_max = r_max_mm(profile, inputs.settings);
  for (const GaussianTerm& term : profile.terms)
    state->terms.push_back({TapUniforms(taps_of(term, inputs.settings), term.variance_mm2, r_max),
                            term.std_dev_mm().minCoeff(), term.std_dev_mm().maxCoeff()});
  const Frame& frame = inputs.frame;

  const auto render = [state, r_max, &frame, &profile](Passes& passes) {
    const ScreenResult& screen = state->screen;
    show_filter_geometry(passes, frame, r_max);
    screen.start(passes, frame, profile.delta_weight);
    for (std::size_t i = 0; i < profile.terms.size(); ++i) {
      const TermTaps& term = state->terms[i];
      const auto filter = [&](const gpu::Texture& from, const Target& to, int axis) {
        passes.draw(state->filter, to, [&](const gpu::Program& program) {
          program.set("source", from, 0);
          program.set("position", frame.position, 1);
          program.set("normal", frame.normal, 2);
          program.set("axis", axis);
          program.set("r_max_mm", r_max);
          program.set("focal_px", frame.camera.focal_px());
          program.set("tap_count", static_cast<int>(term.taps.offsets.size()));
          term.taps.set(program);
          program.set("narrowest_mm", term.narrowest_mm);
          program.set("widest_mm", term.widest_mm);
        });
      };
      filter(frame.irradiance, screen.horizontal, 0);
      filter(screen.horizontal.texture, screen.blurred, 1);
      screen.add(passes, frame, screen.blurred.texture, profile.terms[i].weight);
    }
  };
  return {render, &state->screen.result.texture};
}

}  // namespace

std::vector<GaussianTap> equal_probability_taps(int count, const Vec3d& std_dev_mm, TapPlacement placement) {
  std::vector<GaussianTap> taps;
  for (int i = 0; i < count; ++i) {
    const double low = normal_quantile(static_cast<double>(i) / count);
    const double high = normal_quantile(static_cast<double>(i + 1) / count);
    // Centroid of a bin: the integral of x times the density, over the bin's mass 1/count.
    const double middle = placement == TapPlacement::median
                              ? normal_quantile((i + 0.5) / count)
                              : count * (normal_density(low) - normal_density(high));
    GaussianTap tap{middle * std_dev_mm.x(), Vec3d::Zero(), low * std_dev_mm.x(), high * std_dev_mm.x()};
    for (int c = 0; c < 3; ++c) {
      const double ratio = std_dev_mm.x() / std_dev_mm[c];
      tap.weight[c] = normal_cdf(high * ratio) - normal_cdf(low * ratio);
    }
    taps.push_back(tap);
  }
  return taps;
}

std::vector<GaussianTap> equal_probability_taps_per_channel(int count, const Vec3d& std_dev_mm,
                                                            TapPlacement placement) {
  std::vector<GaussianTap> taps;
  for (int c = 0; c < 3; ++c) {
    for (GaussianTap tap : equal_probability_taps(count, Vec3d::Constant(std_dev_mm[c]), placement)) {
      tap.weight = tap.weight[c] * Vec3d::Unit(c);
      taps.push_back(tap);
    }
  }
  return taps;
}

TapUniforms::TapUniforms(const std::vector<GaussianTap>& taps, const Vec3d& variance_mm2, double r_max_mm)
    : depth_factor(-0.5 * variance_mm2.cwiseInverse()) {
  for (const GaussianTap& tap : taps) {
    offsets.push_back(static_cast<float>(tap.offset_mm / r_max_mm));
    weights.push_back(tap.weight.cast<float>());
  }
}

void TapUniforms::set(const gpu::Program& program) const {
  program.set("tap_offset", offsets);
  program.set("tap_weight", weights);
  program.set("depth_factor", depth_factor);
}

SettingSpec taps_setting() { return {"taps", "taps per axis", 13.0, 1.0, kMaxTaps, true}; }

SettingSpec placement_setting() {
  return {"placement", "where in its bin a tap lies", 0.0, 0.0, 0.0, false, {"median", "centroid"}};
}

TapPlacement tap_placement(const Settings& settings) {
  return settings.word("placement") == "centroid" ? TapPlacement::centroid : TapPlacement::median;
}

Method pscbf_method() {
  Method method;
  method.name = "pscbf";
  method.title = "Pseudo-separable cross bilateral filter";
  method.source = "Mikkelsen 2010, section 5";
  method.limits = {.rounding = 1e-5};
  method.settings = {
      taps_setting(),
      placement_setting(),
      r_max_setting(),
      {"sampling", "the taps, or every pixel within d'", 0.0, 0.0, 0.0, false, {"taps", "dense"}},
      {"sharing", "red's taps for all channels, or taps for each", 0.0, 0.0, 0.0, false, {"red", "none"}},
      {"targets", "precision of what passes write", 0.0, 0.0, 0.0, false, {"32-bit", "16-bit"}}};
  method.own_target = [](const Profile& profile, const Settings& settings) {
    return OwnTarget{false, true, r_max_mm(profile, settings)};
  };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
