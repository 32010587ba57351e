#include "experiment/view_points.h"

#include <algorithm>

namespace truescatter {
namespace {

// Rounding may take a coordinate below 0, and the point out of its face.
Vec3d inside_face(const Vec3d& barycentric) {
  const Vec3d clamped = barycentric.cwiseMax(0.0);
  return clamped / clamped.sum();
}

}  // namespace

ViewPoints view_points(const PreparedScene& scene, const FrameImages& images) {
  ViewPoints points;
  const auto skin = static_cast<std::size_t>(
      std::count_if(images.mask.data().begin(), images.mask.data().end(), [](float v) { return v != 0.0F; }));
  points.pixels.reserve(skin);
  points.triangles.reserve(skin);
  points.on_surface.reserve(skin);
  points.on_mesh.reserve(skin);
  points.irradiance.reserve(skin);
  for (int y = 0; y < images.mask.height(); ++y) {
    for (int x = 0; x < images.mask.width(); ++x) {
      const PixelSurface& seen = images.surface_at(x, y);
      if (seen.triangle < 0 || images.mask.at(x, y, 0) == 0.0F) continue;
      const ShadingTriangle& triangle = scene.shading.triangles[static_cast<std::size_t>(seen.triangle)];
      SurfacePoint point;
      point.component = triangle.component;
      Vec3d irradiance = Vec3d::Zero();
      Vec3d in_base = Vec3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        const double b = seen.barycentric[static_cast<Eigen::Index>(c)];
        point.position_mm += b * scene.shading.corner(triangle, c);
        irradiance += b * triangle.irradiance[c];
        in_base += b * triangle.base_barycentric[c];
      }
      points.pixels.push_back({x, y});
      points.triangles.push_back(seen.triangle);
      points.on_surface.push_back(point);
      points.on_mesh.push_back({{triangle.base, inside_face(in_base)}, triangle.component});
      points.irradiance.push_back(irradiance);
    }
  }
  return points;
}

}  // namespace truescatter
