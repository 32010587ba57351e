#include "truth/quadrature.h"

#include <algorithm>
#include <limits>

namespace truescatter {

double centroid_radius_mm(const SurfaceTriangle& triangle) {
  const Vec3d centroid = triangle.centroid_mm();
  double radius = 0.0;
  for (const Vec3d& corner : triangle.corners_mm) radius = std::max(radius, (corner - centroid).norm());
  return radius;
}

RuleChooser::RuleChooser(double budget, double beyond_std_devs, int max_parts) : max_parts_(max_parts) {
  static const HermiteMoments everywhere(0.0);  // what most ask for
  const HermiteMoments moments = beyond_std_devs > 0.0 ? HermiteMoments(beyond_std_devs) : everywhere;
  for (const TriangleRule& rule : triangle_rules()) {
    double low = 0.0;
    double high = 3.0;  // beyond, the Taylor series is not looked at
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (gaussian_error(rule, moments, middle) <= budget ? low : high) = middle;
    }
    limits_.push_back(low);
  }
}

Split RuleChooser::choose(double radius_in_std_devs) const {
  Split best;
  std::size_t best_nodes = std::numeric_limits<std::size_t>::max();
  const std::span<const TriangleRule> rules = triangle_rules();
  for (std::size_t r = 0; r < rules.size(); ++r) {
    const double parts = std::ceil(std::max(1.0, radius_in_std_devs / limits_[r]));
    if (parts > max_parts_) continue;
    const Split split{&rules[r], static_cast<int>(parts)};
    if (split.node_count() < best_nodes) {
      best = split;
      best_nodes = split.node_count();
    }
  }
  return best;
}

Split RuleChooser::finer(const Split& split, int factor) const {
  const std::span<const TriangleRule> rules = triangle_rules();
  const double limit = limits_[static_cast<std::size_t>(split.rule - rules.data())];
  Split best{split.rule, factor * split.parts};
  for (std::size_t r = 0; r < rules.size(); ++r) {
    const Split other{&rules[r], best.parts};
    if (factor * limits_[r] >= limit && other.node_count() < best.node_count()) best = other;
  }
  return best;
}

}  // namespace truescatter
