#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "methods/method.h"
#include "methods/screen_levels.h"

namespace truescatter {
namespace {

// The manual stands at the head of texture_space.frag.

// Two maps in texture space: a pass reads the one and writes the other.
class MapPair {
 public:
  MapPair(const gpu::Context& context, int size, gpu::Format format, gpu::Filter filter)
      : maps_{Target(context, size, size, format, filter), Target(context, size, size, format, filter)} {}

  const gpu::Texture& current() const { return maps_[current_].texture; }
  const Target& current_target() const { return maps_[current_]; }
  const Target& next() const { return maps_[1 - current_]; }
  void flip() { current_ = 1 - current_; }
  Target take_current() { return std::move(maps_[current_]); }

 private:
  std::array<Target, 2> maps_;
  std::size_t current_ = 0;
};

MapPair rgba_maps(const gpu::Context& context, int size) {
  return {context, size, gpu::Format::rgba32f, gpu::Filter::linear};
}

std::vector<std::string> blur_defines(const Settings& settings) {
  std::vector<std::string> defines;
  if (settings.word("taps") == "dense") defines.emplace_back("DENSE");
  if (settings.word("gutter") == "coverage") defines.emplace_back("COVERAGE");
  return defines;
}

std::vector<std::string> gather_defines(const Settings& settings) {
  std::vector<std::string> defines;
  if (settings.word("gutter") == "coverage") defines.emplace_back("COVERAGE");
  if (settings.word("reading") == "bicubic") defines.emplace_back("BICUBIC");
  return defines;
}

class TextureSpace {
 public:
  explicit TextureSpace(const MethodInputs& inputs)
      : frame_(inputs.frame),
        surface_(inputs.surface),
        size_(inputs.settings.whole("texture_size")),
        has_stretch_map_(inputs.settings.word("stretch") != "off"),
        blurs_stretch_(inputs.settings.word("stretch") == "blurred"),
        first_is_irradiance_(inputs.settings.word("first_gaussian") == "irradiance"),
        incremental_(inputs.settings.word("passes") == "incremental"),
        gain_(inputs.settings.word("taps") == "seven-published" ? 1.001 : 1.0),
        mean_texels_per_mm_(has_stretch_map_ ? 0.0 : size_ / inputs.surface.mean_mm_per_uv_unit()),
        levels_(gaussian_levels(inputs.profile)),
        delta_weight_(inputs.profile.delta_weight),
        first_(inputs.context),
        uv_irradiance_(inputs.context, "texture_space/uv_irradiance.vert", "texture_space/uv_irradiance.frag",
                       {}),
        uv_stretch_(inputs.context, "texture_space/uv_irradiance.vert", "texture_space/uv_stretch.frag", {}),
        fill_(inputs.context, "texture_space/fill_gutter.frag"),
        blur_(inputs.context, "texture_space/texture_space.frag", blur_defines(inputs.settings)),
        gather_(inputs.context, "texture_space/gather.frag", gather_defines(inputs.settings)),
        irradiance_(rgba_maps(inputs.context, size_)),
        result_(inputs.context, inputs.frame.camera.width_px, inputs.frame.camera.height_px,
                gpu::Format::rgba32f) {
    if (has_stretch_map_) stretch_.emplace(rgba_maps(inputs.context, size_));
    if (inputs.settings.word("gutter") == "nearest") find_nearest(inputs.context);
  }

  const gpu::Texture& output() const { return result_.texture; }

  void render(Passes& passes) {
    draw_maps(passes);
    first_.draw(passes, frame_, delta_weight_, result_);
    double previous_variance_mm2 = 0.0;
    for (const GaussianLevel& level : levels_) {
      const bool is_first = &level == &levels_.front();
      if (!incremental_ && !is_first) draw_maps(passes);
      if (!(is_first && first_is_irradiance_)) {
        const double std_dev_mm = std::sqrt(level.variance_mm2 - previous_variance_mm2);
        if (blurs_stretch_) blur(passes, *stretch_, std_dev_mm);
        blur(passes, irradiance_, std_dev_mm);
      }
      gather(passes, level.weight);
      if (incremental_) previous_variance_mm2 = level.variance_mm2;
    }
  }

 private:
  // The nearest texel on skin of every texel; once, for texture coordinates do not change.
  void find_nearest(const gpu::Context& context) {
    const PassProgram start(context, "texture_space/nearest_start.frag");
    const PassProgram step(context, "texture_space/nearest_step.frag");
    Passes passes(context);
    passes.draw_geometry(
        uv_irradiance_, irradiance_.current_target(), [](const gpu::Program&) {}, [&] { surface_.draw(); });
    MapPair nearest(context, size_, gpu::Format::rg32f, gpu::Filter::nearest);
    passes.draw(start, nearest.current_target(),
                [&](const gpu::Program& program) { program.set("source", irradiance_.current(), 0); });
    const auto flood = [&](int jump) {
      passes.draw(step, nearest.next(), [&](const gpu::Program& program) {
        program.set("nearest", nearest.current(), 0);
        program.set("jump", jump);
      });
      nearest.flip();
    };
    for (auto jump = static_cast<int>(std::bit_ceil(static_cast<unsigned>(size_))) / 2; jump > 0; jump /= 2)
      flood(jump);
    flood(1);  // mends most of what the rounds before it missed
    nearest_.emplace(nearest.take_current());
  }

  void draw_maps(Passes& passes) {
    draw_map(passes, uv_irradiance_, irradiance_);
    if (stretch_) draw_map(passes, uv_stretch_, *stretch_);
  }

  // The surface's values in texture space, and in its gutters.
  void draw_map(Passes& passes, const PassProgram& program, MapPair& map) const {
    passes.draw_geometry(
        program, map.current_target(), [](const gpu::Program&) {}, [&] { surface_.draw(); });
    if (!nearest_) return;
    passes.draw(fill_, map.next(), [&](const gpu::Program& fill) {
      fill.set("source", map.current(), 0);
      fill.set("nearest", nearest_->texture, 1);
    });
    map.flip();
  }

  void blur(Passes& passes, MapPair& map, double std_dev_mm) const {
    for (const int axis : {0, 1}) {
      passes.draw(blur_, map.next(), [&](const gpu::Program& program) {
        program.set("source", map.current(), 0);
        program.set("stretch", stretch_ ? stretch_->current() : map.current(), 1);
        program.set("axis", axis);
        program.set("std_dev_mm", std_dev_mm);
        program.set("mean_texels_per_mm", mean_texels_per_mm_);
        program.set("gain", gain_);
      });
      map.flip();
    }
  }

  void gather(Passes& passes, const Vec3d& weight) const {
    passes.draw(
        gather_, result_,
        [&](const gpu::Program& program) {
          program.set("irradiance", frame_.irradiance, 0);
          program.set("surface_uv", frame_.uv, 1);
          program.set("level", irradiance_.current(), 2);
          program.set("weight", weight);
        },
        true);
  }

  const Frame& frame_;
  const SurfaceBuffers& surface_;
  int size_;
  bool has_stretch_map_;
  bool blurs_stretch_;
  bool first_is_irradiance_;
  bool incremental_;
  double gain_;
  double mean_texels_per_mm_;
  std::vector<GaussianLevel> levels_;
  Vec3d delta_weight_;
  DeltaPass first_;
  PassProgram uv_irradiance_;
  PassProgram uv_stretch_;
  PassProgram fill_;
  PassProgram blur_;
  PassProgram gather_;
  MapPair irradiance_;
  std::optional<MapPair> stretch_;
  std::optional<Target> nearest_;
  Target result_;
};

PreparedMethod prepare(const MethodInputs& inputs) {
  const auto method = std::make_shared<TextureSpace>(inputs);
  return {[method](Passes& passes) { method->render(passes); }, &method->output()};
}

}  // namespace

Method texture_space_method() {
  Method method;
  method.name = "texture-space";
  method.title = "Texture-space diffusion";
  method.source = "d'Eon & Luebke 2007; Yang et al.";
  method.limits = {.rounding = 1e-5, .identity_per_texel = 1.42};
  method.needs_uvs = true;
  const auto words = [](std::string_view name, std::string_view help, std::vector<std::string_view> choices) {
    return SettingSpec{name, help, 0.0, 0.0, 0.0, false, std::move(choices)};
  };
  method.settings = {
      {"texture_size", "texels along each side of the maps", 1024.0, 16.0, 8192.0, true},
      words("stretch", "correction of the UV map's stretch: per texel, blurred with every level, or none",
            {"raw", "blurred", "off"}),
      words("taps", "of each axis: the published seven, made to sum to 1 or not, or every texel",
            {"seven", "seven-published", "dense"}),
      words("first_gaussian", "the first level: blurred, or the irradiance itself",
            {"blurred", "irradiance"}),
      words("gutter", "beyond a chart's edge: its nearest texel, nothing (divided out), or black",
            {"nearest", "coverage", "none"}),
      words("passes", "of each level: on the level before it, or on the irradiance drawn anew",
            {"incremental", "direct"}),
      words("reading", "of a level at a pixel", {"bilinear", "bicubic"})};
  method.own_target = [](const Profile&, const Settings&) { return OwnTarget{true, true, std::nullopt}; };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
