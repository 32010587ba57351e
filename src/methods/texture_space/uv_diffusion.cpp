#include "methods/texture_space/uv_diffusion.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

namespace truescatter {
namespace {

MapPair rgba_maps(const gpu::Context& context, int size) {
  return {context, size, gpu::Format::rgba32f, gpu::Filter::linear};
}

std::vector<std::string> blur_defines(const Settings& settings, bool blurs_alpha) {
  std::vector<std::string> defines;
  if (settings.word("taps") == "dense") defines.emplace_back("DENSE");
  if (settings.word("gutter") == "coverage") defines.emplace_back("COVERAGE");
  if (blurs_alpha) defines.emplace_back("BLURS_ALPHA");
  return defines;
}

std::vector<std::string> gather_defines(const Settings& settings) {
  std::vector<std::string> defines = reading_defines(settings);
  if (settings.word("gutter") == "coverage") defines.emplace_back("COVERAGE");
  return defines;
}

void no_uniforms(const gpu::Program&) {}

// The characters that skin in view belongs to.
std::vector<SeenCharacter> seen_characters(const MethodInputs& inputs) {
  const std::size_t count = inputs.surface.character_count();
  std::vector<SeenCharacter> seen;
  if (count == 1) {
    seen.emplace_back();
    return seen;
  }
  const Image numbers = gpu::read_texture(inputs.context, inputs.frame.character, 1);
  std::vector<Eigen::AlignedBox2i> boxes(count);
  for (int y = 0; y < numbers.height(); ++y) {
    for (int x = 0; x < numbers.width(); ++x) {
      const auto number = static_cast<std::size_t>(numbers.at(x, y, 0));
      if (number > 0) boxes[number - 1].extend(Eigen::Vector2i(x, numbers.height() - 1 - y));
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (boxes[i].isEmpty()) continue;
    const Eigen::Vector2i low = boxes[i].min();
    const Eigen::Vector2i size = boxes[i].sizes() + Eigen::Vector2i::Ones();
    seen.push_back({i, PixelBox{low.x(), low.y(), size.x(), size.y()}});
  }
  return seen;
}

std::vector<std::string> after_drawn_pixel(std::vector<std::string> pieces) {
  pieces.insert(pieces.begin(), "texture_space/drawn_pixel.glsl");
  return pieces;
}

std::vector<std::string> with_characters(const MethodInputs& inputs, std::vector<std::string> defines) {
  if (inputs.surface.character_count() > 1) defines.emplace_back("CHARACTERS");
  return defines;
}

}  // namespace

CharacterPass::CharacterPass(const MethodInputs& inputs, std::vector<std::string> pieces,
                             std::vector<std::string> defines)
    : frame_(inputs.frame),
      program_(PassProgram::of_pieces(inputs.context, {}, after_drawn_pixel(std::move(pieces)),
                                      with_characters(inputs, std::move(defines)))) {}

void CharacterPass::draw(Passes& passes, const SeenCharacter& character, const Target& target,
                         const Passes::SetUniforms& set_uniforms, bool add) const {
  passes.draw(
      program_, target,
      [&](const gpu::Program& program) {
        program.set("irradiance", frame_.irradiance, 0);
        if (character.box) {
          program.set("character", frame_.character, 1);
          program.set("drawn", static_cast<float>(character.index + 1));
        }
        set_uniforms(program);
      },
      add, character.box ? &*character.box : nullptr);
}

UvDiffusion::UvDiffusion(const MethodInputs& inputs, bool blurs_alpha)
    : surface_(inputs.surface),
      size_(inputs.settings.whole("texture_size")),
      has_stretch_map_(inputs.settings.word("stretch") != "off"),
      blurs_stretch_(inputs.settings.word("stretch") == "blurred"),
      first_is_irradiance_(inputs.settings.word("first_gaussian") == "irradiance"),
      incremental_(inputs.settings.word("passes") == "incremental"),
      gain_(inputs.settings.word("taps") == "seven-published" ? 1.001 : 1.0),
      mean_texels_per_mm_(has_stretch_map_ ? 0.0 : size_ / inputs.surface.mean_mm_per_uv_unit()),
      levels_(gaussian_levels(inputs.profile)),
      uv_stretch_(inputs.context, "texture_space/uv_irradiance.vert", "texture_space/uv_stretch.frag", {}),
      fill_(inputs.context, "texture_space/fill_gutter.frag"),
      blur_(inputs.context, "texture_space/texture_space.frag", blur_defines(inputs.settings, blurs_alpha)),
      characters_(seen_characters(inputs)),
      irradiance_(rgba_maps(inputs.context, size_)) {
  if (has_stretch_map_) stretch_.emplace(rgba_maps(inputs.context, size_));
  if (inputs.settings.word("gutter") != "nearest") return;
  for (SeenCharacter& character : characters_) find_nearest(inputs.context, character);
}

Target UvDiffusion::make_map(Passes& passes, const SeenCharacter& character, const DrawSurface& draw) const {
  MapPair map = rgba_maps(passes.context(), size_);
  draw_map(passes, character, draw, map);
  return map.take_current();
}

void UvDiffusion::run(Passes& passes, const Source& source, const UseLevel& before, const UseLevel& after) {
  draw_maps(passes, source);
  show(passes, source, 0);
  double previous_variance_mm2 = 0.0;
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    before(i);
    if (!incremental_ && i > 0) draw_maps(passes, source);
    if (!(i == 0 && first_is_irradiance_)) {
      const double std_dev_mm = std::sqrt(levels_[i].variance_mm2 - previous_variance_mm2);
      if (blurs_stretch_) blur(passes, *stretch_, std_dev_mm);
      blur(passes, irradiance_, std_dev_mm);
    }
    show(passes, source, i + 1);
    after(i);
    if (incremental_) previous_variance_mm2 = levels_[i].variance_mm2;
  }
}

// The nearest texel on skin of every texel; once, for texture coordinates do not change. Each character has
// its own, for its mask is refined along with its light.
void UvDiffusion::find_nearest(const gpu::Context& context, SeenCharacter& character) {
  const PassProgram start(context, "texture_space/nearest_start.frag");
  const PassProgram step(context, "texture_space/nearest_step.frag");
  Passes passes(context);
  passes.draw_geometry(uv_stretch_, irradiance_.current_target(), no_uniforms,
                       [&] { surface_.draw_character(character.index); });
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
  character.nearest.emplace(nearest.take_current());
}

void UvDiffusion::draw_maps(Passes& passes, const Source& source) {
  draw_map(passes, source.character, source.draw, irradiance_);
  if (!stretch_) return;
  const auto draw_stretch = [&](Passes& to, const Target& target) {
    to.draw_geometry(uv_stretch_, target, no_uniforms,
                     [&] { surface_.draw_character(source.character.index); });
  };
  draw_map(passes, source.character, draw_stretch, *stretch_);
}

std::string UvDiffusion::prefix(const SeenCharacter& character, const std::string& light) {
  const std::string whose = character.box ? fmt::format("character-{}-", character.index + 1) : "";
  return whose + (light.empty() ? "" : light + "-");
}

// Names a level's maps; level 0 is what is drawn, unblurred. A stretch map that is not blurred stays that.
void UvDiffusion::show(Passes& passes, const Source& source, std::size_t level) const {
  const std::string whose = prefix(source.character, source.light);
  passes.show(irradiance_.current(), fmt::format("{}level-{}", whose, level), "RGB",
              level == 0 ? "irradiance in texture space" : "irradiance in texture space, blurred");
  if (stretch_ && (level == 0 || blurs_stretch_))
    passes.show(stretch_->current(), fmt::format("{}stretch-{}", whose, level), "uv",
                "texels per mm along u and v");
}

// The surface's values in texture space, and in its gutters.
void UvDiffusion::draw_map(Passes& passes, const SeenCharacter& character, const DrawSurface& draw,
                           MapPair& map) const {
  draw(passes, map.current_target());
  if (!character.nearest) return;
  passes.draw(fill_, map.next(), [&](const gpu::Program& fill) {
    fill.set("source", map.current(), 0);
    fill.set("nearest", character.nearest->texture, 1);
  });
  map.flip();
}

void UvDiffusion::blur(Passes& passes, MapPair& map, double std_dev_mm) const {
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

GatherPass::GatherPass(const MethodInputs& inputs)
    : uv_(inputs.frame.uv),
      program_(inputs, {"texture_space/read_level.glsl", "texture_space/gather.frag"},
               gather_defines(inputs.settings)) {}

void GatherPass::draw(Passes& passes, const SeenCharacter& character, const gpu::Texture& level,
                      const Vec3d& weight, const Target& to) const {
  program_.draw(
      passes, character, to,
      [&](const gpu::Program& program) {
        program.set("surface_uv", uv_, 2);
        program.set("level", level, 3);
        program.set("weight", weight);
      },
      true);
}

std::vector<std::string> reading_defines(const Settings& settings) {
  return settings.word("reading") == "bicubic" ? std::vector<std::string>{"BICUBIC"}
                                               : std::vector<std::string>{};
}

std::vector<SettingSpec> uv_diffusion_settings() {
  const auto words = [](std::string_view name, std::string_view help, std::vector<std::string_view> choices) {
    return SettingSpec{name, help, 0.0, 0.0, 0.0, false, std::move(choices)};
  };
  return {{"texture_size", "texels along each side of the maps", 1024.0, 16.0, 8192.0, true},
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
}

}  // namespace truescatter
