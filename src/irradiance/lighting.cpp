#include "irradiance/lighting.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace truescatter {
namespace {

Vec3d lifted_position(const Mesh& mesh, const MeshPoint& point, const Vec3d& position) {
  Vec3d lift = Vec3d::Zero();
  for (int c = 0; c < 3; ++c) {
    const Vec3d& normal = mesh.corner_normals[point.triangle][static_cast<std::size_t>(c)];
    const double below = std::min(0.0, (position - mesh.corner(point.triangle, c)).dot(normal));
    lift -= point.barycentric[c] * below * normal;
  }
  return position + lift;
}

double squared_distance_to_mesh(const Mesh& mesh, const Vec3d& position) {
  double nearest2 = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    nearest2 = std::min(nearest2, squared_distance_to_triangle(position, mesh.corner(t, 0), mesh.corner(t, 1),
                                                               mesh.corner(t, 2)));
  }
  return nearest2;
}

}  // namespace

Lighting::Lighting(const Mesh& mesh, const std::vector<Light>& lights, NormalMap normal_map,
                   SurfaceAlbedo albedo)
    : mesh_(mesh), normal_map_(std::move(normal_map)), albedo_(std::move(albedo)), shadows_(mesh) {
  Vec3d bound = Vec3d::Zero();
  for (const Light& light : lights) {
    if (light.kind != LightKind::environment) {
      lights_.push_back(light);
      continue;
    }
    EnvironmentSh coloured = light.environment;
    for (Vec3d& coefficient : coloured) coefficient = coefficient.cwiseProduct(light.color);
    environments_.push_back(
        {EnvironmentIrradiance(coloured, light.shadows ? light.occlusion_rays : 0), light.shadows});
    bound += environments_.back().irradiance.largest_possible();
  }
  for (const Light& light : lights_) {
    double falloff = 1.0;
    if (light.kind == LightKind::point) {
      falloff = light.reference_mm * light.reference_mm / squared_distance_to_mesh(mesh, light.position_mm);
    }
    bound += falloff * light.color;
  }
  largest_possible_ = bound.maxCoeff();
}

bool Lighting::hidden(const Vec3d& origin_mm, const Vec3d& direction) const {
  return shadows_.occluded(origin_mm, direction, std::numeric_limits<double>::infinity());
}

double Lighting::visibility(const Vec3d& origin_mm, const Light& light) const {
  if (!light.shadows) return 1.0;
  if (light.kind == LightKind::directional) {
    return hidden(origin_mm, light.direction) ? 0.0 : 1.0;
  }
  const Vec3d to_light = light.position_mm - origin_mm;
  const double distance_mm = to_light.norm();
  return shadows_.occluded(origin_mm, to_light / distance_mm, distance_mm) ? 0.0 : 1.0;
}

Vec3d Lighting::smooth_irradiance(const MeshPoint& point) const {
  return irradiance(point, interpolated_normal(mesh_, point));
}

Vec3d Lighting::irradiance(const MeshPoint& point) const {
  return albedo_.value(mesh_, point).cwiseProduct(irradiance(point, normal_map_.normal(mesh_, point)));
}

Vec3d Lighting::irradiance(std::span<const MeshPoint> place) const {
  std::vector<Vec3d> normals;
  Vec3d sum = Vec3d::Zero();
  for (const MeshPoint& point : place) {
    const Vec3d normal = normal_map_.normal(mesh_, point);
    const bool known = std::any_of(normals.begin(), normals.end(),
                                   [&](const Vec3d& other) { return same_normal(other, normal); });
    if (known) continue;
    normals.push_back(normal);
    sum += normal;
  }
  return albedo_.value(mesh_, place)
      .cwiseProduct(
          irradiance(place.front(), normals.size() == 1 ? normals.front() : sum.stableNormalized()));
}

Vec3d Lighting::irradiance(const MeshPoint& point, const Vec3d& normal) const {
  const Vec3d position = position_mm(mesh_, point);
  const Vec3d origin = lifted_position(mesh_, point, position) +
                       shadows_.offset_mm(point.triangle) * interpolated_normal(mesh_, point);
  Vec3d sum = Vec3d::Zero();
  for (const Light& light : lights_) {
    Vec3d to_light = light.direction;
    double falloff = 1.0;
    if (light.kind == LightKind::point) {
      to_light = light.position_mm - position;
      falloff = light.reference_mm * light.reference_mm / to_light.squaredNorm();
      to_light.normalize();
    }
    const double cosine = normal.dot(to_light);
    if (cosine <= 0.0) continue;
    sum += cosine * falloff * visibility(origin, light) * light.color;
  }
  for (const Environment& environment : environments_) {
    sum += environment.occluded
               ? environment.irradiance.irradiance(
                     normal, [&](const Vec3d& direction) { return hidden(origin, direction); })
               : environment.irradiance.unoccluded(normal);
  }
  return sum;
}

}  // namespace truescatter
