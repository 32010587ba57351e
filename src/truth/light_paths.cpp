#include "truth/light_paths.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "truth/triangle_rules.h"

namespace truescatter {
namespace {

constexpr std::size_t kDegree5 = 2;  // of triangle_rules()

// In barycentric coordinates.
const std::array<Vec3d, 3> kWhole = {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()};

double reach_mm(double std_dev_mm) {
  return std_dev_mm * std::sqrt(-2.0 * std::log(LightPathEngine::tail_bound()));
}

double gaussian(double std_dev_mm, double distance_mm) {
  const double variance = std_dev_mm * std_dev_mm;
  return std::exp(-0.5 * distance_mm * distance_mm / variance) / (2.0 * kPi * variance);
}

template <typename Value>
Value mixed(const std::array<Value, 3>& corners, const Vec3d& barycentric) {
  return barycentric.x() * corners[0] + barycentric.y() * corners[1] + barycentric.z() * corners[2];
}

Surface placed(const GeodesicSurface& surface, const auto& position_of) {
  Surface placed_surface;
  for (std::size_t face = 0; face < surface.mesh().face_count(); ++face) {
    for (const FlatPiece& piece : surface.pieces(face)) {
      SurfaceTriangle triangle{{}, piece.irradiance, piece.component};
      for (std::size_t c = 0; c < 3; ++c) triangle.corners_mm[c] = position_of(face, piece.corners_mm[c]);
      placed_surface.triangles.push_back(triangle);
    }
  }
  return placed_surface;
}

}  // namespace

// One point with one Gaussian.
struct LightPathEngine::Seen {
  const GeodesicField& field;
  Vec3d point_mm;
  std::size_t face;
  int component;
  double std_dev_mm;
  double r_max_mm;
};

LightPathEngine::LightPathEngine(const Mesh& mesh, const GeodesicSurface& surface, double edge_std_devs)
    : surface_(surface),
      body_(mesh),
      edge_std_devs_(edge_std_devs),
      frames_([&] {
        std::vector<Frame> frames;
        for (std::size_t face = 0; face < mesh.triangle_count(); ++face) {
          const Vec3d normal = triangle_normal(mesh, face);
          const Vec3d along = (mesh.corner(face, 1) - mesh.corner(face, 0)).normalized();
          frames.push_back({mesh.corner(face, 0), along, normal.cross(along), normal});
        }
        return frames;
      }()),
      in_space_(
          placed(surface, [&](std::size_t face, const Vec2d& x) { return frames_[face].position_mm(x); })),
      tree_(in_space_) {
  for (std::size_t face = 0; face < surface.mesh().face_count(); ++face)
    faces_.insert(faces_.end(), surface.pieces(face).size(), face);
}

std::vector<LightPaths> LightPathEngine::split(GeodesicField& field, const GeodesicTarget& target,
                                               std::span<const double> std_devs_mm, double r_max_mm) const {
  double radius_mm = r_max_mm;
  for (const double s : std_devs_mm) radius_mm = std::max(radius_mm, reach_mm(s));
  // On a plane both distances are the same, but for rounding.
  radius_mm *= 1.0 + 1e-6;
  field.propagate(target.point, radius_mm);
  const Vec2d flat = flat_position(surface_.mesh(), target.point);
  const Vec3d point_mm = frames_[target.point.face].position_mm(flat);
  std::vector<LightPaths> paths;
  for (const double s : std_devs_mm) {
    const Seen seen{field, point_mm, target.point.face, target.component, s, r_max_mm};
    LightPaths sum;
    tree_.for_each(point_mm, reach_mm(s), target.component,
                   [&](std::uint32_t piece) { add_part(seen, piece, kWhole, sum); });
    paths.push_back(sum);
  }
  return paths;
}

void LightPathEngine::add_part(const Seen& seen, std::size_t piece, const std::array<Vec3d, 3>& part,
                               LightPaths& paths) const {
  const SurfaceTriangle& triangle = in_space_.triangles[piece];
  std::array<Vec3d, 3> corners_mm;
  for (std::size_t c = 0; c < 3; ++c) corners_mm[c] = mixed(triangle.corners_mm, part[c]);
  std::size_t longest = 0;
  std::array<double, 3> lengths_mm{};
  for (std::size_t c = 0; c < 3; ++c) {
    lengths_mm[c] = (corners_mm[(c + 1) % 3] - corners_mm[c]).norm();
    if (lengths_mm[c] > lengths_mm[longest]) longest = c;
  }
  const Vec3d centroid_mm = (corners_mm[0] + corners_mm[1] + corners_mm[2]) / 3.0;
  // No corner is farther from the centroid than two thirds of the longest edge.
  const double nearest_mm = (centroid_mm - seen.point_mm).norm() - lengths_mm[longest] * 2.0 / 3.0;
  if (nearest_mm > reach_mm(seen.std_dev_mm)) return;
  if (lengths_mm[longest] > edge_std_devs_ * seen.std_dev_mm) {
    const std::size_t next = (longest + 1) % 3;
    const std::size_t last = (longest + 2) % 3;
    const Vec3d middle = 0.5 * (part[longest] + part[next]);
    add_part(seen, piece, {part[longest], middle, part[last]}, paths);
    add_part(seen, piece, {middle, part[next], part[last]}, paths);
    return;
  }
  const double area_mm2 = 0.5 * (corners_mm[1] - corners_mm[0]).cross(corners_mm[2] - corners_mm[0]).norm();
  for (const TriangleNode& node : triangle_rules()[kDegree5].nodes)
    add_node(seen, piece, mixed(part, node.barycentric), node.weight * area_mm2, paths);
}

void LightPathEngine::add_node(const Seen& seen, std::size_t piece, const Vec3d& at, double area_mm2,
                               LightPaths& paths) const {
  const SurfaceTriangle& triangle = in_space_.triangles[piece];
  const std::size_t face = faces_[piece];
  const Vec3d position_mm = mixed(triangle.corners_mm, at);
  const double straight_mm = (position_mm - seen.point_mm).norm();
  if (straight_mm > reach_mm(seen.std_dev_mm)) return;
  const double along_mm = seen.field.distance(face, mixed(surface_.pieces()[piece].corners_mm, at));
  const double straight = gaussian(seen.std_dev_mm, straight_mm);
  const double along = std::isfinite(along_mm) ? gaussian(seen.std_dev_mm, along_mm) : 0.0;
  const Vec3d irradiance = mixed(triangle.irradiance, at);
  const Vec4d light = area_mm2 * Vec4d(irradiance.x(), irradiance.y(), irradiance.z(), 1.0);
  const Vec4d difference = (straight - along) * light;
  if (along_mm <= seen.r_max_mm) {
    paths.curvature += difference;
    return;
  }
  paths.beyond += along * light;
  const Vec3d way = position_mm - seen.point_mm;
  const bool inwards = way.dot(frames_[seen.face].normal) < 0.0 && way.dot(frames_[face].normal) > 0.0;
  const bool inside = inwards && !body_.crossed_between(seen.point_mm, seen.face, position_mm, face);
  (inside ? paths.transmittance : paths.air) += difference;
  if (inside) paths.through += straight * light;
}

std::vector<std::vector<LightPaths>> LightPathEngine::split(std::span<const GeodesicTarget> targets,
                                                            std::span<const double> std_devs_mm,
                                                            double r_max_mm) const {
  std::vector<std::vector<LightPaths>> paths(std_devs_mm.size(), std::vector<LightPaths>(targets.size()));
  constexpr std::size_t kChunk = 8;
  parallel_for((targets.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    GeodesicField field(surface_.mesh());
    for (std::size_t i = chunk * kChunk; i < std::min(targets.size(), (chunk + 1) * kChunk); ++i) {
      const std::vector<LightPaths> of_point = split(field, targets[i], std_devs_mm, r_max_mm);
      for (std::size_t l = 0; l < std_devs_mm.size(); ++l) paths[l][i] = of_point[l];
    }
  });
  return paths;
}

}  // namespace truescatter
