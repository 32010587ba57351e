#include "truth/triangle_tree.h"

#include <algorithm>
#include <numeric>

namespace truescatter {
namespace {
constexpr std::uint32_t kLeafSize = 8;
}

TriangleTree::TriangleTree(const Surface& surface) {
  boxes_.reserve(surface.triangles.size());
  components_.reserve(surface.triangles.size());
  for (const SurfaceTriangle& triangle : surface.triangles) {
    Eigen::AlignedBox3d box;
    for (const Vec3d& corner : triangle.corners_mm) box.extend(corner);
    boxes_.push_back(box);
    components_.push_back(triangle.component);
  }
  order_.resize(boxes_.size());
  std::iota(order_.begin(), order_.end(), 0U);
  nodes_.reserve(order_.size());
  nodes_.emplace_back();
  build(0, 0, static_cast<std::uint32_t>(order_.size()));
}

void TriangleTree::build(std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
  Eigen::AlignedBox3d box;
  Eigen::AlignedBox3d centers;
  for (std::uint32_t i = begin; i < end; ++i) {
    box.extend(boxes_[order_[i]]);
    centers.extend(boxes_[order_[i]].center());
  }
  nodes_[node].box = box;
  if (end - begin <= kLeafSize) {
    nodes_[node].first = begin;
    nodes_[node].count = end - begin;
    return;
  }
  Eigen::Index axis = 0;
  centers.sizes().maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const double ca = boxes_[a].center()[axis];
    const double cb = boxes_[b].center()[axis];
    return ca != cb ? ca < cb : a < b;
  };
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, before);
  const auto left = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_.emplace_back();
  nodes_[node].first = left;
  build(left, begin, middle);
  build(left + 1, middle, end);
}

void TriangleTree::find(const Vec3d& center_mm, double radius_mm, int component,
                        std::vector<std::uint32_t>& found) const {
  found.clear();
  for_each(center_mm, radius_mm, component, [&](std::uint32_t triangle) { found.push_back(triangle); });
  std::sort(found.begin(), found.end());
}

}  // namespace truescatter
