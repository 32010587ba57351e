#include "truth/gauss_grid.h"

#include <algorithm>
#include <array>
#include <boost/math/special_functions/erf.hpp>
#include <cassert>
#include <cmath>
#include <unordered_map>

#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace truescatter {
namespace {

using Cell = std::array<std::int32_t, 3>;

// 21 bits an axis; the order is that of (z, y, x).
constexpr int kKeyBits = 21;
std::uint64_t key_of(const Cell& cell) {
  std::uint64_t key = 0;
  for (std::size_t a = 3; a-- > 0;) {
    assert(cell[a] >= 0 && cell[a] < (1 << kKeyBits));
    key = (key << kKeyBits) | static_cast<std::uint64_t>(cell[a]);
  }
  return key;
}

Cell cell_of_key(std::uint64_t key) {
  Cell cell{};
  for (std::int32_t& c : cell) {
    c = static_cast<std::int32_t>(key & ((1U << kKeyBits) - 1));
    key >>= kKeyBits;
  }
  return cell;
}

// Where points and sources sit in the lattice. A point's cell is the first of the `span` blocks per axis that
// hold the lattice points in its reach.
class Placement {
 public:
  Placement(const GaussLattice& lattice, const Eigen::AlignedBox3d& box)
      : origin_(box.min() - Vec3d::Constant(2.0 * lattice.reach_mm)),
        reach_mm_(lattice.reach_mm),
        block_mm_(kGaussBlock * lattice.step_mm) {}

  Cell cell(const Vec3d& x) const {
    Cell cell{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      cell[a] = static_cast<std::int32_t>(std::floor((x[axis] - origin_[axis] - reach_mm_) / block_mm_));
    }
    return cell;
  }

  // Position relative to the first lattice point of `cell`.
  Vec3d local(const Vec3d& x, const Cell& cell) const {
    return x - origin_ - block_mm_ * Vec3d(cell[0], cell[1], cell[2]);
  }

 private:
  Vec3d origin_;
  double reach_mm_;
  double block_mm_;
};

// Items of one cell: order[begin..end).
struct Group {
  std::uint64_t key;
  std::size_t begin;
  std::size_t end;
};

struct Keyed {
  std::uint64_t key;
  std::uint32_t item;

  bool operator<(const Keyed& other) const { return key != other.key ? key < other.key : item < other.item; }
};

struct Groups {
  std::vector<Keyed> order;
  std::vector<Group> groups;
};

template <typename PositionOf>
Groups group_by_cell(const Placement& placement, std::size_t count, const PositionOf& position_of) {
  constexpr std::size_t kChunk = 4096;
  Groups result;
  result.order.resize(count);
  parallel_for((count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i)
      result.order[i] = {key_of(placement.cell(position_of(i))), static_cast<std::uint32_t>(i)};
  });
  parallel_sort(result.order);
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 0 || result.order[i].key != result.order[i - 1].key)
      result.groups.push_back({result.order[i].key, i, i});
    result.groups.back().end = i + 1;
  }
  return result;
}

// The lattice's values in blocks, only where a point will look.
template <typename Scalar>
class Blocks {
 public:
  Blocks(const std::vector<Group>& point_groups, int span, int channels)
      : span_(span), row_(kGaussBlock * channels), size_(kGaussBlock * kGaussBlock * row_) {
    for (const Group& group : point_groups) {
      const Cell first = cell_of_key(group.key);
      for_each_cell(
          first, [&](const Cell& cell, int, int, int) { index_.try_emplace(key_of(cell), index_.size()); });
    }
    values_.assign(index_.size() * static_cast<std::size_t>(size_), Scalar(0));
  }

  // The block's values: by z, then y, then channel, then x. Null where no point looks.
  Scalar* find(const Cell& cell) {
    const auto found = index_.find(key_of(cell));
    return found == index_.end() ? nullptr : values_.data() + found->second * static_cast<std::size_t>(size_);
  }

  // visit(cell, bx, by, bz) for the span^3 cells from `first`.
  template <typename Visit>
  void for_each_cell(const Cell& first, const Visit& visit) const {
    for (int bz = 0; bz < span_; ++bz) {
      for (int by = 0; by < span_; ++by) {
        for (int bx = 0; bx < span_; ++bx)
          visit(Cell{first[0] + bx, first[1] + by, first[2] + bz}, bx, by, bz);
      }
    }
  }

  // visit(row of the block, index of its first x, index of its (y, z) pair) for every row of every block in
  // the span^3 from `first`; indices as in Kernels.
  template <typename Visit>
  void for_each_row(const Cell& first, const Visit& visit) {
    for_each_cell(first, [&](const Cell& cell, int bx, int by, int bz) {
      Scalar* block = find(cell);
      for (int z = 0; z < kGaussBlock; ++z) {
        for (int y = 0; y < kGaussBlock; ++y) {
          visit(block == nullptr ? nullptr : block + (z * kGaussBlock + y) * row_, bx * kGaussBlock,
                (bz * kGaussBlock + z) * span_ * kGaussBlock + by * kGaussBlock + y);
        }
      }
    });
  }

 private:
  int span_;
  int row_;
  int size_;
  std::unordered_map<std::uint64_t, std::size_t> index_;
  std::vector<Scalar> values_;
};

// The kernels of a bundle of points or sources of one cell.
template <typename Scalar>
struct Kernels {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix x;   // lattice points along x, item
  Matrix yz;  // (y, z) pairs, y fastest, item

  // One column per item: exp(-(k h - local)^2 / s^2) for the lattice points k within reach along the axis,
  // and 0 beyond, which also keeps denormal numbers out.
  void set(const GaussLattice& lattice, double std_dev_mm, const std::vector<Vec3d>& local) {
    const Eigen::Index points = lattice.span * kGaussBlock;
    const auto items = static_cast<Eigen::Index>(local.size());
    const auto step = static_cast<Scalar>(lattice.step_mm / std_dev_mm);
    const auto reach = static_cast<Scalar>(lattice.reach_mm / std_dev_mm);
    const Scalar reach2 = reach * reach;
    Matrix axis(points, 3 * items);  // all x, then y, then z
    for (Eigen::Index i = 0; i < 3 * items; ++i) {
      const Vec3d& position = local[static_cast<std::size_t>(i % items)];
      const auto offset = static_cast<Scalar>(position[i / items] / std_dev_mm);
      for (Eigen::Index k = 0; k < points; ++k) {
        const Scalar distance = static_cast<Scalar>(k) * step - offset;
        axis(k, i) = -distance * distance;
      }
    }
    const Matrix kernel = axis.array().exp();
    axis = (axis.array() >= -reach2).select(kernel, Scalar(0));
    x = axis.leftCols(items);
    yz.resize(points * points, items);
    for (Eigen::Index i = 0; i < items; ++i) {
      for (Eigen::Index z = 0; z < points; ++z)
        yz.col(i).segment(z * points, points) = axis(z, 2 * items + i) * axis.col(items + i);
    }
  }
};

constexpr std::size_t kBundle = 64;  // items per matrix product

int channel_count(bool gray) { return gray ? 2 : 4; }
// Index into (R, G, B, mass) of a channel that is carried.
Eigen::Index weight_index(int channel, bool gray) { return gray ? channel + 2 : channel; }

// Calls body(first, last) on bundles of a group's items.
template <typename Body>
void for_each_bundle(const Group& group, const Body& body) {
  for (std::size_t begin = group.begin; begin < group.end; begin += kBundle)
    body(begin, std::min(begin + kBundle, group.end));
}

template <typename Scalar>
class Transform {
 public:
  using Matrix = typename Kernels<Scalar>::Matrix;
  using Run = Eigen::Map<Eigen::Matrix<Scalar, kGaussBlock, 1>>;  // one channel along x

  Transform(const GaussLattice& lattice, double std_dev_mm, const Placement& placement, bool gray)
      : lattice_(lattice), std_dev_mm_(std_dev_mm), placement_(placement), gray_(gray) {}

  void spread(const Groups& groups, const Group& group, std::span<const GaussSource> sources,
              Blocks<Scalar>& blocks) const {
    const Cell cell = cell_of_key(group.key);
    const Eigen::Index points = lattice_.span * kGaussBlock;
    const int channels = channel_count(gray_);
    Matrix sum = Matrix::Zero(points * channels, points * points);
    Kernels<Scalar> kernels;
    std::vector<Vec3d> local;
    Matrix weighted;
    for_each_bundle(group, [&](std::size_t begin, std::size_t end) {
      local.clear();
      for (std::size_t i = begin; i < end; ++i)
        local.push_back(placement_.local(sources[groups.order[i].item].position_mm, cell));
      kernels.set(lattice_, std_dev_mm_, local);
      weighted.resize(points * channels, static_cast<Eigen::Index>(end - begin));
      for (std::size_t i = begin; i < end; ++i) {
        const auto column = static_cast<Eigen::Index>(i - begin);
        const Vec4d& weight = sources[groups.order[i].item].weight;
        for (int c = 0; c < channels; ++c) {
          weighted.col(column).segment(c * points, points) =
              static_cast<Scalar>(weight[weight_index(c, gray_)]) * kernels.x.col(column);
        }
      }
      sum.noalias() += weighted * kernels.yz.transpose();
    });
    blocks.for_each_row(cell, [&](Scalar* row, int first, int pair) {
      if (row == nullptr) return;
      for (int c = 0; c < channels; ++c)
        Run(row + c * kGaussBlock) += sum.col(pair).template segment<kGaussBlock>(c * points + first);
    });
  }

  void gather(const Groups& groups, const Group& group, std::span<const Vec3d> positions,
              Blocks<Scalar>& blocks, std::span<Vec4d> out) const {
    const Cell cell = cell_of_key(group.key);
    const Eigen::Index points = lattice_.span * kGaussBlock;
    const int channels = channel_count(gray_);
    Matrix region(points * channels, points * points);
    blocks.for_each_row(cell, [&](Scalar* row, int first, int pair) {
      assert(row != nullptr);
      for (int c = 0; c < channels; ++c)
        region.col(pair).template segment<kGaussBlock>(c * points + first) = Run(row + c * kGaussBlock);
    });
    Kernels<Scalar> kernels;
    std::vector<Vec3d> local;
    Matrix lines;
    const double s2 = std_dev_mm_ * std_dev_mm_;
    const double h3 = std::pow(lattice_.step_mm, 3);
    const double scale = std::sqrt(2.0 * kPi) * std_dev_mm_ * h3 / (kPi * kPi * kPi * s2 * s2 * s2);
    for_each_bundle(group, [&](std::size_t begin, std::size_t end) {
      local.clear();
      for (std::size_t i = begin; i < end; ++i)
        local.push_back(placement_.local(positions[groups.order[i].item], cell));
      kernels.set(lattice_, std_dev_mm_, local);
      lines.noalias() = region * kernels.yz;
      for (std::size_t i = begin; i < end; ++i) {
        const auto column = static_cast<Eigen::Index>(i - begin);
        const Eigen::Map<const Matrix> line(lines.col(column).data(), points, channels);
        const Eigen::Matrix<Scalar, Eigen::Dynamic, 1> value = line.transpose() * kernels.x.col(column);
        Vec4d& total = out[groups.order[i].item];
        for (int c = 0; c < 4; ++c) total[c] += scale * static_cast<double>(value[gray_ ? c / 3 : c]);
      }
    });
  }

 private:
  const GaussLattice& lattice_;
  double std_dev_mm_;
  const Placement& placement_;
  bool gray_;
};

// Groups whose lattice points do not overlap: cells that are equal modulo `span` along each axis.
std::vector<std::vector<std::size_t>> colours(const std::vector<Group>& groups, int span) {
  std::vector<std::vector<std::size_t>> result(static_cast<std::size_t>(span * span * span));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const Cell cell = cell_of_key(groups[g].key);
    result[static_cast<std::size_t>(((cell[2] % span) * span + cell[1] % span) * span + cell[0] % span)]
        .push_back(g);
  }
  return result;
}

}  // namespace

GaussLattice::GaussLattice(double std_dev_mm, double budget) {
  step_mm = kPi * std_dev_mm / std::sqrt(2.0 * std::log(6.1 / (0.5 * budget)));
  reach_mm = std_dev_mm * boost::math::erfc_inv(0.5 * budget / 6.0);
  // A point lies up to a block beyond the first lattice point in its reach.
  span = static_cast<int>(std::ceil(2.0 * reach_mm / (kGaussBlock * step_mm))) + 1;
}

template <typename Scalar>
void add_gauss_sums(const GaussLattice& lattice, double std_dev_mm, std::span<const GaussSource> sources,
                    std::span<const Vec3d> points, bool gray, std::span<Vec4d> out) {
  assert(points.size() == out.size());
  Eigen::AlignedBox3d box;
  for (const Vec3d& p : points) box.extend(p);
  for (const GaussSource& s : sources) box.extend(s.position_mm);
  const Placement placement(lattice, box);
  const Groups targets = group_by_cell(placement, points.size(), [&](std::size_t i) { return points[i]; });
  const Groups givers =
      group_by_cell(placement, sources.size(), [&](std::size_t i) { return sources[i].position_mm; });
  Blocks<Scalar> blocks(targets.groups, lattice.span, channel_count(gray));
  const Transform<Scalar> transform(lattice, std_dev_mm, placement, gray);
  for (const std::vector<std::size_t>& colour : colours(givers.groups, lattice.span)) {
    parallel_for(colour.size(),
                 [&](std::size_t i) { transform.spread(givers, givers.groups[colour[i]], sources, blocks); });
  }
  parallel_for(targets.groups.size(),
               [&](std::size_t g) { transform.gather(targets, targets.groups[g], points, blocks, out); });
}

template void add_gauss_sums<float>(const GaussLattice&, double, std::span<const GaussSource>,
                                    std::span<const Vec3d>, bool, std::span<Vec4d>);
template void add_gauss_sums<double>(const GaussLattice&, double, std::span<const GaussSource>,
                                     std::span<const Vec3d>, bool, std::span<Vec4d>);

}  // namespace truescatter
