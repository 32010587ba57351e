#include "scene/builtin.h"
#include "scene/head_atlas.h"
#include "scene/head_shape.h"
#include "scene/implicit_mesh.h"

namespace truescatter {

Mesh make_head(double edge_mm) {
  ImplicitSurface surface;
  surface.value_mm = head_distance_mm;
  surface.sample = head_sample;
  surface.edge_mm = [edge_mm](const Vec3d& p) { return head_edge_mm(p, edge_mm); };
  surface.lower_mm = {-72.0, -112.0, -84.0};
  surface.upper_mm = {72.0, 102.0, 92.0};
  surface.cell_mm = 1.35;
  surface.steepness = 1.6;
  Mesh mesh = mesh_implicit(surface);
  lay_out_head_atlas(mesh);
  return mesh;
}

}  // namespace truescatter
