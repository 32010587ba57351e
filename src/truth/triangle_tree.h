#pragma once

#include <cstdint>
#include <vector>

#include "truth/surface.h"

namespace truescatter {

// Finds the triangles of one component near a point: a balanced tree of bounding boxes.
class TriangleTree {
 public:
  explicit TriangleTree(const Surface& surface);

  // Indices, ascending, of the triangles of `component` whose bounding box comes within `radius_mm` of
  // `center_mm`. Appends nothing twice. `found` is cleared first.
  void find(const Vec3d& center_mm, double radius_mm, int component, std::vector<std::uint32_t>& found) const;

  // Calls visit(index) for each of them, in no order.
  template <typename Visit>
  void for_each(const Vec3d& center_mm, double radius_mm, int component, const Visit& visit) const {
    if (order_.empty()) return;
    const double radius2 = radius_mm * radius_mm;
    std::vector<std::uint32_t> stack = {0};
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      stack.pop_back();
      if (node.box.squaredExteriorDistance(center_mm) > radius2) continue;
      if (node.count == 0) {
        stack.push_back(node.first);
        stack.push_back(node.first + 1);
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const std::uint32_t triangle = order_[i];
        if (components_[triangle] != component) continue;
        if (boxes_[triangle].squaredExteriorDistance(center_mm) <= radius2) visit(triangle);
      }
    }
  }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first = 0;  // leaf: first entry of order_; inner: index of the left child, right is + 1
    std::uint32_t count = 0;  // 0 for an inner node
  };

  void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end);

  std::vector<Eigen::AlignedBox3d> boxes_;
  std::vector<int> components_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace truescatter
