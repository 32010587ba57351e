#include "simd_brute_force.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "truth/quadrature.h"

namespace truescatter::benchmarks {
namespace {

// As FastEngine: what lies beyond the distance where a plane's remaining mass is tolerance/10 is left out,
// and nodes may err by 0.6 tolerance.
constexpr double kTailShare = 0.1;
constexpr double kQuadratureShare = 0.6;

// The rule of degree 5 with 7 nodes on as few parts as the budget allows.
Split split_for(const HermiteMoments& moments, double budget, double radius_in_std_devs) {
  const std::span<const TriangleRule> rules = triangle_rules();
  const auto rule =
      std::find_if(rules.begin(), rules.end(), [](const TriangleRule& r) { return r.degree == 5; });
  Split split{&*rule, 1};
  while (gaussian_error(*rule, moments, radius_in_std_devs / split.parts) > budget) ++split.parts;
  return split;
}

struct Node {
  Vec3d position_mm;
  Vec4d weight;
};

}  // namespace

SimdBruteForce::SimdBruteForce(const Surface& surface, double tolerance, double std_dev_mm)
    : std_dev_mm_(std_dev_mm),
      cut_off_mm_(std::sqrt(-2.0 * std::log(kTailShare * tolerance)) * std_dev_mm),
      cell_mm_(cut_off_mm_ / 3.0) {
  const HermiteMoments moments(0.0);
  std::vector<Node> nodes;
  Eigen::AlignedBox3d box;
  for (const SurfaceTriangle& triangle : surface.triangles) {
    const Split split =
        split_for(moments, kQuadratureShare * tolerance, centroid_radius_mm(triangle) / std_dev_mm);
    for_each_node(
        triangle, split, [](const Vec3d&, double) { return true; },
        [&](const Vec3d& position, const Vec3d& irradiance, double area) {
          nodes.push_back(
              {position, Vec4d(area * irradiance.x(), area * irradiance.y(), area * irradiance.z(), area)});
          box.extend(position);
        });
  }
  origin_mm_ = box.min();
  cells_ = ((box.max() - origin_mm_) / cell_mm_).array().floor().cast<int>() + 1;
  std::vector<std::size_t> cell(nodes.size());
  first_.assign(static_cast<std::size_t>(cells_.prod()) + 1, 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    cell[i] = index_of(cell_of(nodes[i].position_mm));
    ++first_[cell[i] + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (auto* v : {&x_, &y_, &z_}) v->resize(nodes.size());
  for (auto& w : weight_) w.resize(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::size_t at = next[cell[i]]++;
    const Vec3d local = nodes[i].position_mm - origin_mm_;
    x_[at] = static_cast<float>(local.x());
    y_[at] = static_cast<float>(local.y());
    z_[at] = static_cast<float>(local.z());
    for (std::size_t c = 0; c < 4; ++c)
      weight_[c][at] = static_cast<float>(nodes[i].weight[static_cast<Eigen::Index>(c)]);
  }
}

SimdBruteForce::Cell SimdBruteForce::cell_of(const Vec3d& position_mm) const {
  const Cell cell = ((position_mm - origin_mm_) / cell_mm_).array().floor().cast<int>();
  return cell.max(0).min(cells_ - 1);
}

std::size_t SimdBruteForce::index_of(const Cell& cell) const {
  return static_cast<std::size_t>(cell.x()) +
         static_cast<std::size_t>(cells_.x()) *
             (static_cast<std::size_t>(cell.y()) +
              static_cast<std::size_t>(cells_.y()) * static_cast<std::size_t>(cell.z()));
}

Vec4d SimdBruteForce::convolve(const Vec3d& point_mm) const {
  constexpr Eigen::Index kBlock = 256;
  using Block = Eigen::Map<const Eigen::ArrayXf>;
  Eigen::Array<float, kBlock, 1> kernel;
  const Eigen::Vector3f p = (point_mm - origin_mm_).cast<float>();
  const auto factor = static_cast<float>(-0.5 / (std_dev_mm_ * std_dev_mm_));
  const Cell low = cell_of(point_mm - Vec3d::Constant(cut_off_mm_));
  const Cell high = cell_of(point_mm + Vec3d::Constant(cut_off_mm_));
  Vec4d sum = Vec4d::Zero();
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      // A row of cells is one run of nodes.
      const std::size_t begin = first_[index_of({low.x(), y, z})];
      const std::size_t end = first_[index_of({high.x(), y, z}) + 1];
      for (std::size_t at = begin; at < end; at += kBlock) {
        const auto n = static_cast<Eigen::Index>(std::min<std::size_t>(kBlock, end - at));
        kernel.head(n) =
            (((Block(x_.data() + at, n) - p.x()).square() + (Block(y_.data() + at, n) - p.y()).square() +
              (Block(z_.data() + at, n) - p.z()).square()) *
             factor)
                .max(-60.0F)
                .exp();
        for (std::size_t c = 0; c < 4; ++c) {
          sum[static_cast<Eigen::Index>(c)] +=
              static_cast<double>((kernel.head(n) * Block(weight_[c].data() + at, n)).sum());
        }
      }
    }
  }
  return sum / (2.0 * kPi * std_dev_mm_ * std_dev_mm_);
}

std::vector<Vec4d> SimdBruteForce::convolve(const std::vector<SurfacePoint>& points) const {
  std::vector<Vec4d> values(points.size());
  constexpr std::size_t kTask = 64;
  parallel_for((points.size() + kTask - 1) / kTask, [&](std::size_t task) {
    for (std::size_t i = task * kTask; i < std::min(points.size(), (task + 1) * kTask); ++i)
      values[i] = convolve(points[i].position_mm);
  });
  return values;
}

}  // namespace truescatter::benchmarks
