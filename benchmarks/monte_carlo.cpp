#include "monte_carlo.h"

#include <embree3/rtcore.h>

#include <cmath>

namespace truescatter::benchmarks {
namespace {
constexpr double kLargestRadius = 6.0;  // standard deviations
constexpr int kMaxHits = 64;
constexpr std::array<double, 3> kAxisShare = {0.5, 0.25, 0.25};
}  // namespace

struct MonteCarlo::Handles {
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

MonteCarlo::MonteCarlo(const LitMesh& scene) : scene_(scene), handles_(std::make_unique<Handles>()) {
  handles_->device = rtcNewDevice(nullptr);
  handles_->scene = rtcNewScene(handles_->device);
  RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices =
      static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                  3 * sizeof(float), scene.mesh.positions_mm.size()));
  auto* indices =
      static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                     3 * sizeof(unsigned), scene.mesh.triangles.size()));
  for (const Vec3d& p : scene.mesh.positions_mm) {
    for (int c = 0; c < 3; ++c) *vertices++ = static_cast<float>(p[c]);
  }
  for (const auto& triangle : scene.mesh.triangles) {
    for (const int v : triangle) *indices++ = static_cast<unsigned>(v);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(handles_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(handles_->scene);
}

MonteCarlo::~MonteCarlo() = default;

Vec4d MonteCarlo::convolve(const MeshPoint& point, double std_dev_mm, int probes,
                           std::mt19937_64& generator) const {
  const double s = std_dev_mm;
  const double radius_mm = kLargestRadius * s;
  const Vec3d origin = position_mm(scene_.mesh, point);
  const auto normal_of = [&](std::size_t t) {
    const auto& x = scene_.surface.triangles[t].corners_mm;
    return Vec3d((x[1] - x[0]).cross(x[2] - x[0]).normalized());
  };
  const Vec3d normal = normal_of(point.triangle);
  const Vec3d tangent = normal.unitOrthogonal();
  const std::array<Vec3d, 3> axes = {normal, tangent, normal.cross(tangent)};
  const double drawn = 1.0 - std::exp(-0.5 * kLargestRadius * kLargestRadius);  // share of the radii
  const auto density_on_disc = [&](double r) {
    return std::exp(-0.5 * (r / s) * (r / s)) / (2.0 * kPi * s * s) / drawn;
  };
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Vec4d sum = Vec4d::Zero();
  for (int i = 0; i < probes; ++i) {
    const double which = uniform(generator);
    const std::size_t a = which < 0.5 ? 0 : which < 0.75 ? 1 : 2;
    const Vec3d& axis = axes[a];
    const double r = s * std::sqrt(-2.0 * std::log(1.0 - drawn * uniform(generator)));
    const double phi = 2.0 * kPi * uniform(generator);
    const double half = std::sqrt(std::max(0.0, radius_mm * radius_mm - r * r));
    const Vec3d start =
        origin + r * (std::cos(phi) * axes[(a + 1) % 3] + std::sin(phi) * axes[(a + 2) % 3]) - half * axis;
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(start.x());
    ray.ray.org_y = static_cast<float>(start.y());
    ray.ray.org_z = static_cast<float>(start.z());
    ray.ray.dir_x = static_cast<float>(axis.x());
    ray.ray.dir_y = static_cast<float>(axis.y());
    ray.ray.dir_z = static_cast<float>(axis.z());
    ray.ray.mask = 0xFFFFFFFFU;
    float from = 0.0F;
    for (int hit = 0; hit < kMaxHits; ++hit) {
      ray.ray.tnear = from;
      ray.ray.tfar = static_cast<float>(2.0 * half);
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      rtcIntersect1(handles_->scene, &context, &ray);
      if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) break;
      const std::size_t t = ray.hit.primID;
      const double u = static_cast<double>(ray.hit.u);
      const double v = static_cast<double>(ray.hit.v);
      const SurfaceTriangle& triangle = scene_.surface.triangles[t];
      const Vec3d x =
          (1.0 - u - v) * triangle.corners_mm[0] + u * triangle.corners_mm[1] + v * triangle.corners_mm[2];
      const Vec3d offset = x - origin;
      double density = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double along = offset.dot(axes[k]);
        const double on_disc = std::sqrt(std::max(0.0, offset.squaredNorm() - along * along));
        density += kAxisShare[k] * density_on_disc(on_disc) * std::abs(normal_of(t).dot(axes[k]));
      }
      const double d = offset.norm();
      const double kernel = std::exp(-0.5 * (d / s) * (d / s)) / (2.0 * kPi * s * s);
      const double weight = kernel / density / probes;
      const Vec3d irradiance =
          (1.0 - u - v) * triangle.irradiance[0] + u * triangle.irradiance[1] + v * triangle.irradiance[2];
      sum += weight * Vec4d(irradiance.x(), irradiance.y(), irradiance.z(), 1.0);
      from = ray.ray.tfar + 1e-4F * static_cast<float>(s);
    }
  }
  return sum;
}

}  // namespace truescatter::benchmarks
