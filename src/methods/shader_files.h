#pragma once

#include <string>
#include <string_view>

#include "gpu/program.h"

namespace truescatter::methods {

// An embedded GLSL file of this module, by its path below src/methods/.
gpu::ShaderText shader_file(std::string_view path);

}  // namespace truescatter::methods
