#include "experiment/visible_surface.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "core/parallel.h"
#include "irradiance/shadow_scene.h"

namespace truescatter {
namespace {

constexpr double kLargestEdgePx = 0.5;
// Where corners and centroid disagree. Such pieces lie along contours only, so that they are few.
constexpr double kLargestUnsureEdgePx = 0.125;
// For pieces at the eye itself, which are never small.
constexpr int kDeepest = 24;
constexpr std::size_t kChunk = 256;

using Corners = std::array<bool, 3>;

class Eye {
 public:
  Eye(const Mesh& mesh, const Camera& camera) : rays_(mesh), camera_(camera), view_(camera.view_matrix()) {}

  bool sees(const Vec3d& p) const {
    const Vec3d x = in_view(p);
    if (x.z() >= 0.0) return false;
    const Vec2d at = pixel(x);
    if (std::abs(at.x()) > 0.5 * camera_.width_px || std::abs(at.y()) > 0.5 * camera_.height_px) return false;
    const Vec3d to_eye = camera_.eye_mm - p;
    const double distance = to_eye.norm();
    const Vec3d direction = to_eye / distance;
    const double offset = rays_.largest_offset_mm();
    return distance <= offset || !rays_.occluded(p + offset * direction, direction, distance - offset);
  }

  // Whether the picture cannot show any of it: all of it is behind the eye, or beyond one side of the
  // picture.
  bool misses(const SurfaceTriangle& triangle) const {
    const double half_width = 0.5 * camera_.width_px / camera_.focal_px();
    const double half_height = 0.5 * camera_.height_px / camera_.focal_px();
    bool behind = true;
    std::array<bool, 4> beyond{true, true, true, true};
    for (const Vec3d& corner : triangle.corners_mm) {
      const Vec3d x = in_view(corner);
      behind = behind && x.z() >= 0.0;
      beyond[0] = beyond[0] && x.x() > -half_width * x.z();
      beyond[1] = beyond[1] && -x.x() > -half_width * x.z();
      beyond[2] = beyond[2] && x.y() > -half_height * x.z();
      beyond[3] = beyond[3] && -x.y() > -half_height * x.z();
    }
    return behind || std::any_of(beyond.begin(), beyond.end(), [](bool b) { return b; });
  }

  bool is_smaller(const SurfaceTriangle& triangle, double largest_edge_px) const {
    std::array<Vec2d, 3> at;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d x = in_view(triangle.corners_mm[c]);
      if (x.z() >= 0.0) return false;
      at[c] = pixel(x);
    }
    return (at[1] - at[0]).norm() < largest_edge_px && (at[2] - at[1]).norm() < largest_edge_px &&
           (at[0] - at[2]).norm() < largest_edge_px;
  }

 private:
  Vec3d in_view(const Vec3d& p) const { return (view_ * p.homogeneous()).head<3>(); }
  // From the picture's centre.
  Vec2d pixel(const Vec3d& in_view) const { return camera_.focal_px() / -in_view.z() * in_view.head<2>(); }

  ShadowScene rays_;
  const Camera& camera_;
  Mat4d view_;
};

SurfaceTriangle piece(const SurfaceTriangle& whole, const std::array<Vec3d, 3>& barycentric) {
  SurfaceTriangle part;
  part.component = whole.component;
  for (std::size_t c = 0; c < 3; ++c) {
    part.corners_mm[c] = part.irradiance[c] = Vec3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const double b = barycentric[c][static_cast<Eigen::Index>(k)];
      part.corners_mm[c] += b * whole.corners_mm[k];
      part.irradiance[c] += b * whole.irradiance[k];
    }
  }
  return part;
}

// Sorts one triangle after the other into what is seen.
class Splitter {
 public:
  Splitter(const Eye& eye, VisibleSurface& result) : eye_(eye), result_(result) {}

  void add(const SurfaceTriangle& triangle) {
    Corners corners{};
    if (eye_.misses(triangle)) return;
    for (std::size_t c = 0; c < 3; ++c) corners[c] = eye_.sees(triangle.corners_mm[c]);
    visit(triangle, corners, 0);
  }

 private:
  // Adds the parts that are seen; whether that is all of it. `corners`: which are seen.
  bool visit(const SurfaceTriangle& triangle, const Corners& corners, int depth) {
    if (eye_.misses(triangle)) return false;
    if (depth == kDeepest || eye_.is_smaller(triangle, kLargestEdgePx)) {
      const bool seen = eye_.sees(triangle.centroid_mm());
      const bool agreed = std::all_of(corners.begin(), corners.end(), [&](bool c) { return c == seen; });
      if (agreed || depth == kDeepest || eye_.is_smaller(triangle, kLargestUnsureEdgePx)) {
        if (!agreed) result_.unsure.triangles.push_back(triangle);
        if (seen) result_.seen.triangles.push_back(triangle);
        return seen;
      }
    }
    return split(triangle, corners, depth);
  }

  bool split(const SurfaceTriangle& triangle, const Corners& corners, int depth) {
    static const std::array<Vec3d, 6> kPoints = {Vec3d(1.0, 0.0, 0.0), Vec3d(0.0, 1.0, 0.0),
                                                 Vec3d(0.0, 0.0, 1.0), Vec3d(0.5, 0.5, 0.0),
                                                 Vec3d(0.0, 0.5, 0.5), Vec3d(0.5, 0.0, 0.5)};
    static constexpr std::array<std::array<std::size_t, 3>, 4> kChildren = {
        {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
    std::array<bool, 6> seen{corners[0], corners[1], corners[2]};
    const SurfaceTriangle middle = piece(triangle, {kPoints[3], kPoints[4], kPoints[5]});
    for (std::size_t m = 0; m < 3; ++m) seen[3 + m] = eye_.sees(middle.corners_mm[m]);
    const std::size_t before = result_.seen.triangles.size();
    bool whole = true;
    for (const auto& [a, b, c] : kChildren) {
      const bool child = visit(piece(triangle, {kPoints[a], kPoints[b], kPoints[c]}),
                               {seen[a], seen[b], seen[c]}, depth + 1);
      whole = whole && child;
    }
    if (!whole) return false;
    result_.seen.triangles.resize(before);
    result_.seen.triangles.push_back(triangle);
    return true;
  }

  const Eye& eye_;
  VisibleSurface& result_;
};

void append(Surface& to, Surface&& from) {
  to.triangles.insert(to.triangles.end(), std::make_move_iterator(from.triangles.begin()),
                      std::make_move_iterator(from.triangles.end()));
}

}  // namespace

VisibleSurface visible_surface(const PreparedScene& scene, const Camera& camera) {
  const Surface whole = scattering_surface(scene.shading);
  const Eye eye(scene.mesh, camera);
  std::vector<VisibleSurface> parts((whole.triangles.size() + kChunk - 1) / kChunk);
  parallel_for(parts.size(), [&](std::size_t part) {
    Splitter splitter(eye, parts[part]);
    const std::size_t end = std::min(whole.triangles.size(), (part + 1) * kChunk);
    for (std::size_t t = part * kChunk; t < end; ++t) splitter.add(whole.triangles[t]);
  });
  VisibleSurface result;
  for (VisibleSurface& part : parts) {
    append(result.seen, std::move(part.seen));
    append(result.unsure, std::move(part.unsure));
  }
  return result;
}

}  // namespace truescatter
