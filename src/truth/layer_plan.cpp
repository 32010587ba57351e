#include "truth/layer_plan.h"

#include <algorithm>

#include "core/parallel.h"

namespace truescatter {
namespace {

constexpr int kMaxParts = 12;  // per edge of a triangle

// A triangle's nodes that are evaluated for a point whose reach meets the triangle's circle: those of the
// parts that its leaf's reach meets, in the mean over where the triangle lies.
double visited_nodes(const Split& split, double radius_mm, double reach_mm, double leaf_mm) {
  const double ratio = (reach_mm + radius_mm / split.parts + leaf_mm) / (reach_mm + radius_mm);
  return static_cast<double>(split.node_count()) * ratio * ratio;
}

}  // namespace

double LayerPlan::cost(std::uint32_t triangle, double radius_mm) const {
  return is_closed(triangle) ? kClosedCost : visited_nodes(split[triangle], radius_mm, reach_mm, leaf_mm);
}

LayerPlan plan_layer(const std::vector<TriangleBounds>& bounds, const Eigen::AlignedBox3d& points_box,
                     double leaf_mm, const LayerPart& wanted) {
  const double s = wanted.layer.std_dev_mm;
  const double beyond = wanted.part == Part::outer ? wanted.layer.r_max_mm / s : 0.0;
  const RuleChooser chooser(wanted.budget, beyond, kMaxParts);
  LayerPlan plan{wanted.layer, wanted.part, wanted.reach_mm, leaf_mm, {}};
  plan.split.resize(bounds.size());
  constexpr std::size_t kChunk = 4096;
  parallel_for((bounds.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    for (std::size_t t = chunk * kChunk; t < std::min(bounds.size(), (chunk + 1) * kChunk); ++t) {
      const double radius_mm = bounds[t].radius_mm;
      if (points_box.exteriorDistance(bounds[t].centroid_mm) > wanted.reach_mm + radius_mm) continue;
      const Split split = chooser.choose(radius_mm / s);
      if (split.rule == nullptr) continue;
      if (wanted.closed_allowed && visited_nodes(split, radius_mm, wanted.reach_mm, leaf_mm) > kClosedCost)
        continue;
      plan.split[t] = split;
    }
  });
  return plan;
}

}  // namespace truescatter
