#include "experiment/view_buffers.h"

#include <cmath>

#include "experiment/pass_files.h"

namespace truescatter {
namespace {

using nlohmann::json;

Image depth_of(const FrameImages& images) {
  Image depth(images.mask.width(), images.mask.height(), 1);
  for (std::size_t i = 0; i < depth.pixel_count(); ++i)
    depth.data()[i] = std::abs(images.position.data()[3 * i + 2]);
  return depth;
}

void add_lights(const ReflectionPictures& pictures, std::vector<NamedTexture>& buffers) {
  for (std::size_t i = 0; i < pictures.lights.size(); ++i) {
    const SeenLight& seen = pictures.lights[i];
    const std::string number = std::to_string(i + 1);
    if (seen.light.kind == LightKind::environment) {
      buffers.push_back({"occlusion-" + number, "rgb",
                         "what occlusion leaves of the irradiance of light " + number + ", per channel",
                         seen.map});
    } else {
      buffers.push_back(
          {"light-" + number, "RGB", "irradiance of light " + number + " with its shadow", seen.map});
    }
  }
}

std::vector<NamedTexture> buffers_of(const ViewBuffers& of) {
  std::vector<NamedTexture> buffers = {
      {"irradiance", "RGB", "irradiance on the shading mesh, what every method starts from",
       of.images.irradiance},
      {"depth", "d", "distance along the view axis, mm", depth_of(of.images)},
      {"face-normal", "xyz", "unit normal of the facets, view space", of.images.face_normal},
      {"normal", "xyz", "interpolated unit normal, view space", of.images.normal}};
  if (!of.reflection.normal_map.empty()) {
    buffers.push_back(
        {"mapped-normal", "xyz", "unit normal of the normal map, view space", of.reflected.normal});
  }
  add_lights(of.reflected, buffers);
  if (!of.reflected.gloss.empty()) {
    buffers.push_back(
        {"gloss", "im", "intensity rho_s and roughness m of specular light", of.reflected.gloss});
    buffers.push_back(
        {"specular", "RGB", "specular light, pi times the reflected radiance", of.composite->specular()});
  }
  if (of.composite != nullptr)
    buffers.push_back({"albedo", "rgb", "albedo after the scattering", of.composite->albedo()});
  return buffers;
}

}  // namespace

json write_view_buffers(const std::filesystem::path& folder, const std::string& view,
                        const ViewBuffers& buffers, double exposure, const ImageTexts& origin) {
  json written = json::array();
  for (const NamedTexture& buffer : buffers_of(buffers))
    written.push_back(write_named_texture(folder, view + ".view", buffer, exposure, origin));
  return written;
}

}  // namespace truescatter
