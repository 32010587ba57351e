#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/vec.h"
#include "irradiance/mesh_point.h"

namespace truescatter {

// Exact polyhedral distances by CGAL (Surface_mesh_shortest_path; Xin and Wang 2009): a second opinion, slow.
class CgalGeodesics {
 public:
  // The distances from one point, to be asked for one by one. One serves one thread; several may share the
  // mesh, which must outlive them.
  class From {
   public:
    From(const CgalGeodesics& geodesics, const MeshPoint& source);
    ~From();
    From(From&&) noexcept;
    From(const From&) = delete;
    From& operator=(const From&) = delete;
    From& operator=(From&&) = delete;

    // Infinite to another component. Barycentric coordinates as in distances_mm. Within the source's face the
    // distance is the straight line's, taken without CGAL: 5.5 misses that line where it runs on to a corner.
    double distance_mm(const MeshPoint& target) const;

   private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

  // Positions must be unique: coincident ones would part the surface. Throws Error (input) that names a
  // triangle (from 0) which is without area or which would make the surface non-manifold or its orientation
  // disagree.
  CgalGeodesics(std::span<const Vec3d> positions_mm, std::span<const std::array<int, 3>> triangles);
  ~CgalGeodesics();
  CgalGeodesics(const CgalGeodesics&) = delete;
  CgalGeodesics& operator=(const CgalGeodesics&) = delete;

  // The distance along the surface from one point to each of the others; infinite to another component.
  // Barycentric coordinates are raised to 1e-12: a source on an edge is not computed correctly by CGAL 5.5.
  std::vector<double> distances_mm(const MeshPoint& source, std::span<const MeshPoint> targets) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace truescatter
