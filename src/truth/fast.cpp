#include "truth/fast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "core/parallel.h"
#include "truth/exact.h"
#include "truth/gauss_grid.h"
#include "truth/quadrature.h"

namespace truescatter {
namespace {

constexpr double kTailShare = 0.1;        // of the tolerance
constexpr double kQuadratureShare = 0.6;  // of the tolerance
constexpr double kGridShare = 0.1;        // of the tolerance
constexpr double kClusterRadius = 0.25;   // of the search radius: larger clusters are split
constexpr std::size_t kTaskPoints = 1024;

// The integrals along a piece of an edge by Gauss-Legendre quadrature with 6 nodes where that is accurate to
// about 1e-7, else in closed form. The integrand's poles lie at t = +-ip: with half the piece's length a at
// most half the distance from the foot to its middle, the ellipse of analyticity has a radius of at least
// 2 + sqrt(3) (a pole beside the end) or 2 + sqrt(5) (beside the middle), and the error is of the order of
// 3.7^-12 = 1e-7; a <= s keeps the Gaussian's own part below that (0.5^12 / 12!).
EdgeIntegrals edge_inside_fast(double p, double t0, double t1, double std_dev_mm, double at_foot) {
  static constexpr std::array<double, 3> kNodes = {0.2386191860831969, 0.6612093864662645,
                                                   0.9324695142031521};
  static constexpr std::array<double, 3> kWeights = {0.4679139345726910, 0.3607615730481386,
                                                     0.1713244923791704};
  const double half = 0.5 * (t1 - t0);
  const double middle = 0.5 * (t0 + t1);
  if (half > std_dev_mm || 4.0 * half * half > middle * middle + p * p) {
    return edge_inside_exact(p, t0, t1, std_dev_mm, at_foot);
  }
  const double factor = -0.5 / (std_dev_mm * std_dev_mm);
  EdgeIntegrals sum;
  for (std::size_t i = 0; i < 3; ++i) {
    for (const double node : {-kNodes[i], kNodes[i]}) {
      const double t = middle + half * node;
      const double rho2 = p * p + t * t;
      const double gauss = std::exp(rho2 * factor);
      sum.radial += kWeights[i] * (1.0 - gauss) * p / rho2;
      sum.line += kWeights[i] * gauss;
    }
  }
  const double scale = half * at_foot / (2.0 * kPi);
  return {sum.radial * scale, -sum.line * scale};
}

Vec4d convolve_triangle_fast(const SurfaceTriangle& triangle, const Vec3d& point_mm,
                             const TruthLayer& layer) {
  return convolve_triangle_by_edges(triangle, point_mm, layer,
                                    [&](double p, double t0, double t1, double at_foot) {
                                      return edge_inside_fast(p, t0, t1, layer.std_dev_mm, at_foot);
                                    });
}

// What must be known about each triangle, computed once.
struct TriangleBounds {
  Vec3d centroid_mm;
  double radius_mm;
};

// Quadrature nodes of a cluster, relative to its centre so that single precision does not lose digits.
template <typename Scalar>
struct NodeList {
  std::vector<Scalar> x, y, z;
  std::array<std::vector<Scalar>, 4> weight;  // area times R, G, B, 1

  void clear() {
    for (auto* v : {&x, &y, &z}) v->clear();
    for (auto& w : weight) w.clear();
  }
  std::size_t size() const { return x.size(); }
  // Makes room for `count` more nodes; returns the index of the first.
  std::size_t grow(std::size_t count) {
    const std::size_t first = size();
    for (auto* v : {&x, &y, &z}) v->resize(first + count);
    for (auto& w : weight) w.resize(first + count);
    return first;
  }
  void set(std::size_t i, const Vec3d& position, const Vec3d& irradiance, double area) {
    x[i] = static_cast<Scalar>(position.x());
    y[i] = static_cast<Scalar>(position.y());
    z[i] = static_cast<Scalar>(position.z());
    for (std::size_t c = 0; c < 3; ++c) {
      weight[c][i] = static_cast<Scalar>(area * irradiance[static_cast<Eigen::Index>(c)]);
    }
    weight[3][i] = static_cast<Scalar>(area);
  }
  // Appends nodes [begin, end) of a list in world coordinates, moved to `center`.
  void append(const NodeList& world, std::size_t begin, std::size_t end, const Vec3d& center) {
    const std::size_t first = grow(end - begin);
    const auto cx = static_cast<Scalar>(center.x());
    const auto cy = static_cast<Scalar>(center.y());
    const auto cz = static_cast<Scalar>(center.z());
    for (std::size_t i = 0; i < end - begin; ++i) {
      x[first + i] = world.x[begin + i] - cx;
      y[first + i] = world.y[begin + i] - cy;
      z[first + i] = world.z[begin + i] - cz;
    }
    for (std::size_t c = 0; c < 4; ++c) {
      std::copy_n(world.weight[c].begin() + static_cast<std::ptrdiff_t>(begin), end - begin,
                  weight[c].begin() + static_cast<std::ptrdiff_t>(first));
    }
  }
};

// Appends the nodes of a triangle, relative to `center`; parts that `keep` refuses are left out.
template <typename Scalar, typename Keep>
void add_nodes(const SurfaceTriangle& triangle, const Split& split, const Vec3d& center, const Keep& keep,
               NodeList<Scalar>& list) {
  for_each_node(triangle, split, keep, [&](const Vec3d& position, const Vec3d& irradiance, double area) {
    list.set(list.grow(1), position - center, irradiance, area);
  });
}

// sum over nodes [begin, end) of weight * exp(-|x - point|^2 / 2s^2), in blocks that stay in the cache.
template <typename Scalar>
Vec4d sum_nodes(const NodeList<Scalar>& nodes, std::size_t begin, std::size_t end, const Vec3d& point,
                double std_dev_mm, bool gray) {
  using Array = Eigen::Array<Scalar, Eigen::Dynamic, 1>;
  using Block = Eigen::Map<const Array>;
  constexpr Eigen::Index kBlock = 256;
  // Nothing that counts lies this far out (exp(-60) = 9e-27), and denormal numbers are slow.
  constexpr auto kSmallestExponent = Scalar(-60);
  Eigen::Array<Scalar, kBlock, 1> kernel;
  const auto px = static_cast<Scalar>(point.x());
  const auto py = static_cast<Scalar>(point.y());
  const auto pz = static_cast<Scalar>(point.z());
  const auto factor = static_cast<Scalar>(-0.5 / (std_dev_mm * std_dev_mm));
  Vec4d sum = Vec4d::Zero();
  for (std::size_t first = begin; first < end; first += kBlock) {
    const auto n = static_cast<Eigen::Index>(std::min<std::size_t>(kBlock, end - first));
    const Block x(nodes.x.data() + first, n);
    const Block y(nodes.y.data() + first, n);
    const Block z(nodes.z.data() + first, n);
    kernel.head(n) =
        (((x - px).square() + (y - py).square() + (z - pz).square()) * factor).max(kSmallestExponent).exp();
    for (std::size_t c = gray ? 2 : 0; c < 4; ++c) {
      const Block weight(nodes.weight[c].data() + first, n);
      sum[static_cast<Eigen::Index>(c)] += static_cast<double>((kernel.head(n) * weight).sum());
    }
  }
  if (gray) sum[0] = sum[1] = sum[2];
  return sum / (2.0 * kPi * std_dev_mm * std_dev_mm);
}

// Everything about one layer that does not depend on the cluster.
template <typename Scalar>
struct LayerPlan {
  TruthLayer layer;
  double reach_mm;           // search radius
  bool cut;                  // the cut-off lies inside the search radius
  std::vector<Split> split;  // per triangle
  // Per triangle, and one more: nodes that are kept, in world coordinates. Empty until keep_nodes.
  std::vector<std::size_t> node_begin;
  NodeList<Scalar> nodes;
};

template <typename Scalar>
LayerPlan<Scalar> plan_layer(const std::vector<TriangleBounds>& bounds, const RuleChooser& chooser,
                             const TruthLayer& layer, double tail_mm) {
  LayerPlan<Scalar> plan{layer, std::min(tail_mm, layer.r_max_mm), layer.r_max_mm < tail_mm, {}, {}, {}};
  plan.split.reserve(bounds.size());
  for (const TriangleBounds& bound : bounds)
    plan.split.push_back(chooser.choose(bound.radius_mm / layer.std_dev_mm));
  return plan;
}

// Triangles that are split a little are met by many clusters: their nodes are computed once per layer.
constexpr int kMaxKeptSplit = 4;
constexpr std::size_t kMaxKeptNodes = 20'000'000;

template <typename Scalar>
void keep_nodes(const Surface& surface, LayerPlan<Scalar>& plan) {
  const auto keeps = [](const Split& split) { return split.rule != nullptr && split.parts <= kMaxKeptSplit; };
  std::size_t wanted = 0;
  for (const Split& split : plan.split) wanted += keeps(split) ? split.node_count() : 0;
  plan.node_begin.assign(1, 0);
  for (std::size_t t = 0; t < plan.split.size(); ++t) {
    if (wanted <= kMaxKeptNodes && keeps(plan.split[t])) {
      add_nodes(
          surface.triangles[t], plan.split[t], Vec3d::Zero(), [](const Vec3d&, double) { return true; },
          plan.nodes);
    }
    plan.node_begin.push_back(plan.nodes.size());
  }
}

// Reorders `ids` so that the points before the returned index lie before the others along the box's longest
// axis; ties by index, so that the cut depends on the points alone.
std::size_t split_at_median(std::span<const SurfacePoint> points, const Eigen::AlignedBox3d& box,
                            std::span<std::uint32_t> ids) {
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t half = ids.size() / 2;
  std::nth_element(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(half), ids.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double ca = points[a].position_mm[axis];
                     const double cb = points[b].position_mm[axis];
                     return ca != cb ? ca < cb : a < b;
                   });
  return half;
}

template <typename Scalar>
class ClusterWorker {
 public:
  using Plan = LayerPlan<Scalar>;

  ClusterWorker(const Surface& surface, const std::vector<TriangleBounds>& bounds, const TriangleTree& tree,
                std::span<const SurfacePoint> points, bool gray, bool nodes_elsewhere)
      : surface_(surface),
        bounds_(bounds),
        tree_(tree),
        points_(points),
        gray_(gray),
        nodes_elsewhere_(nodes_elsewhere) {}

  // Splits `ids` (reordering it) until each cluster is small against the search radius, and adds its sums.
  void process(std::span<std::uint32_t> ids, const Plan& plan, std::vector<Vec4d>& out) {
    Eigen::AlignedBox3d box;
    for (const std::uint32_t id : ids) box.extend(points_[id].position_mm);
    const double radius_mm = 0.5 * box.diagonal().norm();
    if (radius_mm > kClusterRadius * plan.reach_mm && ids.size() > 1) {
      const std::size_t half = split_at_median(points_, box, ids);
      process(ids.first(half), plan, out);
      process(ids.subspan(half), plan, out);
      return;
    }
    gather(box.center(), radius_mm, points_[ids.front()].component, plan);
    if (nodes_elsewhere_ && closed_.empty()) return;
    for (const std::uint32_t id : ids) out[id] += evaluate(points_[id].position_mm, plan);
  }

 private:
  struct Range {
    std::uint32_t triangle;
    std::size_t begin;
    std::size_t end;  // empty: closed form
  };

  void gather(const Vec3d& center, double cluster_radius, int component, const Plan& plan) {
    center_ = center;
    nodes_.clear();
    crossing_nodes_.clear();
    closed_.clear();
    crossing_.clear();
    tree_.find(center, plan.reach_mm + cluster_radius, component, found_);
    for (const std::uint32_t t : found_) {
      const double distance = (bounds_[t].centroid_mm - center).norm();
      const double slack = bounds_[t].radius_mm + cluster_radius;
      if (distance - slack > plan.reach_mm) continue;
      const bool may_cross = plan.cut && distance + slack > plan.layer.r_max_mm;
      const bool closed = plan.split[t].rule == nullptr;
      if (may_cross) {
        const std::size_t begin = crossing_nodes_.size();
        if (!closed) append_nodes(t, plan, cluster_radius, crossing_nodes_);
        crossing_.push_back({t, begin, crossing_nodes_.size()});
      } else if (closed) {
        closed_.push_back(t);
      } else if (!nodes_elsewhere_) {
        append_nodes(t, plan, cluster_radius, nodes_);
      }
    }
  }

  // All nodes of a triangle, or those in reach of the cluster.
  void append_nodes(std::uint32_t t, const Plan& plan, double cluster_radius, NodeList<Scalar>& list) const {
    if (plan.node_begin[t] < plan.node_begin[t + 1]) {
      list.append(plan.nodes, plan.node_begin[t], plan.node_begin[t + 1], center_);
      return;
    }
    const auto in_reach = [&](const Vec3d& middle, double radius) {
      return (middle - center_).norm() - radius - cluster_radius <= plan.reach_mm;
    };
    add_nodes(surface_.triangles[t], plan.split[t], center_, in_reach, list);
  }

  Vec4d evaluate(const Vec3d& point, const Plan& plan) const {
    const double s = plan.layer.std_dev_mm;
    Vec4d sum = sum_nodes(nodes_, 0, nodes_.size(), point - center_, s, gray_);
    const TruthLayer uncut{s, std::numeric_limits<double>::infinity()};
    for (const std::uint32_t t : closed_) {
      if ((bounds_[t].centroid_mm - point).norm() - bounds_[t].radius_mm > plan.reach_mm) continue;
      sum += convolve_triangle_fast(surface_.triangles[t], point, uncut);
    }
    for (const Range& range : crossing_) sum += evaluate_crossing(range, point, plan);
    return sum;
  }

  // A triangle that the cut-off sphere crosses for some point of the cluster; for this one it may lie inside
  // or outside.
  Vec4d evaluate_crossing(const Range& range, const Vec3d& point, const Plan& plan) const {
    const TriangleBounds& bound = bounds_[range.triangle];
    const double distance = (bound.centroid_mm - point).norm();
    if (distance - bound.radius_mm >= plan.layer.r_max_mm) return Vec4d::Zero();
    const SurfaceTriangle& triangle = surface_.triangles[range.triangle];
    double farthest2 = 0.0;
    for (const Vec3d& corner : triangle.corners_mm)
      farthest2 = std::max(farthest2, (corner - point).squaredNorm());
    const bool inside = farthest2 <= plan.layer.r_max_mm * plan.layer.r_max_mm;
    if (inside && range.begin < range.end) {
      return sum_nodes(crossing_nodes_, range.begin, range.end, point - center_, plan.layer.std_dev_mm,
                       gray_);
    }
    return convolve_triangle_fast(triangle, point, plan.layer);
  }

  const Surface& surface_;
  const std::vector<TriangleBounds>& bounds_;
  const TriangleTree& tree_;
  std::span<const SurfacePoint> points_;
  bool gray_;
  bool nodes_elsewhere_;  // the nodes' sums are computed on a grid: only closed forms are left
  Vec3d center_ = Vec3d::Zero();
  NodeList<Scalar> nodes_;
  NodeList<Scalar> crossing_nodes_;
  std::vector<std::uint32_t> closed_;
  std::vector<Range> crossing_;
  std::vector<std::uint32_t> found_;
};

// Points of one component, cut into boxes of at most kTaskPoints: the units of parallel work. The cut depends
// on the points alone.
void cut_into_tasks(std::span<const SurfacePoint> points, std::span<std::uint32_t> ids,
                    std::vector<std::span<std::uint32_t>>& tasks) {
  if (ids.size() <= kTaskPoints) {
    if (!ids.empty()) tasks.push_back(ids);
    return;
  }
  Eigen::AlignedBox3d box;
  for (const std::uint32_t id : ids) box.extend(points[id].position_mm);
  const std::size_t half = split_at_median(points, box, ids);
  cut_into_tasks(points, ids.first(half), tasks);
  cut_into_tasks(points, ids.subspan(half), tasks);
}

// Under white light the three channels are one: a scene needs no more.
bool is_gray(const Surface& surface) {
  return std::all_of(surface.triangles.begin(), surface.triangles.end(), [](const SurfaceTriangle& triangle) {
    return std::all_of(triangle.irradiance.begin(), triangle.irradiance.end(),
                       [](const Vec3d& v) { return v.x() == v.y() && v.y() == v.z(); });
  });
}

double tail_radius_std_devs(double tolerance) { return std::sqrt(-2.0 * std::log(kTailShare * tolerance)); }

using Tasks = std::vector<std::span<std::uint32_t>>;

// What a sum over nodes costs, in evaluations of a kernel at one node: directly, and by way of the grid. The
// figures were measured on one machine; they decide about speed alone.
constexpr double kVisitCost = 80.0;    // spreading a node or gathering a point
constexpr double kGroupCost = 2000.0;  // reading or writing the lattice points around one cell

// Triangles within reach of any of the tasks' points, ascending.
std::vector<std::uint32_t> triangles_near(const TriangleTree& tree, std::span<const SurfacePoint> points,
                                          const Tasks& tasks, double reach_mm) {
  std::vector<std::vector<std::uint32_t>> found(tasks.size());
  parallel_for(tasks.size(), [&](std::size_t t) {
    Eigen::AlignedBox3d box;
    for (const std::uint32_t id : tasks[t]) box.extend(points[id].position_mm);
    tree.find(box.center(), reach_mm + 0.5 * box.diagonal().norm(), points[tasks[t].front()].component,
              found[t]);
  });
  std::vector<std::uint32_t> all;
  for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// The nodes of triangles that have any.
std::vector<GaussSource> grid_sources(const Surface& surface, const std::vector<Split>& split,
                                      const std::vector<std::uint32_t>& triangles) {
  std::vector<std::size_t> begin = {0};
  for (const std::uint32_t t : triangles) begin.push_back(begin.back() + split[t].node_count());
  std::vector<GaussSource> sources(begin.back());
  constexpr std::size_t kChunk = 256;
  parallel_for((triangles.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(triangles.size(), (chunk + 1) * kChunk); ++i) {
      if (split[triangles[i]].rule == nullptr) continue;
      std::size_t next = begin[i];
      for_each_node(
          surface.triangles[triangles[i]], split[triangles[i]], [](const Vec3d&, double) { return true; },
          [&](const Vec3d& position, const Vec3d& irradiance, double area) {
            sources[next++] = {position,
                               {area * irradiance.x(), area * irradiance.y(), area * irradiance.z(), area}};
          });
    }
  });
  return sources;
}

// The convolution of one component's points with one layer.
template <typename Scalar>
class ComponentConvolution {
 public:
  ComponentConvolution(const Surface& surface, const TriangleTree& tree,
                       const std::vector<TriangleBounds>& bounds, std::span<const SurfacePoint> points,
                       const Tasks& tasks, double tolerance, bool gray)
      : surface_(surface),
        tree_(tree),
        bounds_(bounds),
        points_(points),
        tasks_(tasks),
        tolerance_(tolerance),
        gray_(gray) {
    for (const auto& task : tasks) point_count_ += task.size();
  }

  void add_to(std::vector<Vec4d>& out, LayerPlan<Scalar>& plan,
              const std::function<void(std::size_t)>& advance) const {
    const bool on_grid = !plan.cut && add_on_grid(plan, out);
    if (!on_grid && plan.node_begin.empty()) keep_nodes(surface_, plan);
    parallel_for(tasks_.size(), [&](std::size_t t) {
      ClusterWorker<Scalar> worker(surface_, bounds_, tree_, points_, gray_, on_grid);
      worker.process(tasks_[t], plan, out);
      if (advance) advance(tasks_[t].size());
    });
  }

 private:
  // Nodes within reach of a point, from a sample of the tasks.
  double nodes_per_point(const LayerPlan<Scalar>& plan) const {
    constexpr std::size_t kSample = 16;
    const std::size_t stride = std::max<std::size_t>(1, tasks_.size() / kSample);
    std::size_t nodes = 0;
    std::size_t sampled = 0;
    std::vector<std::uint32_t> near;
    for (std::size_t t = 0; t < tasks_.size(); t += stride, ++sampled) {
      const SurfacePoint& point = points_[tasks_[t].front()];
      tree_.find(point.position_mm, plan.reach_mm, point.component, near);
      for (const std::uint32_t id : near) nodes += plan.split[id].node_count();
    }
    return static_cast<double>(nodes) / static_cast<double>(sampled);
  }

  // Adds the nodes' sums by way of a grid, if that is the cheaper way.
  bool add_on_grid(const LayerPlan<Scalar>& plan, std::vector<Vec4d>& out) const {
    const double s = plan.layer.std_dev_mm;
    const GaussLattice lattice(s, kGridShare * tolerance_);
    const auto count = static_cast<double>(point_count_);
    const double direct = count * nodes_per_point(plan);
    if (direct < count * kVisitCost) return false;
    // Lattice points reach along each axis; a source takes part if both it and a point reach one.
    const double reach_mm = std::sqrt(3.0) * 2.0 * lattice.reach_mm;
    const std::vector<std::uint32_t> near =
        triangles_near(tree_, points_, tasks_, std::min(reach_mm, plan.reach_mm));
    double nodes = 0.0;
    double cells = 0.0;
    const double cell_mm = kGaussBlock * lattice.step_mm;
    for (const std::uint32_t t : near) {
      nodes += static_cast<double>(plan.split[t].node_count());
      cells += 2.0 * surface_.triangles[t].area_mm2() / (cell_mm * cell_mm);
    }
    const double grid =
        kVisitCost * (nodes + count) + kGroupCost * (std::min(nodes, cells) + std::min(count, cells));
    if (direct < grid) return false;
    std::vector<std::uint32_t> ids;
    std::vector<Vec3d> positions;
    for (const auto& task : tasks_) ids.insert(ids.end(), task.begin(), task.end());
    for (const std::uint32_t id : ids) positions.push_back(points_[id].position_mm);
    std::vector<Vec4d> sums(ids.size(), Vec4d::Zero());
    add_gauss_sums<Scalar>(lattice, s, grid_sources(surface_, plan.split, near), positions, gray_, sums);
    for (std::size_t i = 0; i < ids.size(); ++i) out[ids[i]] += sums[i];
    return true;
  }

  const Surface& surface_;
  const TriangleTree& tree_;
  const std::vector<TriangleBounds>& bounds_;
  std::span<const SurfacePoint> points_;
  const Tasks& tasks_;
  double tolerance_;
  bool gray_;
  std::size_t point_count_ = 0;
};

template <typename Scalar>
void convolve_with(const Surface& surface, const TriangleTree& tree, double tolerance,
                   std::span<const SurfacePoint> points, std::span<const TruthLayer> layers,
                   const std::function<void(std::size_t)>& advance, TruthValues& values) {
  std::vector<TriangleBounds> bounds;
  for (const SurfaceTriangle& t : surface.triangles)
    bounds.push_back({t.centroid_mm(), centroid_radius_mm(t)});
  const RuleChooser chooser(kQuadratureShare * tolerance);

  std::map<int, std::vector<std::uint32_t>> by_component;
  for (std::uint32_t i = 0; i < points.size(); ++i) by_component[points[i].component].push_back(i);
  std::map<int, Tasks> tasks;
  for (auto& [component, ids] : by_component) cut_into_tasks(points, ids, tasks[component]);

  const bool gray = is_gray(surface);
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const double tail_mm = tail_radius_std_devs(tolerance) * layers[l].std_dev_mm;
    LayerPlan<Scalar> plan = plan_layer<Scalar>(bounds, chooser, layers[l], tail_mm);
    for (const auto& [component, some] : tasks) {
      ComponentConvolution<Scalar>(surface, tree, bounds, points, some, tolerance, gray)
          .add_to(values[l], plan, advance);
    }
  }
}

}  // namespace

FastEngine::FastEngine(const Surface& surface, double tolerance)
    : surface_(surface), tree_(surface), tolerance_(tolerance) {
  assert(tolerance > 0.0);
}

double FastEngine::tail_bound() const { return 2.0 * (kTailShare + kGridShare) * tolerance_; }

TruthValues FastEngine::convolve(std::span<const SurfacePoint> points, std::span<const TruthLayer> layers,
                                 const std::function<void(std::size_t)>& advance) const {
  TruthValues values(layers.size(), std::vector<Vec4d>(points.size(), Vec4d::Zero()));
  if (tolerance_ >= 1e-5) {
    convolve_with<float>(surface_, tree_, tolerance_, points, layers, advance, values);
  } else {
    convolve_with<double>(surface_, tree_, tolerance_, points, layers, advance, values);
  }
  return values;
}

}  // namespace truescatter
