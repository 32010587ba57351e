// The one file that includes CGAL.
#include "truth/cgal_geodesic.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include <cmath>
#include <cstddef>
#include <limits>

#include "core/error.h"

namespace truescatter {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Traits = CGAL::Surface_mesh_shortest_path_traits<Kernel, SurfaceMesh>;
using ShortestPath = CGAL::Surface_mesh_shortest_path<Traits>;

constexpr double kLeastBarycentric = 1e-12;

}  // namespace

struct CgalGeodesics::Impl {
  SurfaceMesh mesh;
  std::vector<SurfaceMesh::Face_index> faces;
  std::vector<std::size_t> first_corner;  // of each triangle, the corner that CGAL counts from

  Vec3d position_mm(const MeshPoint& point) const {
    Vec3d sum = Vec3d::Zero();
    SurfaceMesh::Halfedge_index corner = mesh.halfedge(faces[point.triangle]);
    for (std::size_t i = 0; i < 3; ++i, corner = mesh.next(corner)) {
      const Kernel::Point_3& at = mesh.point(mesh.source(corner));
      const auto given = static_cast<Eigen::Index>((first_corner[point.triangle] + i) % 3);
      sum += point.barycentric[given] * Vec3d(at.x(), at.y(), at.z());
    }
    return sum;
  }

  // CGAL's coordinates count from the source of a face's halfedge, not from the corner that was given first.
  ShortestPath::Barycentric_coordinates coordinates(const MeshPoint& point) const {
    Vec3d b = point.barycentric.cwiseMax(kLeastBarycentric);
    b /= b.sum();
    const std::size_t first = first_corner[point.triangle];
    const auto at = [&](std::size_t i) { return b[static_cast<Eigen::Index>((first + i) % 3)]; };
    return {at(0), at(1), at(2)};
  }
};

CgalGeodesics::CgalGeodesics(std::span<const Vec3d> positions_mm,
                             std::span<const std::array<int, 3>> triangles)
    : impl_(std::make_unique<Impl>()) {
  std::vector<SurfaceMesh::Vertex_index> vertices;
  vertices.reserve(positions_mm.size());
  for (const Vec3d& p : positions_mm) vertices.push_back(impl_->mesh.add_vertex({p.x(), p.y(), p.z()}));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    std::array<SurfaceMesh::Vertex_index, 3> corner;
    std::array<Vec3d, 3> x;
    for (std::size_t c = 0; c < 3; ++c) {
      corner[c] = vertices[static_cast<std::size_t>(triangles[t][c])];
      x[c] = positions_mm[static_cast<std::size_t>(triangles[t][c])];
    }
    if (!((x[1] - x[0]).cross(x[2] - x[0]).norm() > 0.0))
      throw_input_error({}, "triangle {} (from 0) has no area: there are no geodesics over it", t);
    const SurfaceMesh::Face_index face = impl_->mesh.add_face(corner[0], corner[1], corner[2]);
    if (face == SurfaceMesh::null_face()) {
      throw_input_error(
          {},
          "triangle {} (from 0) does not fit to its neighbours: geodesics need a manifold surface "
          "of one orientation",
          t);
    }
    impl_->faces.push_back(face);
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const SurfaceMesh::Vertex_index from = impl_->mesh.source(impl_->mesh.halfedge(impl_->faces[t]));
    std::size_t first = 0;
    while (vertices[static_cast<std::size_t>(triangles[t][first])] != from) ++first;
    impl_->first_corner.push_back(first);
  }
}

CgalGeodesics::~CgalGeodesics() = default;

struct CgalGeodesics::From::Impl {
  const CgalGeodesics::Impl& geodesics;
  MeshPoint source;
  ShortestPath paths;

  Impl(const CgalGeodesics::Impl& of, const MeshPoint& from) : geodesics(of), source(from), paths(of.mesh) {
    paths.add_source_point(of.faces[source.triangle], of.coordinates(source));
    paths.build_sequence_tree();
  }
};

CgalGeodesics::From::From(const CgalGeodesics& geodesics, const MeshPoint& source)
    : impl_(std::make_unique<Impl>(*geodesics.impl_, source)) {}

CgalGeodesics::From::~From() = default;
CgalGeodesics::From::From(From&&) noexcept = default;

double CgalGeodesics::From::distance_mm(const MeshPoint& target) const {
  if (target.triangle == impl_->source.triangle) {
    return (impl_->geodesics.position_mm(target) - impl_->geodesics.position_mm(impl_->source)).norm();
  }
  const double distance = impl_->paths
                              .shortest_distance_to_source_points(impl_->geodesics.faces[target.triangle],
                                                                  impl_->geodesics.coordinates(target))
                              .first;
  return distance < 0.0 ? std::numeric_limits<double>::infinity() : distance;
}

std::vector<double> CgalGeodesics::distances_mm(const MeshPoint& source,
                                                std::span<const MeshPoint> targets) const {
  const From from(*this, source);
  std::vector<double> distances;
  distances.reserve(targets.size());
  for (const MeshPoint& target : targets) distances.push_back(from.distance_mm(target));
  return distances;
}

}  // namespace truescatter
