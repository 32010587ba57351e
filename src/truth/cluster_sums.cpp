#include "truth/cluster_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "truth/edge_fast.h"
#include "truth/exact.h"
#include "truth/lanes.h"

namespace truescatter {
namespace {

constexpr double kMaxGather =
    4.0;  // radius of a cluster that makes nodes, in reaches: digits are lost beyond
constexpr std::uint32_t kMaxRecent = 256;  // nodes that are summed in single precision
constexpr double kMaxLeaf = 1.5;           // radius of a leaf, in reaches: beyond, two leaves see fewer nodes

// Closed forms by tables where single precision will do, to rounding elsewhere.
template <typename Scalar>
constexpr bool kByTables = std::is_same_v<Scalar, float>;

template <typename Scalar>
Vec4d convolve_inner_part_as(const SurfaceTriangle& triangle, const TriangleFrame& frame,
                             const Vec3d& point_mm, const TruthLayer& layer) {
  return convolve_inner_part(
      triangle, frame, point_mm, layer, [&](double p, double t0, double t1, double at_foot) {
        return kByTables<Scalar> ? edge_inside_fast(p, t0, t1, layer.std_dev_mm, at_foot)
                                 : edge_inside_exact(p, t0, t1, layer.std_dev_mm, at_foot);
      });
}

template <typename Scalar>
Vec4d convolve_outer_part_as(const SurfaceTriangle& triangle, const TriangleFrame& frame,
                             const Vec3d& point_mm, const TruthLayer& layer) {
  return convolve_outer_part(triangle, frame, point_mm, layer,
                             [&](double p, double t0, double t1, double h, double at_cut) {
                               if constexpr (kByTables<Scalar>)
                                 return edge_outside_fast(p, t0, t1, h, layer.std_dev_mm, at_cut);
                               const double at_foot = gauss_at(h, layer.std_dev_mm);
                               EdgeIntegrals sum = edge_inside_exact(p, t0, t1, layer.std_dev_mm, at_foot);
                               sum.radial -= edge_beyond_cut(p, t0, t1, at_foot, at_cut).radial;
                               return sum;
                             });
}

Eigen::AlignedBox3d box_of(std::span<const SurfacePoint> points, std::span<const std::uint32_t> ids) {
  Eigen::AlignedBox3d box;
  for (const std::uint32_t id : ids) box.extend(points[id].position_mm);
  return box;
}

template <typename Scalar>
class ClusterSums {
 public:
  ClusterSums(const SummedSurface& surface, std::span<const SurfacePoint> points, const LayerPlan& plan,
              double sign, bool only_closed, std::vector<Vec4d>& out)
      : surface_(surface),
        points_(points),
        plan_(plan),
        sign_(sign),
        only_closed_(only_closed),
        out_(out),
        unit_per_mm_(std::sqrt(0.5 * std::log2(std::exp(1.0))) / plan.layer.std_dev_mm),
        reach_(static_cast<Scalar>(unit_per_mm_ * plan.reach_mm)) {}

  void add(std::span<std::uint32_t> ids) {
    const Eigen::AlignedBox3d box = box_of(points_, ids);
    std::vector<std::uint32_t> found;
    surface_.tree.find(box.center(), plan_.reach_mm + 0.5 * box.diagonal().norm(),
                       points_[ids.front()].component, found);
    for (const std::uint32_t t : found) {
      if (!only_closed_ || plan_.is_closed(t))
        candidates_.push_back({surface_.bounds[t].centroid_mm, surface_.bounds[t].radius_mm, t, 0, 0});
    }
    add_cluster(ids, 0, false);
  }

 private:
  using Lane = Lanes<Scalar>;
  using Vector = Eigen::Matrix<Scalar, 3, 1>;

  // Lengths of nodes and runs are in units in which the Gaussian is 2^(-r^2), from the centre of the cluster
  // that made them.
  struct Node {
    Vector position;
    std::array<Scalar, 4> weight;  // area times R, G, B, 1
  };
  // Nodes that are taken or left together.
  struct Run {
    Vector middle;
    Scalar radius;
    std::uint32_t begin;
    std::uint32_t end;
  };
  struct Candidate {
    Vec3d centroid_mm;
    double radius_mm;
    std::uint32_t triangle;
    std::uint32_t first_run;
    std::uint32_t last_run;
  };
  // Up to kLanes points; the rest repeat the first.
  struct Leaf {
    std::span<const std::uint32_t> ids;
    Vec3d center_mm;
    double radius_mm;
    Vector center;
    Scalar reach_and_radius;
    std::array<Lane, 3> position;
  };

  // R, G, B, mass of a leaf's points. So that single precision does not lose digits over many nodes, it holds
  // but a few of them.
  struct Sums {
    std::array<Lane, 4> recent{};
    std::array<Lanes<double>, 4> total{};
    std::uint32_t recent_nodes = 0;

    void settle() {
      for (std::size_t c = 0; c < 4; ++c) total[c] += __builtin_convertvector(recent[c], Lanes<double>);
      recent = {};
      recent_nodes = 0;
    }
  };

  // The cluster's candidates are chosen from those from `parent` on, and follow them while it is at work.
  void add_cluster(std::span<std::uint32_t> ids, std::size_t parent, bool has_nodes) {
    const Eigen::AlignedBox3d box = box_of(points_, ids);
    const double radius_mm = 0.5 * box.diagonal().norm();
    const std::size_t mine = candidates_.size();
    choose_candidates(box.center(), radius_mm, parent, mine);
    const bool is_leaf = ids.size() == 1 || (ids.size() <= kLanes && radius_mm <= kMaxLeaf * plan_.reach_mm);
    const double spread = 1.0 + radius_mm / plan_.reach_mm;
    // Sees each of its points a good part of all that it reaches?
    const bool is_dense =
        radius_mm <= kMaxGather * plan_.reach_mm && spread * spread <= static_cast<double>(ids.size());
    const bool gathers = !has_nodes && (is_leaf || is_dense);
    if (gathers) gather(box.center(), radius_mm, mine);
    if (is_leaf) {
      add_leaf(ids, box.center(), radius_mm, mine);
    } else {
      const std::size_t half = split_points(points_, ids);
      add_cluster(ids.first(half), mine, has_nodes || gathers);
      add_cluster(ids.subspan(half), mine, has_nodes || gathers);
    }
    candidates_.resize(mine);
  }

  void choose_candidates(const Vec3d& center, double cluster_radius_mm, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Candidate candidate = candidates_[i];
      const double distance2 = (candidate.centroid_mm - center).squaredNorm();
      const double slack = candidate.radius_mm + cluster_radius_mm;
      const double farthest = plan_.reach_mm + slack;
      if (distance2 > farthest * farthest) continue;
      const double inside = plan_.layer.r_max_mm - slack;
      if (plan_.part == Part::outer && inside > 0.0 && distance2 < inside * inside) continue;
      candidates_.push_back(candidate);
    }
  }

  Vector in_units(const Vec3d& position_mm) const {
    return (unit_per_mm_ * (position_mm - origin_mm_)).template cast<Scalar>();
  }

  // Makes the nodes of the candidates from `first` on, but for parts out of the cluster's reach.
  void gather(const Vec3d& center, double cluster_radius_mm, std::size_t first) {
    origin_mm_ = center;
    nodes_.clear();
    runs_.clear();
    const double reach_mm = plan_.reach_mm + cluster_radius_mm;
    for (std::size_t i = first; i < candidates_.size(); ++i) {
      Candidate& candidate = candidates_[i];
      if (plan_.is_closed(candidate.triangle)) continue;
      candidate.first_run = static_cast<std::uint32_t>(runs_.size());
      const auto begin_run = [&](const Vec3d& middle_mm, double radius_mm) {
        if ((middle_mm - center).norm() - radius_mm > reach_mm) return false;
        const auto begin = static_cast<std::uint32_t>(nodes_.size());
        runs_.push_back({in_units(middle_mm), static_cast<Scalar>(unit_per_mm_ * radius_mm), begin, begin});
        return true;
      };
      const auto add_node = [&](const Vec3d& position_mm, const Vec3d& irradiance, double area_mm2) {
        const auto weight = [&](Eigen::Index c) { return static_cast<Scalar>(area_mm2 * irradiance[c]); };
        nodes_.push_back(
            {in_units(position_mm), {weight(0), weight(1), weight(2), static_cast<Scalar>(area_mm2)}});
        ++runs_.back().end;
      };
      for_each_node(surface_.surface.triangles[candidate.triangle], plan_.split[candidate.triangle],
                    begin_run, add_node);
      candidate.last_run = static_cast<std::uint32_t>(runs_.size());
    }
  }

  Leaf make_leaf(std::span<const std::uint32_t> ids, const Vec3d& center_mm, double radius_mm) const {
    Leaf leaf{ids, center_mm, radius_mm, in_units(center_mm), Scalar(0), {}};
    leaf.reach_and_radius = static_cast<Scalar>(unit_per_mm_ * (plan_.reach_mm + radius_mm));
    for (std::size_t k = 0; k < kLanes; ++k) {
      const Vector position = in_units(points_[ids[k < ids.size() ? k : 0]].position_mm);
      for (std::size_t a = 0; a < 3; ++a) leaf.position[a][k] = position[static_cast<Eigen::Index>(a)];
    }
    return leaf;
  }

  void add_leaf(std::span<const std::uint32_t> ids, const Vec3d& center_mm, double radius_mm,
                std::size_t first) {
    if (first == candidates_.size()) return;
    const Leaf leaf = make_leaf(ids, center_mm, radius_mm);
    Sums sums;
    for (std::size_t i = first; i < candidates_.size(); ++i) {
      const Candidate& candidate = candidates_[i];
      if (plan_.is_closed(candidate.triangle)) {
        for (const std::uint32_t id : ids) {
          if ((candidate.centroid_mm - points_[id].position_mm).norm() - candidate.radius_mm <=
              plan_.reach_mm)
            add_closed_form(candidate.triangle, id);
        }
      } else if (plan_.part != Part::whole && is_crossed(candidate, leaf)) {
        add_crossed(candidate, leaf, sums);
      } else {
        add_runs(candidate, leaf, sums);
      }
    }
    sums.settle();
    const double s = plan_.layer.std_dev_mm;
    const double scale = sign_ / (2.0 * kPi * s * s);
    for (std::size_t k = 0; k < ids.size(); ++k) {
      for (std::size_t c = 0; c < 4; ++c) {
        const std::size_t from = surface_.gray && c < 3 ? 2 : c;
        out_[ids[k]][static_cast<Eigen::Index>(c)] += scale * sums.total[from][k];
      }
    }
  }

  // weight * 2^(-|x - point|^2) over the candidate's runs in reach, at all points of the leaf.
  void add_runs(const Candidate& candidate, const Leaf& leaf, Sums& sums) const {
    for (std::uint32_t r = candidate.first_run; r < candidate.last_run; ++r) {
      const Run& run = runs_[r];
      const Scalar farthest = leaf.reach_and_radius + run.radius;
      if ((run.middle - leaf.center).squaredNorm() > farthest * farthest) continue;
      if (!reaches_any(leaf, run)) continue;
      if (surface_.gray) {
        add_nodes<2>(run, leaf, sums.recent);
      } else {
        add_nodes<0>(run, leaf, sums.recent);
      }
      sums.recent_nodes += run.end - run.begin;
      if (sums.recent_nodes >= kMaxRecent) sums.settle();
    }
  }

  // Whether any of the leaf's points, not just its circle, reaches the run.
  bool reaches_any(const Leaf& leaf, const Run& run) const {
    const Lane x = leaf.position[0] - run.middle[0];
    const Lane y = leaf.position[1] - run.middle[1];
    const Lane z = leaf.position[2] - run.middle[2];
    const Scalar farthest = reach_ + run.radius;
    const auto reached = (x * x + y * y + z * z) <= farthest * farthest;
    std::array<std::uint64_t, sizeof(reached) / sizeof(std::uint64_t)> words;
    std::memcpy(words.data(), &reached, sizeof(reached));
    std::uint64_t any = 0;
    for (const std::uint64_t word : words) any |= word;
    return any != 0;
  }

  template <std::size_t kFirstChannel>
  void add_nodes(const Run& run, const Leaf& leaf, std::array<Lane, 4>& sums) const {
    std::array<Lane, 4> total = sums;
    for (std::uint32_t n = run.begin; n < run.end; ++n) {
      const Node& node = nodes_[n];
      const Lane x = leaf.position[0] - node.position[0];
      const Lane y = leaf.position[1] - node.position[1];
      const Lane z = leaf.position[2] - node.position[2];
      Lane kernel = -(x * x + y * y + z * z);
      replace_by_exp2<Scalar>(kernel);
      for (std::size_t c = kFirstChannel; c < 4; ++c) total[c] += kernel * node.weight[c];
    }
    sums = total;
  }

  // Whether the cut-off sphere of some point of the leaf may cross the triangle.
  bool is_crossed(const Candidate& candidate, const Leaf& leaf) const {
    const double distance = (candidate.centroid_mm - leaf.center_mm).norm();
    return std::abs(distance - plan_.layer.r_max_mm) < candidate.radius_mm + leaf.radius_mm;
  }

  // Point by point: the closed form if the sphere cuts the triangle, else all of its nodes or none.
  void add_crossed(const Candidate& candidate, const Leaf& leaf, Sums& sums) {
    Sums all;
    add_runs(candidate, leaf, all);
    all.settle();
    const double r_max_mm = plan_.layer.r_max_mm;
    for (std::size_t k = 0; k < leaf.ids.size(); ++k) {
      const Vec3d& point = points_[leaf.ids[k]].position_mm;
      const double distance2 = (candidate.centroid_mm - point).squaredNorm();
      const double farthest = plan_.reach_mm + candidate.radius_mm;
      if (distance2 > farthest * farthest) continue;
      if (is_cut(candidate, distance2, point)) {
        add_closed_form(candidate.triangle, leaf.ids[k]);
      } else if ((distance2 < r_max_mm * r_max_mm) == (plan_.part == Part::inner)) {
        for (std::size_t c = 0; c < 4; ++c) sums.total[c][k] += all.total[c][k];
      }
    }
  }

  // Whether a point's sphere may cut the triangle; otherwise it lies on one side, with its centroid.
  bool is_cut(const Candidate& candidate, double distance2, const Vec3d& point) const {
    const double r_max_mm = plan_.layer.r_max_mm;
    const double nearest = r_max_mm - candidate.radius_mm;
    const double farthest = r_max_mm + candidate.radius_mm;
    if (distance2 >= farthest * farthest || (nearest > 0.0 && distance2 <= nearest * nearest)) return false;
    double farthest2 = 0.0;
    for (const Vec3d& corner : surface_.surface.triangles[candidate.triangle].corners_mm)
      farthest2 = std::max(farthest2, (corner - point).squaredNorm());
    return farthest2 > r_max_mm * r_max_mm;
  }

  void add_closed_form(std::uint32_t t, std::uint32_t id) {
    const SurfaceTriangle& triangle = surface_.surface.triangles[t];
    const TriangleFrame& frame = surface_.bounds[t].frame;
    const Vec3d& point = points_[id].position_mm;
    TruthLayer layer = plan_.layer;
    if (plan_.part == Part::whole) layer.r_max_mm = std::numeric_limits<double>::infinity();
    out_[id] +=
        sign_ * (plan_.part == Part::outer ? convolve_outer_part_as<Scalar>(triangle, frame, point, layer)
                                           : convolve_inner_part_as<Scalar>(triangle, frame, point, layer));
  }

  const SummedSurface& surface_;
  std::span<const SurfacePoint> points_;
  const LayerPlan& plan_;
  double sign_;
  bool only_closed_;
  std::vector<Vec4d>& out_;
  double unit_per_mm_;
  Scalar reach_;  // in units
  Vec3d origin_mm_ = Vec3d::Zero();
  std::vector<Node> nodes_;
  std::vector<Run> runs_;
  std::vector<Candidate> candidates_;  // a stack: those of all points, of the current half, and so on
};

}  // namespace

std::size_t split_points(std::span<const SurfacePoint> points, std::span<std::uint32_t> ids) {
  Eigen::Index axis = 0;
  box_of(points, ids).sizes().maxCoeff(&axis);
  const std::size_t middle = (ids.size() / 2 + kLanes - 1) / kLanes * kLanes;
  const std::size_t half = middle < ids.size() ? middle : ids.size() / 2;
  std::nth_element(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(half), ids.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double ca = points[a].position_mm[axis];
                     const double cb = points[b].position_mm[axis];
                     return ca != cb ? ca < cb : a < b;
                   });
  return half;
}

template <typename Scalar>
void add_cluster_sums(const SummedSurface& surface, std::span<const SurfacePoint> points,
                      const LayerPlan& plan, double sign, bool only_closed, std::span<std::uint32_t> ids,
                      std::vector<Vec4d>& out) {
  if (!ids.empty()) ClusterSums<Scalar>(surface, points, plan, sign, only_closed, out).add(ids);
}

template void add_cluster_sums<float>(const SummedSurface&, std::span<const SurfacePoint>, const LayerPlan&,
                                      double, bool, std::span<std::uint32_t>, std::vector<Vec4d>&);
template void add_cluster_sums<double>(const SummedSurface&, std::span<const SurfacePoint>, const LayerPlan&,
                                       double, bool, std::span<std::uint32_t>, std::vector<Vec4d>&);

}  // namespace truescatter
