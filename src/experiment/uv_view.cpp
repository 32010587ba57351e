#include "experiment/uv_view.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "scene/load_mesh.h"

namespace truescatter {
namespace {

constexpr double kSameUv = 1e-9;
constexpr double kBehind_mm = 0.5;  // as neighbouring pixels are told apart, README, Definitions
constexpr double kStepsPerPixel = 4.0;

Vec2d uv_at(const Mesh& mesh, std::size_t triangle, int vertex) {
  const std::array<int, 3>& vertices = mesh.triangles[triangle];
  const auto corner =
      static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), vertex) - vertices.begin());
  return (*mesh.corner_uvs)[triangle][corner];
}

// A point of the view by its place on the picture, in pixels from its upper left, and 1 / depth, which is
// linear on the picture.
struct Projected {
  Vec2d px;
  double inverse_depth;
};

struct Segment {
  Projected a;
  Projected b;
};

// The part in front of the camera, on the picture.
std::optional<Segment> projected(const Vec3d& a, const Vec3d& b, const Camera& camera) {
  constexpr double kNearest_mm = 1e-3;
  Vec3d from = a;
  Vec3d to = b;
  if (-from.z() < kNearest_mm && -to.z() < kNearest_mm) return std::nullopt;
  const auto cut = [](const Vec3d& behind, const Vec3d& before) -> Vec3d {
    return behind + (-kNearest_mm - behind.z()) / (before.z() - behind.z()) * (before - behind);
  };
  if (-from.z() < kNearest_mm) from = cut(from, to);
  if (-to.z() < kNearest_mm) to = cut(to, from);
  const double focal = camera.focal_px();
  const auto project = [&](const Vec3d& p) {
    return Projected{
        {0.5 * camera.width_px - focal * p.x() / p.z(), 0.5 * camera.height_px + focal * p.y() / p.z()},
        -1.0 / p.z()};
  };
  return Segment{project(from), project(to)};
}

// The interval of t in [0, 1] in which a + t (b - a) lies on the picture (Liang & Barsky); empty: from > to.
std::array<double, 2> inside_picture(const Segment& segment, const Camera& camera) {
  double from = 0.0;
  double to = 1.0;
  const Vec2d step = segment.b.px - segment.a.px;
  const Vec2d size(camera.width_px, camera.height_px);
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    if (step[axis] == 0.0) {
      if (segment.a.px[axis] < 0.0 || segment.a.px[axis] >= size[axis]) return {1.0, 0.0};
      continue;
    }
    const double at_low = -segment.a.px[axis] / step[axis];
    const double at_high = (size[axis] - segment.a.px[axis]) / step[axis];
    from = std::max(from, std::min(at_low, at_high));
    to = std::min(to, std::max(at_low, at_high));
  }
  return {from, to};
}

bool is_seen(const Projected& point, int x, int y, const Camera& camera, const FrameImages& images) {
  const double depth_mm = 1.0 / point.inverse_depth;
  const Vec3d seen = images.position.rgb(x, y);
  if (std::abs(depth_mm + seen.z()) <= kBehind_mm) return true;
  const Vec3d normal = images.face_normal.rgb(x, y);
  const Vec3d ray((point.px.x() - 0.5 * camera.width_px) / camera.focal_px(),
                  (0.5 * camera.height_px - point.px.y()) / camera.focal_px(), -1.0);
  return std::abs(depth_mm - normal.dot(seen) / normal.dot(ray)) <= kBehind_mm;  // false where there is none
}

void mark(const Segment& segment, const Camera& camera, const FrameImages& images, Image& pixels) {
  const auto [from, to] = inside_picture(segment, camera);
  if (from > to) return;
  const double length_px = (to - from) * (segment.b.px - segment.a.px).norm();
  const int steps = static_cast<int>(std::ceil(kStepsPerPixel * length_px)) + 1;
  for (int i = 0; i <= steps; ++i) {
    const double t = from + (to - from) * i / steps;
    const Projected point{segment.a.px + t * (segment.b.px - segment.a.px),
                          segment.a.inverse_depth + t * (segment.b.inverse_depth - segment.a.inverse_depth)};
    const int x = static_cast<int>(std::floor(point.px.x()));
    const int y = static_cast<int>(std::floor(point.px.y()));
    if (x < 0 || y < 0 || x >= pixels.width() || y >= pixels.height()) continue;
    if (images.mask.at(x, y, 0) == 0.0F || !is_seen(point, x, y, camera, images)) continue;
    pixels.at(x, y, 0) = 1.0F;
  }
}

}  // namespace

std::vector<SeamEdge> uv_seams(const Mesh& mesh) {
  assert(mesh.has_uvs());
  std::unordered_map<std::uint64_t, std::size_t> first_triangle;
  std::vector<SeamEdge> seams;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = mesh.triangles[t][c];
      const int b = mesh.triangles[t][(c + 1) % 3];
      const auto [found, is_new] = first_triangle.emplace(edge_key(a, b), t);
      if (is_new) continue;
      const std::size_t other = found->second;
      const auto differs = [&](int vertex) {
        return (uv_at(mesh, t, vertex) - uv_at(mesh, other, vertex)).cwiseAbs().maxCoeff() > kSameUv;
      };
      if (differs(a) || differs(b)) {
        seams.push_back(
            {mesh.positions_mm[static_cast<std::size_t>(a)], mesh.positions_mm[static_cast<std::size_t>(b)]});
      }
    }
  }
  return seams;
}

Image seam_pixels(const std::vector<SeamEdge>& seams, const Camera& camera, const FrameImages& images) {
  Image pixels(images.mask.width(), images.mask.height(), 1);
  const Mat4d view = camera.view_matrix();
  const auto in_view = [&](const Vec3d& p) -> Vec3d {
    return view.topLeftCorner<3, 3>() * p + view.topRightCorner<3, 1>();
  };
  for (const SeamEdge& seam : seams) {
    const std::optional<Segment> segment = projected(in_view(seam[0]), in_view(seam[1]), camera);
    if (segment) mark(*segment, camera, images, pixels);
  }
  return pixels;
}

UvView uv_view(const Mesh& mesh, const ShadingMesh& shading, const Camera& camera,
               const FrameImages& images) {
  UvView result;
  result.seam_delta_mm = seam_distance_mm(seam_pixels(uv_seams(mesh), camera, images), images.mask,
                                          images.position, camera.focal_px());
  result.anisotropy = Image(images.mask.width(), images.mask.height(), 1, 1.0F);
  for (int y = 0; y < images.mask.height(); ++y) {
    for (int x = 0; x < images.mask.width(); ++x) {
      const PixelSurface& at = images.surface_at(x, y);
      if (images.mask.at(x, y, 0) == 0.0F || at.triangle < 0) continue;
      const std::size_t base = shading.triangles[static_cast<std::size_t>(at.triangle)].base;
      result.anisotropy.at(x, y, 0) = static_cast<float>(uv_anisotropy(mesh, base));
    }
  }
  return result;
}

}  // namespace truescatter
