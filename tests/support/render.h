#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gpu/context.h"
#include "irradiance/shading_mesh.h"
#include "methods/method.h"
#include "scene/builtin.h"
#include "support/lamp.h"

namespace truescatter::test {

inline ShadingMesh shade(const Mesh& mesh, const Light& light) {
  return make_shading_mesh(mesh, Lighting(mesh, {light}), SkinMask(), {0.02, 0.5});
}

inline Camera camera_at(double distance_mm, double height_mm, int px) {
  Camera camera;
  camera.eye_mm = Vec3d(0.0, 0.0, distance_mm);
  camera.fov_y_deg = 2.0 * std::atan(0.5 * height_mm / distance_mm) * 180.0 / kPi;
  camera.width_px = px;
  camera.height_px = px;
  return camera;
}

// A rendered view, on a context that all tests of a process share. Without light fields no method knows where
// light comes from.
class Scene {
 public:
  Scene(ShadingMesh shading, const Camera& camera, const std::vector<LightField>& lights = {})
      : shading_(std::move(shading)),
        buffers_(context(), shading_, lights),
        frame_(render_frame(context(), buffers_, shading_, camera)),
        images_(read_frame(context(), frame_)) {}

  static const gpu::Context& context() {
    static const gpu::Context shared;
    return shared;
  }

  const ShadingMesh& shading() const { return shading_; }
  const Frame& frame() const { return frame_; }
  const FrameImages& images() const { return images_; }

  Image run(const Method& method, const Profile& profile,
            const std::map<std::string, SettingValue>& given = {}) const {
    const Settings settings(method.name, method.settings, given);
    const PreparedMethod prepared =
        method.prepare({context(), frame_, buffers_, median_skin_depth_mm(images_), profile, settings});
    Passes passes(context());
    prepared.render(passes);
    return gpu::read_texture(context(), *prepared.output, 3);
  }

 private:
  ShadingMesh shading_;
  SurfaceBuffers buffers_;
  Frame frame_;
  FrameImages images_;
};

}  // namespace truescatter::test
