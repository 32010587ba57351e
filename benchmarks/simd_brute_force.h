#pragma once

#include <vector>

#include "truth/surface.h"

namespace truescatter::benchmarks {

// The plain way to convolve fast: every triangle is split evenly into as few parts as the tolerance allows
// (by FastEngine's bound and budget, so that errors are equal) and each part replaced by the seven nodes of
// one rule; nodes are sorted into cells a third of the cut-off wide, and a point adds up, eight nodes at a
// time in single precision, all nodes of the cells within the cut-off. One component.
class SimdBruteForce {
 public:
  SimdBruteForce(const Surface& surface, double tolerance, double std_dev_mm);

  std::size_t node_count() const { return x_.size(); }
  double cut_off_mm() const { return cut_off_mm_; }
  Vec4d convolve(const Vec3d& point_mm) const;
  // In parallel.
  std::vector<Vec4d> convolve(const std::vector<SurfacePoint>& points) const;

 private:
  using Cell = Eigen::Array3i;
  Cell cell_of(const Vec3d& position_mm) const;
  std::size_t index_of(const Cell& cell) const;

  double std_dev_mm_;
  double cut_off_mm_;
  double cell_mm_;
  Vec3d origin_mm_;
  Cell cells_;
  std::vector<std::size_t> first_;  // by cell, x fastest, and one more
  std::vector<float> x_, y_, z_;    // from the origin
  std::array<std::vector<float>, 4> weight_;
};

}  // namespace truescatter::benchmarks
