#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <vector>

#include "methods/texture_space/uv_diffusion.h"

namespace truescatter {
namespace {

// The manual stands at the head of texture_space_transmit.frag.
class TextureSpaceTransmit {
 public:
  explicit TextureSpaceTransmit(const MethodInputs& inputs)
      : frame_(inputs.frame),
        surface_(inputs.surface),
        delta_weight_(inputs.profile.delta_weight),
        texture_size_(inputs.settings.whole("texture_size")),
        decay_per_mm_(inputs.settings.number("decay_per_mm")),
        blend_std_devs_(inputs.settings.number("blend_std_devs")),
        thickness_(inputs.settings.word("thickness")),
        diffusion_(inputs, true),
        first_transmitting_(
            first_transmitting(diffusion_.levels().size(), inputs.settings.whole("transmitting_gaussians"))),
        first_(inputs.context),
        gather_(inputs),
        draw_unlit_(inputs.context, "texture_space/uv_irradiance.vert", "texture_space/uv_irradiance.frag",
                    {}),
        draw_shadow_map_(light_pass(inputs.context, "frame/gbuffer.vert", "shadow_map.frag", {})),
        draw_lit_(light_pass(inputs.context, "frame/gbuffer.vert", "uv_thickness.frag",
                             lit_defines(inputs.settings))),
        find_entry_(inputs, {"texture_space_transmit/light_path.glsl", "texture_space_transmit/entry.frag"},
                    {}),
        read_thickness_(inputs, {"texture_space_transmit/thickness.frag"}, {}),
        transmit_(inputs,
                  {"texture_space/read_level.glsl", "texture_space_transmit/texture_space_transmit.frag"},
                  transmit_defines(inputs.settings)),
        shadow_map_(shadow_map(inputs.context, inputs.settings.whole("shadow_map_size"))),
        entry_(screen_target(inputs, gpu::Format::rgba32f)),
        pixel_thickness_(screen_target(inputs, gpu::Format::r32f)),
        result_(screen_target(inputs, gpu::Format::rgba32f)) {
    if (inputs.settings.word("normal_correction") != "on") return;
    for (const SeenCharacter& character : diffusion_.characters())
      normals_.push_back(normal_map(inputs.context, character));
  }

  const gpu::Texture& output() const { return result_.texture; }

  void render(Passes& passes) {
    first_.draw(passes, frame_, delta_weight_, result_);
    const std::vector<SeenCharacter>& characters = diffusion_.characters();
    for (std::size_t i = 0; i < characters.size(); ++i) {
      const SeenCharacter& character = characters[i];
      for (std::size_t part = 0; part < surface_.part_count(); ++part) {
        if (const LightView* light = surface_.part_light(part, character.index)) {
          const gpu::Texture* normals = normals_.empty() ? nullptr : &normals_[i].texture;
          add_lit(passes, {character, part, *light, normals});
        } else {
          add_unlit(passes, character, part);
        }
      }
    }
  }

 private:
  // What one light gives of one character.
  struct LitPart {
    const SeenCharacter& character;
    std::size_t part;
    const LightView& light;
    const gpu::Texture* normals;  // in texture space; null: thickness is not corrected
  };

  // Stands for exp(-decay t) where no light comes through: above 0, for what is on skin has alpha.
  static constexpr const char* kNoneDefine = "kNone 1e-30";

  static std::size_t first_transmitting(std::size_t levels, int transmitting) {
    return levels - std::min(levels, static_cast<std::size_t>(transmitting));
  }

  static PassProgram light_pass(const gpu::Context& context, std::string_view vertex,
                                const std::string& fragment, const std::vector<std::string>& defines) {
    return PassProgram::of_pieces(
        context, vertex, {"texture_space_transmit/light_path.glsl", "texture_space_transmit/" + fragment},
        defines);
  }

  static std::vector<std::string> lit_defines(const Settings& settings) {
    std::vector<std::string> defines = {"UV_SPACE", kNoneDefine};
    if (settings.word("normal_correction") == "on") defines.emplace_back("CORRECTED");
    return defines;
  }

  static std::vector<std::string> transmit_defines(const Settings& settings) {
    std::vector<std::string> defines = reading_defines(settings);
    defines.emplace_back(kNoneDefine);
    return defines;
  }

  static Target shadow_map(const gpu::Context& context, int size) {
    return Target::with_depth(context, size, size, gpu::Format::rgba32f);
  }

  static Target screen_target(const MethodInputs& inputs, gpu::Format format) {
    return {inputs.context, inputs.frame.camera.width_px, inputs.frame.camera.height_px, format};
  }

  // Once, for it does not change: an object-space normal map in its source.
  Target normal_map(const gpu::Context& context, const SeenCharacter& character) const {
    const PassProgram program(context, "frame/gbuffer.vert", "texture_space_transmit/uv_normal.frag",
                              {"UV_SPACE"});
    Passes passes(context);
    return diffusion_.make_map(passes, character, [&](Passes& to, const Target& map) {
      to.draw_geometry(
          program, map, [](const gpu::Program& used) { used.set("view", Mat4d(Mat4d::Identity())); },
          [&] { surface_.draw_character(character.index); });
    });
  }

  // Of the textures that are named on the way: parts are numbered as the lights that are followed, and what
  // is left comes last.
  std::string light_name(std::size_t part) const {
    return surface_.part_count() == 1 ? "" : fmt::format("light-{}", part + 1);
  }

  std::string prefix_of(const LitPart& lit) const {
    return UvDiffusion::prefix(lit.character, light_name(lit.part));
  }

  void add_unlit(Passes& passes, const SeenCharacter& character, std::size_t part) {
    const auto draw = [&](Passes& to, const Target& map) {
      to.draw_geometry(
          draw_unlit_, map, [](const gpu::Program&) {}, [&] { surface_.draw_part(part, character.index); });
    };
    diffusion_.run(
        passes, {character, draw, light_name(part)}, [](std::size_t) {},
        [&](std::size_t level) { gather(passes, character, level); });
  }

  void add_lit(Passes& passes, const LitPart& lit) {
    const SeenCharacter& character = lit.character;
    passes.draw_geometry(
        draw_shadow_map_, shadow_map_, [&](const gpu::Program& program) { set_light(program, lit.light); },
        [&] { surface_.draw_character(character.index); });
    const auto draw = [&](Passes& to, const Target& map) {
      to.draw_geometry(
          draw_lit_, map,
          [&](const gpu::Program& program) {
            set_light(program, lit.light);
            program.set("shadow_map", shadow_map_.texture, 0);
            program.set("surface_normal", lit.normals != nullptr ? *lit.normals : shadow_map_.texture, 1);
            program.set("decay_per_mm", decay_per_mm_);
          },
          [&] { surface_.draw_part(lit.part, character.index); });
    };
    const auto before = [&](std::size_t level) {
      if (level == 0) find_entries(passes, lit);
      if (thickness_ == "unblurred" ? level == 0 : thickness_ == "level-before" && transmits(level))
        read_thickness(passes, lit);
    };
    const auto after = [&](std::size_t level) {
      gather(passes, character, level);
      if (!transmits(level)) return;
      if (thickness_ == "same-level") read_thickness(passes, lit);
      transmit(passes, character, level);
    };
    diffusion_.run(passes, {character, draw, light_name(lit.part)}, before, after);
  }

  bool transmits(std::size_t level) const { return level >= first_transmitting_; }

  static void set_light(const gpu::Program& program, const LightView& light) {
    program.set("view", light.view);
    program.set("projection", light.projection);
    program.set("point_light", light.point ? 1 : 0);
  }

  void find_entries(Passes& passes, const LitPart& lit) const {
    find_entry_.draw(passes, lit.character, entry_, [&](const gpu::Program& program) {
      const gpu::Texture* stretch = diffusion_.stretch();
      program.set("position", frame_.position, 2);
      program.set("surface_uv", frame_.uv, 3);
      program.set("shadow_map", shadow_map_.texture, 4);
      program.set("stretch", stretch != nullptr ? *stretch : diffusion_.current(), 5);
      program.set("view_to_light", Mat4d(lit.light.view * frame_.view.inverse()));
      program.set("projection", lit.light.projection);
      program.set("point_light", lit.light.point ? 1 : 0);
      program.set("mean_texels_per_mm", diffusion_.mean_texels_per_mm());
      program.set("texture_size", static_cast<double>(texture_size_));
    });
    passes.show(shadow_map_.texture, prefix_of(lit) + "shadow-map", "zuvt",
                "what the light meets first: distance in mm, u, v, and 1 where light gets in");
    passes.show(entry_.texture, prefix_of(lit) + "entry", "uvde",
                "where a pixel's light enters: u, v, distance in texture space in mm, and 1 where it does");
  }

  void read_thickness(Passes& passes, const LitPart& lit) const {
    read_thickness_.draw(passes, lit.character, pixel_thickness_, [&](const gpu::Program& program) {
      program.set("surface_uv", frame_.uv, 2);
      program.set("level", diffusion_.current(), 3);
    });
    passes.show(pixel_thickness_.texture, prefix_of(lit) + "thickness", "t",
                "exp(-decay t), t being the way through the body");
  }

  void gather(Passes& passes, const SeenCharacter& character, std::size_t level) const {
    gather_.draw(passes, character, diffusion_.current(), diffusion_.levels()[level].weight, result_);
  }

  void transmit(Passes& passes, const SeenCharacter& character, std::size_t level) const {
    const GaussianLevel& gaussian = diffusion_.levels()[level];
    transmit_.draw(
        passes, character, result_,
        [&](const gpu::Program& program) {
          program.set("entry", entry_.texture, 2);
          program.set("thickness", pixel_thickness_.texture, 3);
          program.set("level", diffusion_.current(), 4);
          program.set("decay_per_mm", decay_per_mm_);
          program.set("variance_mm2", gaussian.variance_mm2);
          program.set("blend_mm", blend_std_devs_ * gaussian.std_dev_mm());
          program.set("weight", gaussian.weight);
        },
        true);
  }

  const Frame& frame_;
  const SurfaceBuffers& surface_;
  Vec3d delta_weight_;
  int texture_size_;
  double decay_per_mm_;
  double blend_std_devs_;
  std::string thickness_;
  UvDiffusion diffusion_;
  std::size_t first_transmitting_;
  DeltaPass first_;
  GatherPass gather_;
  PassProgram draw_unlit_;
  PassProgram draw_shadow_map_;
  PassProgram draw_lit_;
  CharacterPass find_entry_;
  CharacterPass read_thickness_;
  CharacterPass transmit_;
  Target shadow_map_;
  Target entry_;
  Target pixel_thickness_;
  Target result_;
  std::vector<Target> normals_;  // in texture space, of each character in view; none: not wanted
};

PreparedMethod prepare(const MethodInputs& inputs) {
  const auto method = std::make_shared<TextureSpaceTransmit>(inputs);
  return {[method](Passes& passes) { method->render(passes); }, &method->output()};
}

std::vector<SettingSpec> settings() {
  std::vector<SettingSpec> specs = uv_diffusion_settings();
  for (SettingSpec& spec : specs) {
    if (spec.name != "gutter") continue;
    spec.help = "beyond a chart's edge: its nearest texel, or black";
    spec.choices = {"nearest", "none"};  // alpha holds the thickness, not the coverage
  }
  const auto words = [](std::string_view name, std::string_view help, std::vector<std::string_view> choices) {
    return SettingSpec{name, help, 0.0, 0.0, 0.0, false, std::move(choices)};
  };
  specs.push_back({"shadow_map_size", "texels along each side of a light's map", 1024.0, 16.0, 8192.0, true});
  specs.push_back(
      {"transmitting_gaussians", "the widest of them, whose light comes through", 3.0, 0.0, 64.0, true});
  specs.push_back(words("thickness", "of a Gaussian: blurred as the level before it is, as its own, or not",
                        {"level-before", "same-level", "unblurred"}));
  specs.push_back(words("normal_correction",
                        "of the way through the body to the thickness, where normals oppose", {"on", "off"}));
  specs.push_back({"blend_std_devs",
                   "UV distance of entry and exit, in widths, from which light counts in full; 0: any", 6.0,
                   0.0, 100.0});
  specs.push_back({"decay_per_mm", "thickness t is stored as exp(-decay t)", 0.2, 0.01, 1.0});
  return specs;
}

}  // namespace

Method texture_space_transmit_method() {
  Method method;
  method.name = "texture-space-transmit";
  method.title = "Texture-space diffusion with translucent shadow maps";
  method.source = "d'Eon & Luebke 2007; the walkthrough";
  method.limits = {.rounding = 1e-5, .identity_per_texel = 1.42};
  // As texture-space, with thickness on the screen; a shadow map with its depth, light and normals.
  method.memory = {.bytes_per_pixel = 3.0 * 16.0, .bytes_per_texel = 6.0 * 2.0 * 16.0};
  method.needs_uvs = true;
  method.settings = settings();
  method.own_target = [](const Profile&, const Settings&) {
    return OwnTarget{.geodesic = true, .transmittance = true};
  };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
