#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "gpu/program.h"
#include "methods/method.h"

namespace truescatter {

// A method that a user brings as GLSL, without compiling anything. Its passes are full-screen fragment
// shaders, each into a texture of its own (four floats a pixel, of the frame's size). They are drawn and
// counted as those of built-in methods are; what they are given is told in experiments/own-shader.toml.

enum class GlslRun {
  per_gaussian,  // once for each distinct variance; what the last pass gives is weighted and added up, and
                 // w_0 I too
  per_term,      // the same for each term of the profile, whose variances differ by channel
  once,          // the last pass gives exitance
};

struct GlslPass {
  std::vector<gpu::ShaderText> texts;      // what is included, then the shader, named by their files
  std::vector<std::string> inputs;         // each a sampler of that name
  std::map<std::string, double> settings;  // uniforms of this pass alone
  SourceLocation inputs_where;
  std::map<std::string, SourceLocation> settings_where;
};

struct GlslMethod {
  std::string name;
  std::string title;
  std::string source;
  GlslRun run = GlslRun::per_gaussian;
  std::vector<GlslPass> passes;
  std::map<std::string, SourceLocation> settings_where;  // of the settings that all passes share
  OwnTarget target;
};

// Throws Error (input), at the shader's line or the experiment's: an input that there is not, a texture that
// is read past the counting, a pass without main(). The method's `check` compiles the passes, and throws for
// an input that its shader does not use, a setting that no shader has, a uniform that nothing sets or that is
// of another type.
Method glsl_method(const GlslMethod& method);

// GLSL of this project that a user's shader may include. Throws Error (input) at `where` for an unknown name.
gpu::ShaderText glsl_library(std::string_view name, const SourceLocation& where);

}  // namespace truescatter
