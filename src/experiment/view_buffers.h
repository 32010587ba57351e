#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/image_io.h"
#include "experiment/scene_setup.h"
#include "experiment/view_composite.h"
#include "methods/frame.h"

namespace truescatter {

// What a view has before any method has drawn, and what its picture is composed of.
struct ViewBuffers {
  const SceneReflection& reflection;
  const ReflectionPictures& reflected;
  const FrameImages& images;
  const ViewComposite* composite;  // null without [composite]
};

// Writes them to `folder` as write_named_texture does, as <view>.view.<name>: irradiance, depth, normals, of
// every light its irradiance or what occlusion leaves of it, and with [composite] gloss, albedo and specular
// light. Returns their entries for results.json. Throws Error (run) that names the file.
nlohmann::json write_view_buffers(const std::filesystem::path& folder, const std::string& view,
                                  const ViewBuffers& buffers, double exposure, const ImageTexts& origin);

}  // namespace truescatter
