#pragma once

#include <filesystem>
#include <string>

#include "methods/frame.h"

namespace truescatter {

// Writes what methods are given of a view into `folder`, which must be there, for renderers elsewhere:
// <view>.exr with the layers position, face_normal, normal, irradiance, mask and depth, and <view>.json with
// the camera and what the layers hold. Throws Error (run) that names the file.
void write_frame(const std::filesystem::path& folder, const std::string& view, const Camera& camera,
                 const FrameImages& images);

}  // namespace truescatter
