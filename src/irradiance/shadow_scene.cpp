#include "irradiance/shadow_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>

#include "core/error.h"

namespace truescatter {

struct ShadowScene::Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  Handles() = default;
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

ShadowScene::ShadowScene(const Mesh& mesh) : handles_(std::make_unique<Handles>()) {
  Eigen::AlignedBox3d box;
  for (const Vec3d& p : mesh.positions_mm) box.extend(p);
  offset_mm_ = 1e-4 * box.sizes().maxCoeff();

  handles_->device = rtcNewDevice(nullptr);
  if (handles_->device == nullptr) throw_run_error("Embree: cannot create a device");
  handles_->scene = rtcNewScene(handles_->device);
  rtcSetSceneFlags(handles_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions_mm.size()));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
  if (vertices == nullptr || indices == nullptr) throw_run_error("Embree: out of memory");
  for (const Vec3d& p : mesh.positions_mm) {
    for (int c = 0; c < 3; ++c) *vertices++ = static_cast<float>(p[c]);
  }
  for (const auto& triangle : mesh.triangles) {
    for (const int v : triangle) *indices++ = static_cast<unsigned>(v);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(handles_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(handles_->scene);
  if (rtcGetDeviceError(handles_->device) != RTC_ERROR_NONE)
    throw_run_error("Embree: cannot build the scene");
}

ShadowScene::~ShadowScene() = default;
ShadowScene::ShadowScene(ShadowScene&&) noexcept = default;
ShadowScene& ShadowScene::operator=(ShadowScene&&) noexcept = default;

bool ShadowScene::occluded(const Vec3d& origin_mm, const Vec3d& direction, double distance_mm) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin_mm.x());
  ray.org_y = static_cast<float>(origin_mm.y());
  ray.org_z = static_cast<float>(origin_mm.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = 0.0F;
  ray.tfar =
      static_cast<float>(std::min(distance_mm, static_cast<double>(std::numeric_limits<float>::max())));
  ray.mask = 0xFFFFFFFFU;
  rtcOccluded1(handles_->scene, &context, &ray);
  return ray.tfar < 0.0F;
}

}  // namespace truescatter
