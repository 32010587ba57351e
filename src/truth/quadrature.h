#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "truth/surface.h"
#include "truth/triangle_rules.h"

namespace truescatter {

// How a triangle is replaced by quadrature nodes: a rule on each part of a uniform split.
struct Split {
  const TriangleRule* rule = nullptr;  // null: the closed form is cheaper
  int parts = 1;                       // per edge

  std::size_t node_count() const {
    return rule == nullptr ? 0 : rule->nodes.size() * static_cast<std::size_t>(parts * parts);
  }
  bool operator==(const Split&) const = default;
};

// Farthest corner from the centroid.
double centroid_radius_mm(const SurfaceTriangle& triangle);

// Chooses the split with the fewest nodes whose error (gaussian_error) stays within a budget.
class RuleChooser {
 public:
  // For triangles beyond a distance from the point; 0: wherever they lie. A triangle that wants more than
  // `max_parts` per edge takes no rule.
  explicit RuleChooser(double budget, double beyond_std_devs = 0.0, int max_parts = 4);

  // For a triangle whose corners lie within `radius_in_std_devs` of its centroid.
  Split choose(double radius_in_std_devs) const;

  // The split into `factor` times as many parts per edge with the fewest nodes that keeps the error budget
  // wherever `split` does.
  Split finer(const Split& split, int factor) const;

 private:
  std::vector<double> limits_;  // for each rule, the largest x
  int max_parts_;
};

// Calls visit(position_mm, irradiance, area_mm2) for each node of each part of the split triangle; parts that
// `keep(middle_mm, radius_mm)` refuses are left out. The nodes' areas sum to the parts'.
template <typename Keep, typename Visit>
void for_each_node(const SurfaceTriangle& triangle, const Split& split, const Keep& keep,
                   const Visit& visit) {
  const auto at = [](const std::array<Vec3d, 3>& values, const Vec3d& b) -> Vec3d {
    return b.x() * values[0] + b.y() * values[1] + b.z() * values[2];
  };
  const int n = split.parts;
  const double part_area = triangle.area_mm2() / (n * n);
  const double part_radius = centroid_radius_mm(triangle) / n;
  const auto corner = [&](int i, int j) { return Vec3d(Vec3d(n - i - j, i, j) / n); };
  const auto visit_part = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    if (!keep(at(triangle.corners_mm, (a + b + c) / 3.0), part_radius)) return;
    for (const TriangleNode& node : split.rule->nodes) {
      const Vec3d& w = node.barycentric;
      const Vec3d inside = w.x() * a + w.y() * b + w.z() * c;
      visit(at(triangle.corners_mm, inside), at(triangle.irradiance, inside), node.weight * part_area);
    }
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      visit_part(corner(i, j), corner(i + 1, j), corner(i, j + 1));
      if (i + j + 1 < n) visit_part(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  }
}

}  // namespace truescatter
