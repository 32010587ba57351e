#pragma once

#include <span>
#include <vector>

#include "truth/layer_plan.h"
#include "truth/triangle_tree.h"

namespace truescatter {

// What all sums over one surface share.
struct SummedSurface {
  const Surface& surface;
  const TriangleTree& tree;
  const std::vector<TriangleBounds>& bounds;  // per triangle
  bool gray;                                  // R = G = B everywhere: one channel does for three
};

// Reorders `ids` so that those before the returned index lie before the others along the points' longest
// extent; ties by index, so that the cut depends on the points alone. The first part is a multiple of kLanes.
std::size_t split_points(std::span<const SurfacePoint> points, std::span<std::uint32_t> ids);

// Adds `sign` times a plan's sums at points[ids] to out[ids], and reorders `ids`; the points are of one
// component. `only_closed`: the nodes' sums are computed elsewhere.
//
// The points are split into ever smaller clusters, to which the triangles in reach are handed down. A cluster
// of which every point sees a good part of what it reaches makes the quadrature nodes, once; the smallest
// have kLanes points, which take each node in reach together. Scalar: float (to about 1e-6) or double.
template <typename Scalar>
void add_cluster_sums(const SummedSurface& surface, std::span<const SurfacePoint> points,
                      const LayerPlan& plan, double sign, bool only_closed, std::span<std::uint32_t> ids,
                      std::vector<Vec4d>& out);

extern template void add_cluster_sums<float>(const SummedSurface&, std::span<const SurfacePoint>,
                                             const LayerPlan&, double, bool, std::span<std::uint32_t>,
                                             std::vector<Vec4d>&);
extern template void add_cluster_sums<double>(const SummedSurface&, std::span<const SurfacePoint>,
                                              const LayerPlan&, double, bool, std::span<std::uint32_t>,
                                              std::vector<Vec4d>&);

}  // namespace truescatter
