#pragma once

#include <array>
#include <span>
#include <vector>

#include "irradiance/shadow_scene.h"
#include "scene/mesh.h"
#include "truth/geodesic_surface.h"
#include "truth/triangle_tree.h"

namespace truescatter {

// How the Euclidean convolution of one Gaussian at one point differs from the geodesic one, by the ways that
// the light takes. Each is an integral of (G(|x - x_o|) - G(d)) I dA over a part of S, d being the
// geodesic distance: RGB in the first three entries, with I = 1 in the fourth. The first three sum to M_s
// Euclidean less M_s geodesic, neither cut off, and none is negative where the light is not.
//
// What lies along the surface beyond r_max is subtracted from transmittance and air as well: it goes the way
// that a local method cuts off, not through the body. So both are 0 on a plane, and on a thin sheet's far
// side, which no geodesic reaches, they are the Euclidean integral itself. Where geodesics do reach the far
// part, that integral is larger by at most `beyond`.
struct LightPaths {
  Vec4d transmittance =
      Vec4d::Zero();                // d > r_max, or not to be reached; the straight way lies inside the body
  Vec4d air = Vec4d::Zero();        // the same, where it leaves the body, as across a crease
  Vec4d curvature = Vec4d::Zero();  // d <= r_max
  Vec4d beyond = Vec4d::Zero();     // integral of G(d) I dA over d > r_max: what the cut-off itself costs
  // Integral of G(|x - x_o|) I dA over where transmittance is taken: what comes through the body to a local
  // method that cuts its light off at r_max along the surface. In none of the sums; transmittance is this
  // less what of `beyond` comes from there.
  Vec4d through = Vec4d::Zero();

  Vec4d sum() const { return transmittance + air + curvature; }
};

// Finds them by quadrature: every triangle is cut (its longest edge halved) until no edge is longer than
// `edge_std_devs` s, and a rule of degree 5 with 7 nodes is laid on each part. Nothing beyond the Euclidean
// distance where a plane's remaining mass is 1e-5.
//
// Error. The sum's integrand is continuous, with kinks where two geodesics are equally long: of order h^2.5.
// The parts' integrands jump where d passes r_max and where straight ways begin to leave the body: of first
// order at least, and small on smooth surfaces, where both distances are still alike there. Round a tube of 3
// mm with s = 2.5 mm the default of 0.5 leaves 1e-5 of the sum (the tail) and 1e-4 of the parts
// (tests/truth/light_paths_test.cpp); what it leaves elsewhere shows in the difference between two lengths.
//
// A straight way lies inside if it leaves both of its ends into the body, by their faces' outward normals,
// and nothing crosses it in between (ShadowScene::crossed_between). So the mesh is taken to be closed, its
// faces counter-clockwise from outside; over an open border a way may be taken for one inside.
class LightPathEngine {
 public:
  // `surface` is of `mesh`'s triangles. Both outlive it.
  LightPathEngine(const Mesh& mesh, const GeodesicSurface& surface, double edge_std_devs = 0.5);

  // One point: [std_dev]. `field` is scratch over the surface's mesh; one serves one thread.
  std::vector<LightPaths> split(GeodesicField& field, const GeodesicTarget& target,
                                std::span<const double> std_devs_mm, double r_max_mm) const;
  // In parallel: [std_dev][target].
  std::vector<std::vector<LightPaths>> split(std::span<const GeodesicTarget> targets,
                                             std::span<const double> std_devs_mm, double r_max_mm) const;

  // Beyond the sum's end, of a plane evenly lit.
  static double tail_bound() { return kTail; }

 private:
  // A face's frame in space.
  struct Frame {
    Vec3d origin_mm;
    Vec3d along;  // of its first edge
    Vec3d across;
    Vec3d normal;

    Vec3d position_mm(const Vec2d& x) const { return origin_mm + x.x() * along + x.y() * across; }
  };
  struct Seen;

  static constexpr double kTail = 1e-5;  // of a plane's mass: where the sum ends

  // `part`: its corners, in the piece's barycentric coordinates.
  void add_part(const Seen& seen, std::size_t piece, const std::array<Vec3d, 3>& part,
                LightPaths& paths) const;
  void add_node(const Seen& seen, std::size_t piece, const Vec3d& at, double area_mm2,
                LightPaths& paths) const;

  const GeodesicSurface& surface_;
  ShadowScene body_;
  double edge_std_devs_;
  std::vector<Frame> frames_;       // of faces
  std::vector<std::size_t> faces_;  // of pieces
  Surface in_space_;                // the pieces
  TriangleTree tree_;
};

}  // namespace truescatter
