#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "methods/method.h"
#include "methods/screen_levels.h"

namespace truescatter {

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

// A character that skin in view belongs to.
struct SeenCharacter {
  std::size_t index = 0;               // from 0
  std::optional<PixelBox> box = {};    // of its pixels; none: the scene has no other, and all count
  std::optional<Target> nearest = {};  // the nearest texel on skin of every texel, where gutters are filled
};

// The screen passes of texture space, each over the pixels of one character (drawn_pixel.glsl).
struct CharacterPass {
  // `pieces` follow drawn_pixel.glsl, which declares `irradiance`.
  CharacterPass(const MethodInputs& inputs, std::vector<std::string> pieces,
                std::vector<std::string> defines);

  // `set_uniforms` has the samplers from unit 2 on; outside the character's box nothing is written.
  void draw(Passes& passes, const SeenCharacter& character, const Target& target,
            const Passes::SetUniforms& set_uniforms, bool add = false) const;

 private:
  const Frame& frame_;
  PassProgram program_;
};

// The blurs of texture-space diffusion, level by level: see texture_space.frag. Its settings are `inputs`'.
// A scene's characters share one UV map, so each has its run, one after the other, through the same maps.
class UvDiffusion {
 public:
  // With `blurs_alpha` alpha is blurred with the irradiance, else it is 1 on what is blurred; either way it
  // is above 0 where a map has something, and only there. Coverage, as a gutter, needs alpha for itself.
  UvDiffusion(const MethodInputs& inputs, bool blurs_alpha);

  // Those in view, in the order of the scene.
  const std::vector<SeenCharacter>& characters() const { return characters_; }

  // Draws the surface of the character that is asked for, laid out in texture space, into a cleared map.
  using DrawSurface = std::function<void(Passes&, const Target&)>;
  // What a level is to its user: its index among the profile's gaussian_levels.
  using UseLevel = std::function<void(std::size_t)>;

  // A map of its own, gutters filled.
  Target make_map(Passes& passes, const SeenCharacter& character, const DrawSurface& draw) const;

  // What a run blurs: what `draw` draws of a character.
  struct Source {
    const SeenCharacter& character;
    DrawSurface draw;
    std::string light = {};  // names the light that it is of, where a frame blurs several apart
  };
  // What the names of a character's textures under a light begin with; empty where a frame has one of each.
  static std::string prefix(const SeenCharacter& character, const std::string& light);

  // Blurs it to every level in turn, and names each (Passes::show). current() is level i when after(i) is
  // called; when before(i) is, the level before it, and the unblurred map for the first.
  void run(Passes& passes, const Source& source, const UseLevel& before, const UseLevel& after);

  const gpu::Texture& current() const { return irradiance_.current(); }
  // Texels per mm along u and v (rg); null where the setting is off, and the mean stands for it.
  const gpu::Texture* stretch() const { return stretch_ ? &stretch_->current() : nullptr; }
  double mean_texels_per_mm() const { return mean_texels_per_mm_; }
  const std::vector<GaussianLevel>& levels() const { return levels_; }

 private:
  void find_nearest(const gpu::Context& context, SeenCharacter& character);
  void draw_maps(Passes& passes, const Source& source);
  void draw_map(Passes& passes, const SeenCharacter& character, const DrawSurface& draw, MapPair& map) const;
  void blur(Passes& passes, MapPair& map, double std_dev_mm) const;
  void show(Passes& passes, const Source& source, std::size_t level) const;

  const SurfaceBuffers& surface_;
  int size_;
  bool has_stretch_map_;
  bool blurs_stretch_;
  bool first_is_irradiance_;
  bool incremental_;
  double gain_;
  double mean_texels_per_mm_;
  std::vector<GaussianLevel> levels_;
  PassProgram uv_stretch_;
  PassProgram fill_;
  PassProgram blur_;
  std::vector<SeenCharacter> characters_;
  MapPair irradiance_;
  std::optional<MapPair> stretch_;
};

// Adds a level, read at each pixel's uv and times its weight, to a result, on a character's pixels
// (gather.frag).
class GatherPass {
 public:
  explicit GatherPass(const MethodInputs& inputs);

  void draw(Passes& passes, const SeenCharacter& character, const gpu::Texture& level, const Vec3d& weight,
            const Target& to) const;

 private:
  const gpu::Texture& uv_;
  CharacterPass program_;
};

// The defines of read_level.glsl.
std::vector<std::string> reading_defines(const Settings& settings);

// The settings of UvDiffusion and GatherPass.
std::vector<SettingSpec> uv_diffusion_settings();

}  // namespace truescatter
