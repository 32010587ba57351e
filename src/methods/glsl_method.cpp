#include "methods/glsl_method.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <variant>

#include "methods/screen_levels.h"
#include "methods/shader_files.h"

namespace truescatter {
namespace {

constexpr std::array<const char*, 7> kInputs = {"position", "face_normal", "normal",  "irradiance",
                                                "mask",     "depth",       "previous"};

// An identifier of a shader, with its place.
struct Word {
  std::string_view text;
  SourceLocation where;
};

// The identifiers outside of comments.
std::vector<Word> words_of(const gpu::ShaderText& shader) {
  const std::string& text = shader.text;
  std::vector<Word> words;
  int line = 1;
  std::size_t line_start = 0;
  const auto skip_to = [&](std::size_t from, std::size_t end) {
    for (std::size_t i = from; i < end; ++i) {
      if (text[i] != '\n') continue;
      ++line;
      line_start = i + 1;
    }
    return end;
  };
  const auto is_part = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (std::size_t i = 0; i < text.size();) {
    if (text.compare(i, 2, "//") == 0) {
      i = skip_to(i, std::min(text.find('\n', i), text.size()));
    } else if (text.compare(i, 2, "/*") == 0) {
      const std::size_t close = text.find("*/", i + 2);
      i = skip_to(i, close == std::string::npos ? text.size() : close + 2);
    } else if (is_part(text[i])) {
      const std::size_t start = i;
      while (i < text.size() && is_part(text[i])) ++i;
      words.push_back({std::string_view(text).substr(start, i - start),
                       {shader.name, line, static_cast<int>(start - line_start) + 1}});
    } else {
      i = skip_to(i, i + 1);
    }
  }
  return words;
}

// What would read textures without being counted.
void check_reads(const gpu::ShaderText& shader) {
  for (const Word& word : words_of(shader)) {
    const bool reads = word.text.starts_with("texture") || word.text.starts_with("texelFetch");
    if (reads && word.text != "textureSize") {
      throw_input_error(
          word.where,
          "a read by {}() would be missing from the method's cost: read_texel(name, pixel) gives a "
          "texel, read_linear(name, uv) filters",
          word.text);
    }
    if (word.text.starts_with("sampler")) {
      throw_input_error(
          word.where,
          "'{}': an input is declared by SAMPLER(name); and read where it is declared: one that is "
          "passed on to a function cannot be counted",
          word.text);
    }
  }
}

void check_pass(const GlslPass& pass) {
  for (const gpu::ShaderText& text : pass.texts) check_reads(text);
  const std::vector<Word> words = words_of(pass.texts.back());
  if (std::none_of(words.begin(), words.end(), [](const Word& word) { return word.text == "main"; }))
    throw_input_error({pass.texts.back().name}, "this shader has no main()");
  for (const std::string& input : pass.inputs) {
    if (std::find(kInputs.begin(), kInputs.end(), input) == kInputs.end())
      throw_input_error(pass.inputs_where, "there is no input '{}'; there are: {}", input,
                        fmt::join(kInputs, ", "));
  }
}

using UniformValue = std::variant<double, Vec3d, std::vector<float>, std::vector<Vec3f>>;
using Uniforms = std::map<std::string, UniformValue>;

bool fits(const gpu::Uniform& uniform, const UniformValue& value) {
  const bool scalar =
      std::holds_alternative<double>(value) || std::holds_alternative<std::vector<float>>(value);
  const bool array = value.index() >= 2;
  return uniform.type == (scalar ? GL_FLOAT : GL_FLOAT_VEC3) && (array || uniform.size == 1);
}

std::string_view type_name(const UniformValue& value) {
  static constexpr std::array<std::string_view, 4> kNames = {"float", "vec3", "float[GAUSSIANS]",
                                                             "vec3[GAUSSIANS]"};
  return kNames[value.index()];
}

void set(const gpu::Program& program, const Uniforms& uniforms) {
  for (const auto& [name, value] : uniforms) {
    if (const auto* number = std::get_if<double>(&value)) program.set(name.c_str(), *number);
    if (const auto* vector = std::get_if<Vec3d>(&value)) program.set(name.c_str(), *vector);
    if (const auto* numbers = std::get_if<std::vector<float>>(&value)) program.set(name.c_str(), *numbers);
    if (const auto* vectors = std::get_if<std::vector<Vec3f>>(&value)) program.set(name.c_str(), *vectors);
  }
}

// One round of all passes: its uniforms, and what its result is weighted by.
struct Round {
  Uniforms uniforms;
  Vec3d weight = Vec3d::Ones();
};

std::vector<Round> rounds_of(GlslRun run, const Profile& profile) {
  std::vector<Round> rounds;
  const std::vector<GaussianLevel> levels = gaussian_levels(profile);
  if (run == GlslRun::per_gaussian) {
    for (const GaussianLevel& level : levels)
      rounds.push_back({{{"std_dev_mm", level.std_dev_mm()}}, level.weight});
  } else if (run == GlslRun::per_term) {
    for (const GaussianTerm& term : profile.terms)
      rounds.push_back({{{"std_dev_mm", term.std_dev_mm()}}, term.weight});
  } else {
    std::vector<float> std_devs_mm;
    std::vector<Vec3f> weights;
    for (const GaussianLevel& level : levels) {
      std_devs_mm.push_back(static_cast<float>(level.std_dev_mm()));
      weights.push_back(level.weight.cast<float>());
    }
    rounds.push_back({{{"gaussian_std_dev_mm", std_devs_mm}, {"gaussian_weight", weights}}});
  }
  for (Round& round : rounds) {
    round.uniforms["delta_weight"] = profile.delta_weight;
    round.uniforms["profile_r_max_mm"] = profile.r_max_mm;
  }
  return rounds;
}

Uniforms frame_uniforms(double focal_px, double median_skin_depth_mm) {
  return {{"focal_px", focal_px}, {"median_skin_depth_mm", median_skin_depth_mm}};
}

// A pass ready to be drawn, and those of its settings that the shader declares as whole numbers.
struct CompiledPass {
  PassProgram program;
  std::map<std::string, double> numbers;
  std::map<std::string, int> whole_numbers;
};

std::vector<std::string> names_of(const Uniforms& uniforms) {
  std::vector<std::string> names;
  for (const auto& [name, value] : uniforms) names.push_back(fmt::format("{} {}", type_name(value), name));
  return names;
}

SourceLocation place_of(const std::map<std::string, SourceLocation>& places, const std::string& name) {
  const auto at = places.find(name);
  return at != places.end() ? at->second : SourceLocation{};
}

// Compiles a method's passes one by one, and remembers what their shaders use.
class Compiler {
 public:
  Compiler(const gpu::Context& context, const GlslMethod& method, const Profile& profile,
           const Settings& settings)
      : context_(context),
        method_(method),
        settings_(settings),
        given_(rounds_of(method.run, profile).front().uniforms) {
    given_.merge(frame_uniforms(1.0, 1.0));
    defines_ = {fmt::format("GAUSSIANS {}", gaussian_levels(profile).size())};
    for (const auto& [name, value] : settings.values()) check_name(name, method.settings_where);
  }

  CompiledPass compile(const GlslPass& pass) {
    for (const auto& [name, value] : pass.settings) check_name(name, pass.settings_where);
    CompiledPass compiled{build(pass), {}, {}};
    const std::string& file = pass.texts.back().name;
    std::set<std::string> used;
    for (const gpu::Uniform& uniform : compiled.program.plain.active_uniforms()) {
      used.insert(uniform.name);
      check_uniform(uniform, pass, file, compiled);
    }
    for (const std::string& input : pass.inputs) {
      if (used.count(input) == 0)
        throw_input_error(pass.inputs_where, "the input '{}' is not used by {}", input, file);
    }
    for (const auto& [name, value] : pass.settings) {
      if (used.count(name) == 0)
        throw_input_error(place_of(pass.settings_where, name), "the setting '{}' is no uniform that {} uses",
                          name, file);
    }
    used_.merge(used);
    return compiled;
  }

  // A setting that no pass has.
  void finish() const {
    for (const auto& [name, value] : settings_.values()) {
      if (used_.count(name) == 0)
        throw_input_error(place_of(method_.settings_where, name),
                          "method '{}': the setting '{}' is no uniform that one of its shaders uses",
                          method_.name, name);
    }
  }

 private:
  void check_name(const std::string& name, const std::map<std::string, SourceLocation>& places) const {
    if (given_.count(name) > 0)
      throw_input_error(place_of(places, name), "'{}' is not for a setting: every shader is given it", name);
    if (&places != &method_.settings_where && settings_.values().count(name) > 0)
      throw_input_error(place_of(places, name), "'{}' is a setting of the whole method too", name);
  }

  PassProgram build(const GlslPass& pass) const {
    std::vector<gpu::ShaderText> texts = {{"truescatter", "#define main shader_main"}};
    texts.insert(texts.end(), pass.texts.begin(), pass.texts.end());
    texts.push_back(
        {pass.texts.back().name, "#undef main\nvoid main() {\n  shader_main();\n  WRITE_COUNTS;\n}"});
    return PassProgram::of_texts(context_, texts, defines_);
  }

  void check_uniform(const gpu::Uniform& uniform, const GlslPass& pass, const std::string& file,
                     CompiledPass& compiled) const {
    const std::string& name = uniform.name;
    if (uniform.type == GL_SAMPLER_2D) {
      if (std::find(pass.inputs.begin(), pass.inputs.end(), name) != pass.inputs.end()) return;
      throw_input_error({file}, "reads '{}', which is not among the inputs of its pass ({})", name,
                        fmt::join(pass.inputs, ", "));
    }
    if (const auto at = given_.find(name); at != given_.end()) {
      if (!fits(uniform, at->second))
        throw_input_error({file}, "the uniform '{}' must be a {} where run = \"{}\"", name,
                          type_name(at->second), run_name());
      return;
    }
    const bool own = pass.settings.count(name) > 0;
    if (!own && settings_.values().count(name) == 0) {
      throw_input_error(
          {file},
          "nothing sets the uniform '{}': give it by 'settings.{}' of the method or of the pass; given "
          "where run = \"{}\" are: {}",
          name, name, run_name(), fmt::join(names_of(given_), ", "));
    }
    const double value = own ? pass.settings.at(name) : settings_.number(name);
    const SourceLocation where = place_of(own ? pass.settings_where : method_.settings_where, name);
    if (uniform.size != 1 || (uniform.type != GL_FLOAT && uniform.type != GL_INT))
      throw_input_error({file}, "the uniform '{}' is a setting: a float or an int", name);
    if (uniform.type == GL_FLOAT) {
      compiled.numbers[name] = value;
      return;
    }
    if (value != std::floor(value) || std::abs(value) > 2147483647.0)
      throw_input_error(where, "'{}' is {}; {} declares it as an int, so it must be a whole number", name,
                        value, file);
    compiled.whole_numbers[name] = static_cast<int>(value);
  }

  std::string_view run_name() const {
    static constexpr std::array<std::string_view, 3> kNames = {"per-gaussian", "per-term", "once"};
    return kNames[static_cast<std::size_t>(method_.run)];
  }

  const gpu::Context& context_;
  const GlslMethod& method_;
  const Settings& settings_;
  Uniforms given_;
  std::vector<std::string> defines_;
  std::set<std::string> used_;
};

std::vector<CompiledPass> compile(const gpu::Context& context, const GlslMethod& method,
                                  const Profile& profile, const Settings& settings) {
  Compiler compiler(context, method, profile, settings);
  std::vector<CompiledPass> passes;
  for (const GlslPass& pass : method.passes) passes.push_back(compiler.compile(pass));
  compiler.finish();
  return passes;
}

Target frame_target(const MethodInputs& inputs, gpu::Format format) {
  return {inputs.context, inputs.frame.camera.width_px, inputs.frame.camera.height_px, format,
          gpu::Filter::linear};
}

// A part of the frame as a texture of one channel: like the frame itself no part of a method's cost.
Target frame_part(const MethodInputs& inputs, const gpu::Texture& texture,
                  const std::vector<std::string>& defines) {
  Target part = frame_target(inputs, gpu::Format::r32f);
  const PassProgram program(inputs.context, "frame/part.frag", defines);
  Passes(inputs.context).draw(program, part, [&](const gpu::Program& used) {
    used.set("frame", texture, 0);
  });
  return part;
}

struct State {
  std::shared_ptr<const GlslMethod> method;
  const Frame& frame;
  Uniforms of_frame;
  std::vector<Round> rounds;
  Vec3d delta_weight;
  std::vector<CompiledPass> passes;
  std::vector<Target> targets;  // one a pass
  DeltaPass first;
  LevelPass accumulate;
  Target result;
  Target mask;
  Target depth;

  const gpu::Texture& texture_of(const std::string& input, std::size_t pass) const {
    if (input == "position") return frame.position;
    if (input == "face_normal") return frame.face_normal;
    if (input == "normal") return frame.normal;
    if (input == "mask") return mask.texture;
    if (input == "depth") return depth.texture;
    if (input == "previous" && pass > 0) return targets[pass - 1].texture;
    assert(input == "previous" || input == "irradiance");
    return frame.irradiance;
  }

  void draw(Passes& into, std::size_t round_index) const {
    const Round& round = rounds[round_index];
    for (std::size_t i = 0; i < passes.size(); ++i) {
      into.draw(passes[i].program, targets[i], [&](const gpu::Program& program) {
        int unit = 0;
        for (const std::string& input : method->passes[i].inputs)
          program.set(input.c_str(), texture_of(input, i), unit++);
        set(program, of_frame);
        set(program, round.uniforms);
        for (const auto& [name, value] : passes[i].numbers) program.set(name.c_str(), value);
        for (const auto& [name, value] : passes[i].whole_numbers) program.set(name.c_str(), value);
      });
      const std::string name = fmt::format("pass-{}", i + 1);
      into.show(targets[i].texture,
                rounds.size() == 1 ? name : fmt::format("round-{}-{}", round_index + 1, name), "RGB",
                "what the pass draws");
    }
  }

  void render(Passes& into) const {
    if (method->run == GlslRun::once) {
      draw(into, 0);
      return;
    }
    first.draw(into, frame, delta_weight, result);
    for (std::size_t i = 0; i < rounds.size(); ++i) {
      draw(into, i);
      accumulate.draw(into, frame, targets.back().texture, rounds[i].weight, result);
    }
  }
};

PreparedMethod prepare(const std::shared_ptr<const GlslMethod>& method, const MethodInputs& inputs) {
  std::vector<Target> targets;
  for (std::size_t i = 0; i < method->passes.size(); ++i)
    targets.push_back(frame_target(inputs, gpu::Format::rgba32f));
  const auto state = std::make_shared<const State>(State{
      method, inputs.frame, frame_uniforms(inputs.frame.camera.focal_px(), inputs.median_skin_depth_mm),
      rounds_of(method->run, inputs.profile), inputs.profile.delta_weight,
      compile(inputs.context, *method, inputs.profile, inputs.settings), std::move(targets),
      DeltaPass(inputs.context), LevelPass(inputs.context), frame_target(inputs, gpu::Format::rgba32f),
      frame_part(inputs, inputs.frame.irradiance, {}), frame_part(inputs, inputs.frame.position, {"DEPTH"})});
  const gpu::Texture* output =
      method->run == GlslRun::once ? &state->targets.back().texture : &state->result.texture;
  return {[state](Passes& passes) { state->render(passes); }, output};
}

}  // namespace

Method glsl_method(const GlslMethod& method) {
  for (const GlslPass& pass : method.passes) check_pass(pass);
  const auto shared = std::make_shared<const GlslMethod>(method);
  Method made;
  made.name = method.name;
  made.title = method.title;
  made.source = method.source;
  // A target for each pass, the result, the mask and the depth.
  made.memory = {.bytes_per_pixel = 16.0 * (static_cast<double>(method.passes.size()) + 3.0)};
  made.own_target = [target = method.target](const Profile&, const Settings&) { return target; };
  made.prepare = [shared](const MethodInputs& inputs) { return prepare(shared, inputs); };
  made.check = [shared](const gpu::Context& context, const Profile& profile, const Settings& settings) {
    compile(context, *shared, profile, settings);
  };
  return made;
}

gpu::ShaderText glsl_library(std::string_view name, const SourceLocation& where) {
  static constexpr std::array<std::string_view, 1> kFiles = {"filter_geometry.glsl"};
  if (std::find(kFiles.begin(), kFiles.end(), name) == kFiles.end())
    throw_input_error(where, "there is no builtin:{}; there are: {}", name, fmt::join(kFiles, ", "));
  return methods::shader_file(name);
}

}  // namespace truescatter
