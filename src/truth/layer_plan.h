#pragma once

#include <cstdint>
#include <vector>

#include "truth/edge_formula.h"
#include "truth/quadrature.h"
#include "truth/surface.h"

namespace truescatter {

// What FastEngine asks about each triangle.
struct TriangleBounds {
  Vec3d centroid_mm;
  double radius_mm;  // from there to the farthest corner
  TriangleFrame frame;
};

// Which part of a Gaussian is summed: all of it, or what lies on one side of r_max.
enum class Part { whole, inner, outer };

// Costs, in evaluations of a kernel at one node for one of kLanes points. The figures were measured on one
// machine; they decide about speed alone.
inline constexpr double kClosedCost = 650.0;  // a triangle's closed form at one point

// How one part of one layer is summed: all about it that does not depend on the points but through where they
// are.
struct LayerPlan {
  TruthLayer layer;
  Part part;
  double reach_mm;           // search radius
  double leaf_mm;            // the radius that kLanes neighbouring points commonly have
  std::vector<Split> split;  // per triangle; without a rule: the closed form

  bool is_closed(std::uint32_t triangle) const { return split[triangle].rule == nullptr; }
  // What a triangle whose circle meets a point's reach costs the point, its neighbours considered.
  double cost(std::uint32_t triangle, double radius_mm) const;
};

// What a plan is made for.
struct LayerPart {
  TruthLayer layer;
  Part part;
  double reach_mm;
  double budget;        // of quadrature, of the largest irradiance
  bool closed_allowed;  // where it costs less than nodes do
};

// Chooses each triangle's rule among those that keep the budget. Triangles out of reach of `points_box` are
// left without.
LayerPlan plan_layer(const std::vector<TriangleBounds>& bounds, const Eigen::AlignedBox3d& points_box,
                     double leaf_mm, const LayerPart& wanted);

}  // namespace truescatter
