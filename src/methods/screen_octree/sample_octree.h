#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// A point that stands for a piece of surface: its area in mm^2 and the irradiance on it.
struct SurfaceSample {
  Vec3d position_mm = Vec3d::Zero();
  Vec3d irradiance = Vec3d::Zero();
  double area_mm2 = 0.0;
};

// The hierarchy of Jensen & Buhler 2002 over such samples: each voxel knows the one sample that stands for
// all in it, their areas summed, positions and irradiance averaged by area.
class SampleOctree {
 public:
  // Samples of positive area.
  explicit SampleOctree(std::vector<SurfaceSample> samples) : samples_(std::move(samples)) {
    if (samples_.empty()) return;
    Vec3d low = samples_.front().position_mm;
    Vec3d high = low;
    for (const SurfaceSample& sample : samples_) {
      low = low.cwiseMin(sample.position_mm);
      high = high.cwiseMax(sample.position_mm);
    }
    build(0, samples_.size(), 0.5 * (low + high), 0.5 * (high - low).maxCoeff(), 0);
  }

  // Calls visit(sample) for what stands for the samples within reach_mm of `from`, and maybe some beyond: a
  // voxel's one sample where `from` is outside the voxel and area / distance^2 < solid_angle, else what is in
  // it.
  template <typename Visit>
  void gather(const Vec3d& from, double reach_mm, double solid_angle, const Visit& visit) const {
    if (!voxels_.empty()) gather(0, from, reach_mm, solid_angle, visit);
  }

 private:
  static constexpr std::size_t kSamplesInALeaf = 8;
  static constexpr int kDeepest = 24;

  struct Voxel {
    Vec3d middle_mm;
    double half_edge_mm;
    SurfaceSample total;
    std::size_t first = 0;  // its samples
    std::size_t last = 0;
    std::vector<std::size_t> children;  // none: a leaf
  };

  std::size_t build(std::size_t first, std::size_t last, const Vec3d& middle_mm, double half_edge_mm,
                    int depth) {
    const std::size_t index = voxels_.size();
    voxels_.push_back({middle_mm, half_edge_mm, total(first, last), first, last, {}});
    if (last - first <= kSamplesInALeaf || depth == kDeepest) return index;
    const std::array<std::size_t, 9> bounds = split(first, last, middle_mm);
    const double quarter_mm = 0.5 * half_edge_mm;
    for (std::size_t octant = 0; octant < 8; ++octant) {
      if (bounds[octant] == bounds[octant + 1]) continue;
      const Vec3d side((octant & 4U) != 0 ? 1.0 : -1.0, (octant & 2U) != 0 ? 1.0 : -1.0,
                       (octant & 1U) != 0 ? 1.0 : -1.0);
      const std::size_t child =
          build(bounds[octant], bounds[octant + 1], middle_mm + quarter_mm * side, quarter_mm, depth + 1);
      voxels_[index].children.push_back(child);
    }
    return index;
  }

  // Sorts the samples by octant (x, y, z from the highest bit on) and gives where each begins.
  std::array<std::size_t, 9> split(std::size_t first, std::size_t last, const Vec3d& middle_mm) {
    std::array<std::size_t, 9> bounds{};
    bounds[0] = first;
    bounds[8] = last;
    for (std::size_t width = 8, axis = 0; width > 1; width /= 2, ++axis) {
      for (std::size_t octant = 0; octant < 8; octant += width) {
        const auto begin = samples_.begin();
        const auto middle = std::partition(begin + static_cast<std::ptrdiff_t>(bounds[octant]),
                                           begin + static_cast<std::ptrdiff_t>(bounds[octant + width]),
                                           [&](const SurfaceSample& sample) {
                                             const auto a = static_cast<Eigen::Index>(axis);
                                             return sample.position_mm[a] < middle_mm[a];
                                           });
        bounds[octant + width / 2] = static_cast<std::size_t>(middle - begin);
      }
    }
    return bounds;
  }

  SurfaceSample total(std::size_t first, std::size_t last) const {
    SurfaceSample sum;
    for (std::size_t i = first; i < last; ++i) {
      const SurfaceSample& sample = samples_[i];
      sum.position_mm += sample.area_mm2 * sample.position_mm;
      sum.irradiance += sample.area_mm2 * sample.irradiance;
      sum.area_mm2 += sample.area_mm2;
    }
    sum.position_mm /= sum.area_mm2;
    sum.irradiance /= sum.area_mm2;
    return sum;
  }

  template <typename Visit>
  void gather(std::size_t index, const Vec3d& from, double reach_mm, double solid_angle,
              const Visit& visit) const {
    const Voxel& voxel = voxels_[index];
    // From the voxel's surface; 0 inside it.
    const Vec3d outside =
        ((from - voxel.middle_mm).cwiseAbs().array() - voxel.half_edge_mm).max(0.0).matrix();
    const double nearest2 = outside.squaredNorm();
    if (nearest2 > reach_mm * reach_mm) return;
    if (nearest2 > 0.0 &&
        voxel.total.area_mm2 < solid_angle * (voxel.total.position_mm - from).squaredNorm()) {
      visit(voxel.total);
      return;
    }
    if (voxel.children.empty()) {
      for (std::size_t i = voxel.first; i < voxel.last; ++i) visit(samples_[i]);
      return;
    }
    for (const std::size_t child : voxel.children) gather(child, from, reach_mm, solid_angle, visit);
  }

  std::vector<SurfaceSample> samples_;
  std::vector<Voxel> voxels_;
};

}  // namespace truescatter
