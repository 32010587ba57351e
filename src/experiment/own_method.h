#pragma once

#include <filesystem>
#include <string>

#include "config/experiment_spec.h"
#include "core/image.h"
#include "methods/method.h"

namespace truescatter {

// Methods that an experiment brings itself: GLSL, or pictures made elsewhere.

// Reads the shaders. Throws Error (input): a name that a built-in method has, a file that is not there, a
// setting that is no number, and as glsl_method does.
Method own_method(const ExperimentSpec& spec, const MethodSpec& method);

// The picture of one view and profile: the method's path with {view} and {profile} filled in, relative to the
// experiment's file. It need not be there.
std::filesystem::path picture_path(const ExperimentSpec& spec, const MethodSpec& method,
                                   const std::string& view, const std::string& profile);

// The picture's three channels. Throws Error (input) that names the file: not there, without the layer, of
// another size than the view, a value that is not finite.
Image read_picture(const std::filesystem::path& file, const MethodSpec& method, const ViewSpec& view);

}  // namespace truescatter
