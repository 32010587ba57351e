#include "irradiance/shadow_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/error.h"

namespace truescatter {
namespace {

// A ray's context, and the triangles that it passes through as if they were not there. Embree hands it on to
// the filter as its first member.
struct PassingContext {
  RTCIntersectContext context;
  std::array<unsigned, 2> passed;
};

void pass_through(const RTCFilterFunctionNArguments* arguments) {
  const auto* passing = reinterpret_cast<const PassingContext*>(arguments->context);
  for (unsigned i = 0; i < arguments->N; ++i) {
    const unsigned triangle = RTCHitN_primID(arguments->hit, arguments->N, i);
    if (triangle == passing->passed[0] || triangle == passing->passed[1]) arguments->valid[i] = 0;
  }
}

RTCRay ray_between(const Vec3d& origin_mm, const Vec3d& direction, double near_mm, double far_mm) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin_mm.x());
  ray.org_y = static_cast<float>(origin_mm.y());
  ray.org_z = static_cast<float>(origin_mm.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = static_cast<float>(near_mm);
  ray.tfar = static_cast<float>(std::min(far_mm, static_cast<double>(std::numeric_limits<float>::max())));
  ray.mask = 0xFFFFFFFFU;
  return ray;
}

// Of the triangles of one character: see ShadowScene::offset_mm.
double offset_of(const Mesh& mesh, std::size_t first, std::size_t end) {
  Eigen::AlignedBox3d box;
  for (std::size_t t = first; t < end; ++t) {
    for (int c = 0; c < 3; ++c) box.extend(mesh.corner(t, c));
  }
  const double largest_coordinate_mm = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
  return std::max(1e-4 * box.sizes().maxCoeff(), 1e-6 * largest_coordinate_mm);
}

}  // namespace

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

ShadowScene::ShadowScene(const Mesh& mesh)
    : handles_(std::make_unique<Handles>()),
      triangles_per_character_(mesh.triangle_count() / mesh.characters) {
  for (std::size_t i = 0; i < mesh.characters; ++i)
    offsets_mm_.push_back(offset_of(mesh, i * triangles_per_character_, (i + 1) * triangles_per_character_));

  handles_->device = rtcNewDevice(nullptr);
  if (handles_->device == nullptr) throw_run_error("Embree: cannot create a device");
  handles_->scene = rtcNewScene(handles_->device);
  rtcSetSceneFlags(handles_->scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST |
                                                               RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
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

double ShadowScene::largest_offset_mm() const {
  return *std::max_element(offsets_mm_.begin(), offsets_mm_.end());
}

bool ShadowScene::occluded(const Vec3d& origin_mm, const Vec3d& direction, double distance_mm) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = ray_between(origin_mm, direction, 0.0, distance_mm);
  rtcOccluded1(handles_->scene, &context, &ray);
  return ray.tfar < 0.0F;
}

bool ShadowScene::crossed_between(const Vec3d& from_mm, std::size_t from, const Vec3d& to_mm,
                                  std::size_t to) const {
  const Vec3d way = to_mm - from_mm;
  const double length_mm = way.norm();
  const double near_mm = offset_mm(from);
  const double far_mm = length_mm - offset_mm(to);
  if (far_mm <= near_mm) return false;
  PassingContext passing{};
  rtcInitIntersectContext(&passing.context);
  passing.context.filter = pass_through;
  passing.passed = {static_cast<unsigned>(from), static_cast<unsigned>(to)};
  RTCRay ray = ray_between(from_mm, way / length_mm, near_mm, far_mm);
  rtcOccluded1(handles_->scene, &passing.context, &ray);
  return ray.tfar < 0.0F;
}

}  // namespace truescatter
