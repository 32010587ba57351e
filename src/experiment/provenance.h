#pragma once

#include <nlohmann/json.hpp>

#include "gpu/context.h"

namespace truescatter {

// Where a result comes from: version, commit (and whether it had changes), compiler, OpenGL renderer,
// machine.
nlohmann::json provenance(const gpu::Context& context);

}  // namespace truescatter
