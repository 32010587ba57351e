#include "experiment/reflection_pictures.h"

#include <algorithm>
#include <utility>

#include "core/parallel.h"
#include "irradiance/lighting.h"
#include "scene/head_gloss.h"

namespace truescatter {
namespace {

// What every function here reads of a view.
struct SeenScene {
  const PreparedScene& scene;
  const SceneReflection& reflection;
  const FrameImages& images;

  int width() const { return images.mask.width(); }
  int height() const { return images.mask.height(); }

  // An image of `channels`, of every pixel where a surface is seen: `at(triangle, barycentric in it)` gives
  // its value.
  template <typename At>
  Image picture(int channels, const At& at) const {
    Image image(width(), height(), channels);
    parallel_for(static_cast<std::size_t>(height()), [&](std::size_t row) {
      const int y = static_cast<int>(row);
      for (int x = 0; x < width(); ++x) {
        const PixelSurface& seen = images.surface_at(x, y);
        if (seen.triangle < 0) continue;
        const auto value = at(static_cast<std::size_t>(seen.triangle), seen.barycentric);
        for (int c = 0; c < channels; ++c) image.at(x, y, c) = static_cast<float>(value[c]);
      }
    });
    return image;
  }

  const ShadingTriangle& triangle(std::size_t index) const { return scene.shading.triangles[index]; }

  MeshPoint on_mesh(std::size_t index, const Vec3d& barycentric) const {
    MeshPoint point{triangle(index).base, Vec3d::Zero()};
    for (std::size_t c = 0; c < 3; ++c)
      point.barycentric += barycentric[static_cast<Eigen::Index>(c)] * triangle(index).base_barycentric[c];
    return point;
  }
};

Vec2d uv_at(const ShadingTriangle& triangle, const Vec3d& barycentric) {
  return barycentric.x() * triangle.uvs[0] + barycentric.y() * triangle.uvs[1] +
         barycentric.z() * triangle.uvs[2];
}

// A point in the coordinates of the mesh that its character is a copy of.
Vec3d in_own_coordinates(const PreparedScene& scene, std::size_t triangle, const Vec3d& world_mm) {
  if (scene.places.empty()) return world_mm;
  const std::vector<std::size_t>& starts = scene.shading.character_starts;
  const auto after = std::upper_bound(starts.begin(), starts.end(), triangle);
  const CharacterPlace& place = scene.places[static_cast<std::size_t>(after - starts.begin()) - 1];
  return to_own_coordinates(place, world_mm);
}

// The walkthrough's map: intensity in red, none where that is at most a tenth; roughness in alpha.
Vec2d gloss_of_map(const UvTexture& map, const Vec2d& uv) {
  const double red = map.value(uv, 0);
  const double alpha = map.value(uv, map.channels() - 1);
  return {red > 0.1 ? 0.16 * red + 0.18 : 0.0, 0.09 * alpha + 0.23};
}

Image gloss_picture(const SeenScene& seen, const CompositeSpec& spec) {
  return seen.picture(2, [&](std::size_t index, const Vec3d& barycentric) -> Vec2d {
    const ShadingTriangle& triangle = seen.triangle(index);
    if (!triangle.skin) return Vec2d::Zero();
    if (!seen.reflection.regions.empty())
      return gloss_of_map(seen.reflection.regions, uv_at(triangle, barycentric));
    if (spec.regions.empty()) return {spec.intensity, spec.roughness};
    const Vec3d world = position_mm(seen.scene.mesh, seen.on_mesh(index, barycentric));
    const SkinGloss gloss = head_gloss(in_own_coordinates(seen.scene, index, world));
    return {gloss.intensity, gloss.roughness};
  });
}

// The lobe is that of the side that the surface's normal points to.
void leave_out_backs(const FrameImages& images, Image& gloss) {
  for (int y = 0; y < gloss.height(); ++y) {
    for (int x = 0; x < gloss.width(); ++x) {
      if (images.face_normal.rgb(x, y).dot(images.position.rgb(x, y)) > 0.0) gloss.at(x, y, 0) = 0.0F;
    }
  }
}

Image normal_picture(const SeenScene& seen, const Mat4d& world_to_view) {
  if (seen.reflection.normal_map.empty()) return seen.images.normal;
  const Mat3d turn = world_to_view.topLeftCorner<3, 3>();
  return seen.picture(3, [&](std::size_t index, const Vec3d& barycentric) -> Vec3d {
    return turn * seen.reflection.normal_map.normal(seen.scene.mesh, seen.on_mesh(index, barycentric));
  });
}

// The light's own irradiance at each pixel's point: what is reflected is not interpolated between vertices.
Image lamp_picture(const SeenScene& seen, const Light& light) {
  const Lighting lighting(seen.scene.mesh, {light}, seen.reflection.normal_map);
  return seen.picture(3, [&](std::size_t index, const Vec3d& barycentric) -> Vec3d {
    return lighting.irradiance(seen.on_mesh(index, barycentric));
  });
}

// What occlusion leaves of an environment's irradiance, interpolated between the shading mesh's corners.
Image share_picture(const SeenScene& seen, const CornerIrradiance& share) {
  if (share.empty()) return {seen.width(), seen.height(), 3, 1.0F};
  return seen.picture(3, [&](std::size_t index, const Vec3d& barycentric) -> Vec3d {
    Vec3d sum = Vec3d::Zero();
    for (std::size_t c = 0; c < 3; ++c) sum += barycentric[static_cast<Eigen::Index>(c)] * share[index][c];
    return sum;
  });
}

std::vector<SeenLight> seen_lights(const SeenScene& seen) {
  std::vector<SeenLight> lights;
  auto share = seen.reflection.shares.begin();
  for (const Light& light : seen.reflection.lights) {
    const bool environment = light.kind == LightKind::environment;
    lights.push_back({light, environment ? share_picture(seen, *share) : lamp_picture(seen, light)});
    if (environment) ++share;
  }
  return lights;
}

}  // namespace

ReflectionPictures reflection_pictures(const PreparedScene& scene, const SceneReflection& reflection,
                                       const FrameImages& images, const Mat4d& world_to_view,
                                       const CompositeSpec* gloss) {
  const SeenScene seen{scene, reflection, images};
  ReflectionPictures pictures{seen_lights(seen), normal_picture(seen, world_to_view), {}};
  if (gloss != nullptr) {
    pictures.gloss = gloss_picture(seen, *gloss);
    leave_out_backs(images, pictures.gloss);
  }
  return pictures;
}

}  // namespace truescatter
