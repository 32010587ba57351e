#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "experiment/view_points.h"
#include "irradiance/shading_mesh.h"
#include "truth/geodesic_surface.h"

namespace truescatter {

// The points of a view that are audited.
struct AuditSample {
  std::vector<std::uint32_t> points;  // indices into ViewPoints, each once
  std::size_t random_count = 0;       // of them, the first: a random sample of all points of the view
  std::vector<std::pair<std::string, std::size_t>> classes;  // how many were chosen why, in their order
};

// What the risks are read from.
struct AuditInputs {
  const ShadingMesh& shading;
  const FrameImages& images;
  const ViewPoints& points;
  std::span<const Vec4d> narrowest;           // values of the narrowest Gaussian at the points
  const GeodesicSurface* geodesic = nullptr;  // null where no truth is geodesic
};

// Draws `wanted` points (all, if there are fewer): half random, seeded; half in equal parts from where the
// risk is highest, of each class at most one point on a shading triangle as long as there are others:
//   shadow_edge  the irradiance changes most over the shading triangle
//   crease       the face normal turns most to the next pixel
//   mask_edge    nearest to where S ends, at what is not of it or at an open border, of the points on the
//                triangles that touch it
//   smallest_s   the narrowest Gaussian's mass is farthest from 1, away from that border: the surface bends
//                most within its reach
//   cut_locus    with geodesic truths: nearest to the mesh's sharpest vertex, as angle missing from a full
//                turn there times the barycentric coordinate. A cut locus starts at every such vertex, the
//                kink is as strong as what is missing, and it weighs most where it starts close by.
// What the classes leave, for want of points, is drawn at random.
AuditSample draw_audit_sample(const AuditInputs& inputs, std::size_t wanted, std::uint64_t seed);

}  // namespace truescatter
