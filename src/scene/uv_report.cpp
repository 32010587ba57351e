#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "scene/load_mesh.h"

namespace truescatter {
namespace {

using UvTriangle = std::array<Vec2d, 3>;

constexpr double kOutsideTolerance = 1e-6;
constexpr double kZeroUvArea = 1e-12;
constexpr double kZeroAreaMm2 = 1e-12;
constexpr double kOverlapDepth = 1e-7;  // a thousandth of a texel of the largest textures

double signed_area(const UvTriangle& uv) { return 0.5 * cross(uv[1] - uv[0], uv[2] - uv[0]); }

bool is_outside(const UvTriangle& uv) {
  return std::any_of(uv.begin(), uv.end(), [](const Vec2d& p) {
    return p.minCoeff() < -kOutsideTolerance || p.maxCoeff() > 1.0 + kOutsideTolerance;
  });
}

// How far two triangles overlap when seen along an edge of the first, at the least of its three edges.
double least_depth(const UvTriangle& a, const UvTriangle& b) {
  double least = HUGE_VAL;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vec2d edge = a[(c + 1) % 3] - a[c];
    const double length = edge.norm();
    if (length == 0.0) continue;
    const Vec2d axis = Vec2d(-edge.y(), edge.x()) / length;
    const auto extent = [&axis, &a, c](const UvTriangle& t) {
      const std::array<double, 3> at{axis.dot(t[0] - a[c]), axis.dot(t[1] - a[c]), axis.dot(t[2] - a[c])};
      return std::minmax({at[0], at[1], at[2]});
    };
    const auto [a_low, a_high] = extent(a);
    const auto [b_low, b_high] = extent(b);
    least = std::min(least, std::min(a_high, b_high) - std::max(a_low, b_low));
  }
  return least;
}

// Two convex shapes are apart exactly if they are apart along the normal of one of their edges.
bool interiors_meet(const UvTriangle& a, const UvTriangle& b) {
  return least_depth(a, b) > kOverlapDepth && least_depth(b, a) > kOverlapDepth;
}

struct Box {
  Vec2d low = Vec2d::Constant(HUGE_VAL);
  Vec2d high = Vec2d::Constant(-HUGE_VAL);

  void add(const Box& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  bool meets(const Box& other) const {
    return low.x() < other.high.x() && other.low.x() < high.x() && low.y() < other.high.y() &&
           other.low.y() < high.y();
  }
};

Box box_of(const UvTriangle& uv) {
  return {uv[0].cwiseMin(uv[1]).cwiseMin(uv[2]), uv[0].cwiseMax(uv[1]).cwiseMax(uv[2])};
}

// Finds which triangles share interior points with another. A tree of boxes, not a grid: triangles of very
// different sizes, or all in one place, cost it little, for a search ends at the first hit.
class OverlapFinder {
 public:
  explicit OverlapFinder(std::vector<UvTriangle> triangles)
      : triangles_(std::move(triangles)), order_(triangles_.size()), overlaps_(triangles_.size(), 0) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    boxes_.reserve(triangles_.size());
    for (const UvTriangle& triangle : triangles_) boxes_.push_back(box_of(triangle));
    if (!triangles_.empty()) build(0, triangles_.size());
  }

  std::size_t count() {
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (overlaps_[i] == 0) search(i);
    }
    return static_cast<std::size_t>(std::count(overlaps_.begin(), overlaps_.end(), 1));
  }

 private:
  struct Node {
    Box box;
    std::size_t begin = 0;
    std::size_t end = 0;
    std::size_t right = 0;  // 0: a leaf; the left child follows its parent
  };

  static constexpr std::size_t kLeafSize = 4;

  std::size_t build(std::size_t begin, std::size_t end) {
    const std::size_t index = nodes_.size();
    nodes_.push_back({{}, begin, end, 0});
    Box box;
    for (std::size_t i = begin; i < end; ++i) box.add(boxes_[order_[i]]);
    nodes_[index].box = box;
    if (end - begin <= kLeafSize) return index;
    const Vec2d size = box.high - box.low;
    const int axis = size.x() >= size.y() ? 0 : 1;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [this, axis](std::size_t a, std::size_t b) {
      return std::pair(boxes_[a].low[axis] + boxes_[a].high[axis], a) <
             std::pair(boxes_[b].low[axis] + boxes_[b].high[axis], b);
    });
    build(begin, middle);
    const std::size_t right = build(middle, end);
    nodes_[index].right = right;
    return index;
  }

  void search(std::size_t triangle) {
    std::vector<std::size_t> open{0};
    while (!open.empty()) {
      const std::size_t index = open.back();
      const Node& node = nodes_[index];
      open.pop_back();
      if (!node.box.meets(boxes_[triangle])) continue;
      if (node.right == 0) {
        if (search_leaf(triangle, node)) return;
      } else {
        open.push_back(node.right);
        open.push_back(index + 1);
      }
    }
  }

  bool search_leaf(std::size_t triangle, const Node& leaf) {
    for (std::size_t i = leaf.begin; i < leaf.end; ++i) {
      const std::size_t other = order_[i];
      if (other == triangle || !boxes_[other].meets(boxes_[triangle])) continue;
      if (!interiors_meet(triangles_[triangle], triangles_[other])) continue;
      overlaps_[triangle] = 1;
      overlaps_[other] = 1;
      return true;
    }
    return false;
  }

  std::vector<UvTriangle> triangles_;
  std::vector<std::size_t> order_;
  std::vector<char> overlaps_;
  std::vector<Box> boxes_;
  std::vector<Node> nodes_;
};

// Values with weights, for quantiles.
class WeightedValues {
 public:
  void add(double value, double weight) {
    values_.emplace_back(value, weight);
    total_ += weight;
  }

  // The least value that has at least the fraction `q` of the weight at or below it.
  double quantile(double q, double if_empty) {
    if (values_.empty()) return if_empty;
    std::sort(values_.begin(), values_.end());
    double sum = 0.0;
    for (const auto& [value, weight] : values_) {
      sum += weight;
      if (sum >= q * total_) return value;
    }
    return values_.back().first;
  }

 private:
  std::vector<std::pair<double, double>> values_;
  double total_ = 0.0;
};

// How many triangles are wound against the majority of the area.
std::size_t count_flipped(const std::vector<UvTriangle>& triangles) {
  std::array<double, 2> areas{};
  std::array<std::size_t, 2> counts{};
  for (const UvTriangle& triangle : triangles) {
    const double area = signed_area(triangle);
    const std::size_t side = area > 0.0 ? 1 : 0;
    areas[side] += std::abs(area);
    ++counts[side];
  }
  return areas[1] >= areas[0] ? counts[0] : counts[1];
}

void measure_density(const Mesh& mesh, UvReport& report) {
  WeightedValues mm_per_unit;
  WeightedValues anisotropies;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const UvTriangle& uv = (*mesh.corner_uvs)[t];
    const double area = triangle_area_mm2(mesh, t);
    const double uv_area = std::abs(signed_area(uv));
    if (uv_area < kZeroUvArea || area <= kZeroAreaMm2) continue;
    mm_per_unit.add(std::sqrt(area / uv_area), area);
    const double ratio = uv_anisotropy(mesh, t);
    if (std::isfinite(ratio)) anisotropies.add(std::max(1.0, ratio), area);
  }
  report.mm_per_unit_median = mm_per_unit.quantile(0.5, 0.0);
  report.mm_per_unit_p05 = mm_per_unit.quantile(0.05, 0.0);
  report.mm_per_unit_p95 = mm_per_unit.quantile(0.95, 0.0);
  report.anisotropy_p95 = anisotropies.quantile(0.95, 1.0);
}

}  // namespace

double uv_anisotropy(const Mesh& mesh, std::size_t triangle) {
  const UvTriangle& uv = (*mesh.corner_uvs)[triangle];
  Eigen::Matrix<double, 3, 2> edges;
  edges << mesh.corner(triangle, 1) - mesh.corner(triangle, 0),
      mesh.corner(triangle, 2) - mesh.corner(triangle, 0);
  Eigen::Matrix2d uv_edges;
  uv_edges << uv[1] - uv[0], uv[2] - uv[0];
  const Eigen::Matrix<double, 3, 2> jacobian = edges * uv_edges.inverse();
  const Eigen::Matrix2d metric = jacobian.transpose() * jacobian;
  // Eigenvalues of a symmetric 2x2 matrix; the smaller one from the determinant, without cancellation.
  const double mean = 0.5 * metric.trace();
  const double spread = std::hypot(0.5 * (metric(0, 0) - metric(1, 1)), metric(0, 1));
  return (mean + spread) / std::sqrt(metric.determinant());
}

UvReport inspect_uvs(const Mesh& mesh) {
  UvReport report;
  report.triangles = mesh.triangles.size();
  if (!mesh.corner_uvs) return report;

  std::vector<UvTriangle> with_area;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const UvTriangle& uv = (*mesh.corner_uvs)[t];
    if (is_outside(uv)) ++report.outside_unit_square;
    if (std::abs(signed_area(uv)) >= kZeroUvArea) {
      with_area.push_back(uv);
    } else if (triangle_area_mm2(mesh, t) > kZeroAreaMm2) {
      ++report.zero_area;
    }
  }
  report.flipped = count_flipped(with_area);
  report.overlapping = OverlapFinder(std::move(with_area)).count();
  measure_density(mesh, report);
  return report;
}

}  // namespace truescatter
