#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/image_io.h"
#include "methods/passes.h"

namespace truescatter {

// Writes a texture that a method has named to <stem>.<its name>.exr and .png in `folder`, which must be
// there, and returns its entry for results.json. The EXR holds its numbers, a channel by each of its letters.
// The PNG shows light as every picture of a run, by `exposure`; other numbers (magnitudes of the first
// channels as red, green and blue) with the 99 % quantile of these, rounded up to 1, 2 or 5 times a power of
// ten, as white. Both carry `origin` (see picture_origin). Throws Error (run) that names the file.
nlohmann::json write_named_texture(const std::filesystem::path& folder, const std::string& stem,
                                   const NamedTexture& texture, double exposure, const ImageTexts& origin);

}  // namespace truescatter
