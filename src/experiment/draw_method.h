#pragma once

#include "core/image.h"
#include "methods/method.h"

namespace truescatter {

// The exitance that a method gives of a frame: prepared, drawn once, untimed. Throws Error: as preparing it
// does; (run) where OpenGL reports an error.
Image draw_method(const Method& method, const MethodInputs& inputs);

}  // namespace truescatter
