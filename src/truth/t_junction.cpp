#include "truth/t_junction.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace truescatter {

std::optional<TJunction> find_t_junction(
    std::span<const Vec3d> positions_mm, std::span<const OpenEdge> edges,
    const std::function<bool(std::size_t at_vertex, std::size_t at_edge)>& matters) {
  const auto at = [&](int v) -> const Vec3d& { return positions_mm[static_cast<std::size_t>(v)]; };
  std::vector<std::pair<int, std::size_t>> ends;  // a vertex and its triangle
  for (const OpenEdge& edge : edges)
    ends.insert(ends.end(), {{edge.from, edge.triangle}, {edge.to, edge.triangle}});
  std::sort(ends.begin(), ends.end(),
            [&](const auto& a, const auto& b) { return at(a.first).x() < at(b.first).x(); });
  for (const OpenEdge& open : edges) {
    const Vec3d& a = at(open.from);
    const Vec3d edge = at(open.to) - a;
    const double length = edge.norm();
    const double slack = 1e-9 * length;
    const double low = std::min(a.x(), a.x() + edge.x()) - slack;
    const double high = std::max(a.x(), a.x() + edge.x()) + slack;
    auto end = std::lower_bound(ends.begin(), ends.end(), low,
                                [&](const auto& candidate, double x) { return at(candidate.first).x() < x; });
    for (; end != ends.end() && at(end->first).x() <= high; ++end) {
      const auto [vertex, triangle] = *end;
      if (vertex == open.from || vertex == open.to || !matters(triangle, open.triangle)) continue;
      const Vec3d to = at(vertex) - a;
      const double along = to.dot(edge) / length;
      if (along <= slack || along >= length - slack) continue;
      if ((to - along * edge / length).norm() > slack) continue;
      return TJunction{vertex, triangle, open.triangle};
    }
  }
  return std::nullopt;
}

}  // namespace truescatter
