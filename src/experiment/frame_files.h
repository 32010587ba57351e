#pragma once

#include <filesystem>
#include <string>

#include "core/image_io.h"
#include "methods/frame.h"

namespace truescatter {

// Writes what methods are given of a view into `folder`, which must be there, for renderers elsewhere:
// <view>.exr with the layers position, face_normal, normal, irradiance, mask and depth, and <view>.json with
// the camera, what the layers hold and `origin` (see picture_origin), which the EXR carries too. Throws Error
// (run) that names the file.
void write_frame(const std::filesystem::path& folder, const std::string& view, const Camera& camera,
                 const FrameImages& images, const ImageTexts& origin);

}  // namespace truescatter
