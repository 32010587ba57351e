#include "truth/fast.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "truth/cluster_sums.h"
#include "truth/gauss_grid.h"
#include "truth/lanes.h"

namespace truescatter {
namespace {

constexpr double kTailShare = 0.1;        // of the tolerance
constexpr double kQuadratureShare = 0.6;  // of the tolerance
constexpr double kOuterShare = 0.2;       // of the tolerance, out of the quadrature's
constexpr double kGridShare = 0.1;        // of the tolerance
constexpr std::size_t kTaskPoints = 1024;

// What the grid costs, in the units of kClosedCost.
constexpr double kVisitCost = 900.0;    // spreading a node or gathering a point
constexpr double kGroupCost = 20000.0;  // reading or writing the lattice points around one cell

using Tasks = std::vector<std::span<std::uint32_t>>;

// Points of one component, cut into boxes of at most kTaskPoints: the units of parallel work. The cut depends
// on the points alone.
Tasks cut_into_tasks(std::span<const SurfacePoint> points, std::span<std::uint32_t> ids) {
  if (ids.size() <= kTaskPoints) return ids.empty() ? Tasks{} : Tasks{ids};
  const std::size_t half = split_points(points, ids);
  std::array<Tasks, 2> parts;
  parallel_for(2, [&](std::size_t i) {
    parts[i] = cut_into_tasks(points, i == 0 ? ids.first(half) : ids.subspan(half));
  });
  parts[0].insert(parts[0].end(), parts[1].begin(), parts[1].end());
  return std::move(parts[0]);
}

// Under white light the three channels are one: a scene needs no more.
bool is_gray(const Surface& surface) {
  return std::all_of(surface.triangles.begin(), surface.triangles.end(), [](const SurfaceTriangle& triangle) {
    return std::all_of(triangle.irradiance.begin(), triangle.irradiance.end(),
                       [](const Vec3d& v) { return v.x() == v.y() && v.y() == v.z(); });
  });
}

// The radius of kLanes neighbouring points, in the median over the tasks.
double median_leaf_mm(std::span<const SurfacePoint> points, const std::map<int, Tasks>& tasks) {
  std::vector<double> radii_mm;
  for (const auto& [component, some] : tasks) {
    for (const auto& task : some) {
      Eigen::AlignedBox3d box;
      for (const std::uint32_t id : task) box.extend(points[id].position_mm);
      const double leaves = std::max(1.0, static_cast<double>(task.size()) / kLanes);
      radii_mm.push_back(0.5 * box.diagonal().norm() / std::sqrt(leaves));
    }
  }
  if (radii_mm.empty()) return 0.0;
  const auto middle = radii_mm.begin() + static_cast<std::ptrdiff_t>(radii_mm.size() / 2);
  std::nth_element(radii_mm.begin(), middle, radii_mm.end());
  return *middle;
}

// Triangles within reach of any of the tasks' points, ascending.
std::vector<std::uint32_t> triangles_near(const TriangleTree& tree, std::span<const SurfacePoint> points,
                                          const Tasks& tasks, double reach_mm, std::size_t triangle_count) {
  std::vector<std::uint8_t> is_near(triangle_count, 0);
  parallel_for(tasks.size(), [&](std::size_t t) {
    Eigen::AlignedBox3d box;
    for (const std::uint32_t id : tasks[t]) box.extend(points[id].position_mm);
    tree.for_each(box.center(), reach_mm + 0.5 * box.diagonal().norm(), points[tasks[t].front()].component,
                  [&](std::uint32_t triangle) {
                    std::atomic_ref(is_near[triangle]).store(1, std::memory_order_relaxed);
                  });
  });
  std::vector<std::uint32_t> all;
  for (std::uint32_t t = 0; t < triangle_count; ++t) {
    if (is_near[t] != 0) all.push_back(t);
  }
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
struct Shared : SummedSurface {
  Eigen::AlignedBox3d points_box;
  double leaf_mm;
  double tolerance;
};

// The convolution of one component's points.
template <typename Scalar>
class ComponentConvolution {
 public:
  ComponentConvolution(const Shared& shared, std::span<const SurfacePoint> points, const Tasks& tasks)
      : shared_(shared), points_(points), tasks_(tasks), component_(points[tasks.front().front()].component) {
    for (const auto& task : tasks) point_count_ += static_cast<double>(task.size());
  }

  double point_count() const { return point_count_; }

  // The cost of a point's sums over nodes and of its closed forms.
  double direct_cost_per_point(const LayerPlan& plan) const {
    return mean_cost(plan, [&](std::uint32_t t) { return plan.cost(t, shared_.bounds[t].radius_mm); });
  }

  // The cost with the nodes' sums by way of the grid, per point.
  double grid_cost_per_point(const LayerPlan& plan) const {
    const GaussLattice lattice = lattice_of(plan);
    const double cell_mm = kGaussBlock * lattice.step_mm;
    double nodes = 0.0;
    double cells = 0.0;
    for (std::size_t t = 0; t < plan.split.size(); ++t) {
      const std::size_t count = plan.split[t].node_count();
      if (count == 0 || shared_.surface.triangles[t].component != component_) continue;
      nodes += static_cast<double>(count);
      cells += 2.0 * shared_.surface.triangles[t].area_mm2() / (cell_mm * cell_mm);
    }
    const double visits = kVisitCost * (nodes + point_count_);
    const double groups = kGroupCost * (std::min(nodes, cells) + std::min(point_count_, cells));
    const double closed =
        mean_cost(plan, [&](std::uint32_t t) { return plan.is_closed(t) ? kClosedCost : 0.0; });
    return (visits + groups) / point_count_ + closed;
  }

  void add_directly(const LayerPlan& plan, double sign, std::vector<Vec4d>& out) const {
    add_clusters(plan, sign, false, out);
  }

  void add_on_grid(const LayerPlan& plan, std::vector<Vec4d>& out) const {
    const std::vector<std::uint32_t> near =
        triangles_near(shared_.tree, points_, tasks_, plan.reach_mm, plan.split.size());
    std::vector<std::uint32_t> ids;
    std::vector<Vec3d> positions;
    for (const auto& task : tasks_) ids.insert(ids.end(), task.begin(), task.end());
    for (const std::uint32_t id : ids) positions.push_back(points_[id].position_mm);
    std::vector<Vec4d> sums(ids.size(), Vec4d::Zero());
    add_gauss_sums<Scalar>(lattice_of(plan), plan.layer.std_dev_mm,
                           grid_sources(shared_.surface, plan.split, near), positions, shared_.gray, sums);
    for (std::size_t i = 0; i < ids.size(); ++i) out[ids[i]] += sums[i];
    const bool some_closed =
        std::any_of(near.begin(), near.end(), [&](std::uint32_t t) { return plan.is_closed(t); });
    if (some_closed) add_clusters(plan, 1.0, true, out);
  }

 private:
  // The sum of `cost_of(triangle)` over the triangles that a point's sum meets, from a sample of the tasks.
  template <typename CostOf>
  double mean_cost(const LayerPlan& plan, const CostOf& cost_of) const {
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
        cost += cost_of(id);
      }
    }
    return cost / sampled;
  }

  GaussLattice lattice_of(const LayerPlan& plan) const {
    return {plan.layer.std_dev_mm, kGridShare * shared_.tolerance};
  }

  void add_clusters(const LayerPlan& plan, double sign, bool nodes_elsewhere, std::vector<Vec4d>& out) const {
    parallel_for(tasks_.size(), [&](std::size_t t) {
      add_cluster_sums<Scalar>(shared_, points_, plan, sign, nodes_elsewhere, tasks_[t], out);
    });
  }

  const Shared& shared_;
  std::span<const SurfacePoint> points_;
  const Tasks& tasks_;
  int component_;
  double point_count_ = 0.0;
};

// The plans of one layer, each made when it is first needed.
class LayerPlans {
 public:
  LayerPlans(const Shared& shared, const TruthLayer& layer)
      : shared_(shared),
        layer_(layer),
        tail_mm_(std::sqrt(-2.0 * std::log(kTailShare * shared.tolerance)) * layer.std_dev_mm) {}

  bool is_cut() const { return layer_.r_max_mm < tail_mm_; }

  // All at once, point by point.
  const LayerPlan& direct() {
    return is_cut() ? made(direct_, Part::inner, layer_.r_max_mm, kQuadratureShare, true)
                    : made(direct_, Part::whole, tail_mm_, kQuadratureShare, true);
  }
  // By way of the grid, where a node costs the same for any number of points: nothing is cut off, and ...
  const LayerPlan& gridded() {
    // ... a part of the budget is left for what is then taken off.
    const double share = is_cut() ? kQuadratureShare - kOuterShare : kQuadratureShare;
    return made(gridded_, Part::whole, tail_mm_, share, false);
  }
  // What is taken off a gridded layer.
  const LayerPlan& outer() { return made(outer_, Part::outer, tail_mm_, kOuterShare, true); }

 private:
  const LayerPlan& made(std::optional<LayerPlan>& plan, Part part, double reach_mm, double share,
                        bool closed_allowed) {
    if (!plan) {
      // Scattered points stand alone in their leaves, at kLanes times the cost.
      const double leaf_mm =
          std::min(shared_.leaf_mm, (std::sqrt(static_cast<double>(kLanes)) - 1.0) * reach_mm);
      plan = plan_layer(shared_.bounds, shared_.points_box, leaf_mm,
                        {layer_, part, reach_mm, share * shared_.tolerance, closed_allowed});
    }
    return *plan;
  }

  const Shared& shared_;
  TruthLayer layer_;
  double tail_mm_;
  std::optional<LayerPlan> direct_;
  std::optional<LayerPlan> gridded_;
  std::optional<LayerPlan> outer_;
};

// Adds one layer's sums at one component's points, the cheapest way.
template <typename Scalar>
void add_layer(const ComponentConvolution<Scalar>& component, LayerPlans& plans, std::vector<Vec4d>& out) {
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

  std::map<int, std::vector<std::uint32_t>> by_component;
  for (std::uint32_t i = 0; i < points.size(); ++i) by_component[points[i].component].push_back(i);
  std::map<int, Tasks> tasks;
  for (auto& [component, ids] : by_component) tasks[component] = cut_into_tasks(points, ids);
  const Shared shared{
      {surface, tree, bounds, is_gray(surface)}, points_box, median_leaf_mm(points, tasks), tolerance};

  for (std::size_t l = 0; l < layers.size(); ++l) {
    LayerPlans plans(shared, layers[l]);
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
