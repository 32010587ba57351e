#include "truth/fast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "truth/edge_fast.h"
#include "truth/exact.h"
#include "truth/gauss_grid.h"
#include "truth/quadrature.h"

namespace truescatter {
namespace {

constexpr double kTailShare = 0.1;         // of the tolerance
constexpr double kQuadratureShare = 0.6;   // of the tolerance
constexpr double kOuterShare = 0.2;        // of the tolerance, out of the quadrature's
constexpr double kGridShare = 0.1;         // of the tolerance
constexpr double kClusterRadius = 0.25;    // of the search radius: larger clusters are split ...
constexpr double kClusterTriangles = 0.5;  // ... unless they are smaller than that of a triangle
constexpr std::size_t kMaxNodes = 64;      // of a triangle: with more, the closed form is cheaper
constexpr std::size_t kTaskPoints = 1024;

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

// Which part of a Gaussian is summed: all of it, or what lies on one side of r_max.
enum class Part { whole, inner, outer };

// sum over nodes [begin, end) of weight * exp(-|x - point|^2 / 2s^2) in the given part, in blocks that stay
// in the cache.
template <typename Scalar>
Vec4d sum_nodes(const NodeList<Scalar>& nodes, std::size_t begin, std::size_t end, const Vec3d& point,
                const TruthLayer& layer, Part part, bool gray) {
  using Array = Eigen::Array<Scalar, Eigen::Dynamic, 1>;
  using Block = Eigen::Map<const Array>;
  constexpr Eigen::Index kBlock = 256;
  // Nothing that counts lies this far out (exp(-60) = 9e-27), and denormal numbers are slow.
  constexpr auto kSmallestExponent = Scalar(-60);
  Eigen::Array<Scalar, kBlock, 1> kernel;
  Eigen::Array<Scalar, kBlock, 1> exponent;
  const auto cut = static_cast<Scalar>(-0.5 * std::pow(layer.r_max_mm / layer.std_dev_mm, 2));
  const auto px = static_cast<Scalar>(point.x());
  const auto py = static_cast<Scalar>(point.y());
  const auto pz = static_cast<Scalar>(point.z());
  const auto factor = static_cast<Scalar>(-0.5 / (layer.std_dev_mm * layer.std_dev_mm));
  Vec4d sum = Vec4d::Zero();
  for (std::size_t first = begin; first < end; first += kBlock) {
    const auto n = static_cast<Eigen::Index>(std::min<std::size_t>(kBlock, end - first));
    const Block x(nodes.x.data() + first, n);
    const Block y(nodes.y.data() + first, n);
    const Block z(nodes.z.data() + first, n);
    exponent.head(n) = ((x - px).square() + (y - py).square() + (z - pz).square()) * factor;
    kernel.head(n) = exponent.head(n).max(kSmallestExponent).exp();
    if (part == Part::inner) kernel.head(n) *= (exponent.head(n) > cut).template cast<Scalar>();
    if (part == Part::outer) kernel.head(n) *= (exponent.head(n) <= cut).template cast<Scalar>();
    for (std::size_t c = gray ? 2 : 0; c < 4; ++c) {
      const Block weight(nodes.weight[c].data() + first, n);
      sum[static_cast<Eigen::Index>(c)] += static_cast<double>((kernel.head(n) * weight).sum());
    }
  }
  if (gray) sum[0] = sum[1] = sum[2];
  return sum / (2.0 * kPi * layer.std_dev_mm * layer.std_dev_mm);
}

// One part of one layer: all about it that does not depend on the cluster.
template <typename Scalar>
struct LayerPlan {
  TruthLayer layer;
  Part part;
  double reach_mm;           // search radius
  double cluster_mm;         // radius of the largest clusters
  std::vector<Split> split;  // per triangle
  // Per triangle, and one more: nodes that are kept, in world coordinates. Empty until keep_nodes.
  std::vector<std::size_t> node_begin;
  NodeList<Scalar> nodes;
};

template <typename Scalar>
LayerPlan<Scalar> plan_layer(const std::vector<TriangleBounds>& bounds, const RuleChooser& chooser,
                             const Eigen::AlignedBox3d& points_box, const TruthLayer& layer, Part part,
                             double reach_mm, std::size_t max_nodes) {
  LayerPlan<Scalar> plan{layer, part, reach_mm, 0.0, {}, {}, {}};
  plan.split.reserve(bounds.size());
  std::vector<double> radii_mm;
  for (const TriangleBounds& bound : bounds) {
    if (points_box.exteriorDistance(bound.centroid_mm) > reach_mm + bound.radius_mm) {
      plan.split.emplace_back();  // no point meets it
      continue;
    }
    const Split split = chooser.choose(bound.radius_mm / layer.std_dev_mm);
    plan.split.push_back(split.node_count() > max_nodes ? Split{} : split);
    radii_mm.push_back(bound.radius_mm);
  }
  if (!radii_mm.empty()) {
    const auto middle = radii_mm.begin() + static_cast<std::ptrdiff_t>(radii_mm.size() / 2);
    std::nth_element(radii_mm.begin(), middle, radii_mm.end());
    plan.cluster_mm = std::max(kClusterRadius * reach_mm, kClusterTriangles * *middle);
  }
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

  // `sign` times the sums is what is added. `nodes_elsewhere`: the nodes' sums are computed on a grid, only
  // closed forms are left.
  ClusterWorker(const Surface& surface, const std::vector<TriangleBounds>& bounds, const TriangleTree& tree,
                std::span<const SurfacePoint> points, bool gray, double sign, bool nodes_elsewhere)
      : surface_(surface),
        bounds_(bounds),
        tree_(tree),
        points_(points),
        gray_(gray),
        sign_(sign),
        nodes_elsewhere_(nodes_elsewhere) {}

  // Splits `ids` (reordering it) until each cluster is small against the search radius, and adds its sums.
  void process(std::span<std::uint32_t> ids, const Plan& plan, std::vector<Vec4d>& out) {
    Eigen::AlignedBox3d box;
    for (const std::uint32_t id : ids) box.extend(points_[id].position_mm);
    const double radius_mm = 0.5 * box.diagonal().norm();
    if (radius_mm > plan.cluster_mm && ids.size() > 1) {
      const std::size_t half = split_at_median(points_, box, ids);
      process(ids.first(half), plan, out);
      process(ids.subspan(half), plan, out);
      return;
    }
    gather(box.center(), radius_mm, points_[ids.front()].component, plan);
    if (nodes_.size() == 0 && closed_.empty()) return;
    for (const std::uint32_t id : ids) out[id] += sign_ * evaluate(points_[id].position_mm, plan);
  }

 private:
  // A triangle that the cut-off sphere crosses for some point of the cluster, and its nodes.
  struct Range {
    std::uint32_t triangle;
    std::size_t begin;
    std::size_t end;
  };

  void gather(const Vec3d& center, double cluster_radius, int component, const Plan& plan) {
    center_ = center;
    nodes_.clear();
    closed_.clear();
    crossing_.clear();
    const double r_max_mm = plan.layer.r_max_mm;
    tree_.find(center, plan.reach_mm + cluster_radius, component, found_);
    for (const std::uint32_t t : found_) {
      const double distance = (bounds_[t].centroid_mm - center).norm();
      const double slack = bounds_[t].radius_mm + cluster_radius;
      if (distance - slack > plan.reach_mm) continue;
      if (plan.part == Part::outer && distance + slack < r_max_mm) continue;
      if (plan.split[t].rule == nullptr) {
        closed_.push_back(t);
      } else if (!nodes_elsewhere_) {
        const std::size_t begin = nodes_.size();
        append_nodes(t, plan, cluster_radius, nodes_);
        if (plan.part != Part::whole && distance - slack < r_max_mm && distance + slack > r_max_mm)
          crossing_.push_back({t, begin, nodes_.size()});
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
    const Vec3d local = point - center_;
    Vec4d sum = sum_nodes(nodes_, 0, nodes_.size(), local, plan.layer, plan.part, gray_);
    for (const std::uint32_t t : closed_) {
      if ((bounds_[t].centroid_mm - point).norm() - bounds_[t].radius_mm <= plan.reach_mm)
        sum += closed_form(t, point, plan);
    }
    // Nodes on the wrong side of r_max have been left out one by one; a triangle that the sphere cuts for
    // this point takes the closed form in place of its nodes.
    for (const Range& range : crossing_) {
      if (!is_cut(range.triangle, point, plan.layer.r_max_mm)) continue;
      sum += closed_form(range.triangle, point, plan) -
             sum_nodes(nodes_, range.begin, range.end, local, plan.layer, plan.part, gray_);
    }
    return sum;
  }

  bool is_cut(std::uint32_t t, const Vec3d& point, double r_max_mm) const {
    const double distance2 = (bounds_[t].centroid_mm - point).squaredNorm();
    const double nearest = r_max_mm - bounds_[t].radius_mm;
    const double farthest = r_max_mm + bounds_[t].radius_mm;
    if (distance2 >= farthest * farthest || (nearest > 0.0 && distance2 <= nearest * nearest)) return false;
    double farthest2 = 0.0;
    for (const Vec3d& corner : surface_.triangles[t].corners_mm)
      farthest2 = std::max(farthest2, (corner - point).squaredNorm());
    return farthest2 > r_max_mm * r_max_mm;
  }

  Vec4d closed_form(std::uint32_t t, const Vec3d& point, const Plan& plan) const {
    const SurfaceTriangle& triangle = surface_.triangles[t];
    TruthLayer layer = plan.layer;
    if (plan.part == Part::outer)
      return convolve_outer_part_as<Scalar>(triangle, bounds_[t].frame, point, layer);
    if (plan.part == Part::whole) layer.r_max_mm = std::numeric_limits<double>::infinity();
    return convolve_inner_part_as<Scalar>(triangle, bounds_[t].frame, point, layer);
  }

  const Surface& surface_;
  const std::vector<TriangleBounds>& bounds_;
  const TriangleTree& tree_;
  std::span<const SurfacePoint> points_;
  bool gray_;
  double sign_;
  bool nodes_elsewhere_;
  Vec3d center_ = Vec3d::Zero();
  NodeList<Scalar> nodes_;
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

using Tasks = std::vector<std::span<std::uint32_t>>;

// What a sum over nodes costs, in evaluations of a kernel at one node: directly, and by way of the grid. The
// figures were measured on one machine; they decide about speed alone.
constexpr double kVisitCost = 80.0;    // spreading a node or gathering a point
constexpr double kGroupCost = 2000.0;  // reading or writing the lattice points around one cell
constexpr double kClosedCost = 250.0;  // a triangle's closed form

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

// What the layers of one call share.
struct Shared {
  const Surface& surface;
  const TriangleTree& tree;
  const std::vector<TriangleBounds>& bounds;
  Eigen::AlignedBox3d points_box;
  double tolerance;
  bool gray;
};

// The convolution of one component's points.
template <typename Scalar>
class ComponentConvolution {
 public:
  using Plan = LayerPlan<Scalar>;

  ComponentConvolution(const Shared& shared, std::span<const SurfacePoint> points, const Tasks& tasks)
      : shared_(shared), points_(points), tasks_(tasks) {
    for (const auto& task : tasks) point_count_ += static_cast<double>(task.size());
  }

  double point_count() const { return point_count_; }

  // The cost of a point's sums over nodes and of its closed forms.
  double direct_cost_per_point(const Plan& plan) const {
    return mean_cost(plan, [](const Split& split) {
      return split.rule == nullptr ? kClosedCost : static_cast<double>(split.node_count());
    });
  }

  // The cost with the nodes' sums by way of the grid, per point.
  double grid_cost_per_point(const Plan& plan) const {
    const GaussLattice lattice = lattice_of(plan);
    const double cell_mm = kGaussBlock * lattice.step_mm;
    double nodes = 0.0;
    double cells = 0.0;
    for (const std::uint32_t t : triangles_near(shared_.tree, points_, tasks_, plan.reach_mm)) {
      nodes += static_cast<double>(plan.split[t].node_count());
      cells += 2.0 * shared_.surface.triangles[t].area_mm2() / (cell_mm * cell_mm);
    }
    const double visits = kVisitCost * (nodes + point_count_);
    const double groups = kGroupCost * (std::min(nodes, cells) + std::min(point_count_, cells));
    const double closed =
        mean_cost(plan, [](const Split& split) { return split.rule == nullptr ? kClosedCost : 0.0; });
    return (visits + groups) / point_count_ + closed;
  }

  void add_directly(Plan& plan, double sign, std::vector<Vec4d>& out) const {
    if (plan.node_begin.empty()) keep_nodes(shared_.surface, plan);
    add_clusters(plan, sign, false, out);
  }

  void add_on_grid(const Plan& plan, std::vector<Vec4d>& out) const {
    std::vector<std::uint32_t> ids;
    std::vector<Vec3d> positions;
    for (const auto& task : tasks_) ids.insert(ids.end(), task.begin(), task.end());
    for (const std::uint32_t id : ids) positions.push_back(points_[id].position_mm);
    const std::vector<std::uint32_t> near = triangles_near(shared_.tree, points_, tasks_, plan.reach_mm);
    std::vector<Vec4d> sums(ids.size(), Vec4d::Zero());
    add_gauss_sums<Scalar>(lattice_of(plan), plan.layer.std_dev_mm,
                           grid_sources(shared_.surface, plan.split, near), positions, shared_.gray, sums);
    for (std::size_t i = 0; i < ids.size(); ++i) out[ids[i]] += sums[i];
    const bool some_closed =
        std::any_of(near.begin(), near.end(), [&](std::uint32_t t) { return plan.split[t].rule == nullptr; });
    if (some_closed) add_clusters(plan, 1.0, true, out);
  }

 private:
  // The sum of `cost_of(split)` over the triangles that a point's sum meets, from a sample of the tasks.
  template <typename CostOf>
  double mean_cost(const Plan& plan, const CostOf& cost_of) const {
    constexpr std::size_t kSample = 16;
    const std::size_t stride = std::max<std::size_t>(1, tasks_.size() / kSample);
    double cost = 0.0;
    double sampled = 0.0;
    std::vector<std::uint32_t> near;
    for (std::size_t t = 0; t < tasks_.size(); t += stride, ++sampled) {
      const SurfacePoint& point = points_[tasks_[t].front()];
      shared_.tree.find(point.position_mm, plan.reach_mm, point.component, near);
      for (const std::uint32_t id : near) {
        const TriangleBounds& bound = shared_.bounds[id];
        const double farthest = (bound.centroid_mm - point.position_mm).norm() + bound.radius_mm;
        if (plan.part == Part::outer && farthest < plan.layer.r_max_mm) continue;
        cost += cost_of(plan.split[id]);
      }
    }
    return cost / sampled;
  }

  GaussLattice lattice_of(const Plan& plan) const {
    return {plan.layer.std_dev_mm, kGridShare * shared_.tolerance};
  }

  void add_clusters(const Plan& plan, double sign, bool nodes_elsewhere, std::vector<Vec4d>& out) const {
    parallel_for(tasks_.size(), [&](std::size_t t) {
      ClusterWorker<Scalar> worker(shared_.surface, shared_.bounds, shared_.tree, points_, shared_.gray, sign,
                                   nodes_elsewhere);
      worker.process(tasks_[t], plan, out);
    });
  }

  const Shared& shared_;
  std::span<const SurfacePoint> points_;
  const Tasks& tasks_;
  double point_count_ = 0.0;
};

// The plans of one layer, each made when it is first needed.
template <typename Scalar>
class LayerPlans {
 public:
  using Plan = LayerPlan<Scalar>;

  LayerPlans(const Shared& shared, const TruthLayer& layer)
      : shared_(shared),
        layer_(layer),
        tail_mm_(std::sqrt(-2.0 * std::log(kTailShare * shared.tolerance)) * layer.std_dev_mm) {}

  bool is_cut() const { return layer_.r_max_mm < tail_mm_; }

  // All at once, point by point.
  Plan& direct() {
    return is_cut() ? made(direct_, kQuadratureShare, 0.0, Part::inner, layer_.r_max_mm, kMaxNodes)
                    : made(direct_, kQuadratureShare, 0.0, Part::whole, tail_mm_, kMaxNodes);
  }
  // By way of the grid, where a node costs the same for any number of points: nothing is cut off, and ...
  Plan& gridded() {
    // ... a part of the budget is left for what is then taken off.
    const double share = is_cut() ? kQuadratureShare - kOuterShare : kQuadratureShare;
    return made(gridded_, share, 0.0, Part::whole, tail_mm_, std::numeric_limits<std::size_t>::max());
  }
  // What is taken off a gridded layer.
  Plan& outer() {
    return made(outer_, kOuterShare, layer_.r_max_mm / layer_.std_dev_mm, Part::outer, tail_mm_, kMaxNodes);
  }

 private:
  Plan& made(std::optional<Plan>& plan, double share, double beyond_std_devs, Part part, double reach_mm,
             std::size_t max_nodes) {
    if (!plan) {
      const RuleChooser chooser(share * shared_.tolerance, beyond_std_devs);
      plan =
          plan_layer<Scalar>(shared_.bounds, chooser, shared_.points_box, layer_, part, reach_mm, max_nodes);
    }
    return *plan;
  }

  const Shared& shared_;
  TruthLayer layer_;
  double tail_mm_;
  std::optional<Plan> direct_;
  std::optional<Plan> gridded_;
  std::optional<Plan> outer_;
};

// Adds one layer's sums at one component's points, the cheapest way.
template <typename Scalar>
void add_layer(const ComponentConvolution<Scalar>& component, LayerPlans<Scalar>& plans,
               std::vector<Vec4d>& out) {
  const double direct_cost = component.direct_cost_per_point(plans.direct());
  // Gathering alone costs a visit: for a few nodes, nothing more need be asked.
  if (direct_cost < kVisitCost) return component.add_directly(plans.direct(), 1.0, out);
  double grid_cost = component.grid_cost_per_point(plans.gridded());
  if (plans.is_cut()) grid_cost += component.direct_cost_per_point(plans.outer());
  if (direct_cost < grid_cost) return component.add_directly(plans.direct(), 1.0, out);
  component.add_on_grid(plans.gridded(), out);
  if (plans.is_cut()) component.add_directly(plans.outer(), -1.0, out);
}

template <typename Scalar>
void convolve_with(const Surface& surface, const TriangleTree& tree,
                   const std::vector<TriangleBounds>& bounds, double tolerance,
                   std::span<const SurfacePoint> points, std::span<const TruthLayer> layers,
                   const std::function<void(std::size_t)>& advance, TruthValues& values) {
  Eigen::AlignedBox3d points_box;
  for (const SurfacePoint& point : points) points_box.extend(point.position_mm);
  const Shared shared{surface, tree, bounds, points_box, tolerance, is_gray(surface)};

  std::map<int, std::vector<std::uint32_t>> by_component;
  for (std::uint32_t i = 0; i < points.size(); ++i) by_component[points[i].component].push_back(i);
  std::map<int, Tasks> tasks;
  for (auto& [component, ids] : by_component) cut_into_tasks(points, ids, tasks[component]);

  for (std::size_t l = 0; l < layers.size(); ++l) {
    LayerPlans<Scalar> plans(shared, layers[l]);
    for (const auto& [component, some] : tasks) {
      const ComponentConvolution<Scalar> convolution(shared, points, some);
      add_layer(convolution, plans, values[l]);
      if (advance) advance(static_cast<std::size_t>(convolution.point_count()));
    }
  }
}

}  // namespace

FastEngine::FastEngine(const Surface& surface, double tolerance)
    : surface_(surface), tree_(surface), tolerance_(tolerance) {
  assert(tolerance > 0.0);
  bounds_.reserve(surface.triangles.size());
  for (const SurfaceTriangle& t : surface.triangles)
    bounds_.push_back({t.centroid_mm(), centroid_radius_mm(t), TriangleFrame(t)});
}

double FastEngine::tail_bound() const { return 2.0 * (kTailShare + kGridShare) * tolerance_; }

TruthValues FastEngine::convolve(std::span<const SurfacePoint> points, std::span<const TruthLayer> layers,
                                 const std::function<void(std::size_t)>& advance) const {
  TruthValues values(layers.size(), std::vector<Vec4d>(points.size(), Vec4d::Zero()));
  if (tolerance_ >= 1e-5) {
    convolve_with<float>(surface_, tree_, bounds_, tolerance_, points, layers, advance, values);
  } else {
    convolve_with<double>(surface_, tree_, bounds_, tolerance_, points, layers, advance, values);
  }
  return values;
}

}  // namespace truescatter
