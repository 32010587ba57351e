#include "scene/head_atlas.h"

#include <Eigen/Sparse>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "scene/head_shape.h"

namespace truescatter {
namespace {

// A place in the atlas. Charts fill their rectangles, which lie at least 10/1024 apart.
struct AtlasChart {
  std::string_view name;
  HeadPart part;
  int side;  // of x: -1, 1; 0 for what lies across the middle
  Vec2d lower;
  Vec2d upper;
};

const std::array<AtlasChart, 9> kCharts = {{
    {"face", HeadPart::face, 0, {0.010, 0.365}, {0.565, 0.990}},
    {"scalp", HeadPart::scalp, 0, {0.576, 0.500}, {0.990, 0.990}},
    {"neck front", HeadPart::neck_front, 0, {0.010, 0.180}, {0.565, 0.354}},
    {"neck back", HeadPart::neck_back, 0, {0.010, 0.010}, {0.565, 0.169}},
    {"base", HeadPart::base, 0, {0.789, 0.010}, {0.990, 0.239}},
    {"left ear, front", HeadPart::ear_front, 1, {0.576, 0.250}, {0.777, 0.489}},
    {"right ear, front", HeadPart::ear_front, -1, {0.789, 0.250}, {0.990, 0.489}},
    {"left ear, back", HeadPart::ear_back, 1, {0.576, 0.010}, {0.671, 0.239}},
    {"right ear, back", HeadPart::ear_back, -1, {0.683, 0.010}, {0.777, 0.239}},
}};

// --- Which triangle belongs to which chart ---

using Edge = std::pair<int, int>;

// The three triangles across each triangle's edges; edge c runs from corner c to the next.
std::vector<std::array<int, 3>> neighbours(const Mesh& mesh) {
  std::map<Edge, int> owner;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c)
      owner[{mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3]}] = int(t);
  std::vector<std::array<int, 3>> result(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c)
      result[t][c] = owner.at({mesh.triangles[t][(c + 1) % 3], mesh.triangles[t][c]});
  return result;
}

class Segmentation {
 public:
  explicit Segmentation(const Mesh& mesh) : mesh_(mesh), neighbours_(neighbours(mesh)) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) charts.push_back(first_guess(t));
    for (int round = 0; round < 6; ++round) {
      cut_teeth();
      cut_shallow_teeth();
    }
    // Each repair may undo another's work a little, so they take turns until nothing moves.
    for (int round = 0; round < 20; ++round) {
      const bool moved = drop_islands();
      if (!(cut_teeth() || open_pinches() || moved)) break;
    }
  }

  std::vector<int> charts;  // per triangle

 private:
  int first_guess(std::size_t t) const {
    const Vec3d center = (mesh_.corner(t, 0) + mesh_.corner(t, 1) + mesh_.corner(t, 2)) / 3.0;
    const HeadPart part = head_part(center);
    for (std::size_t i = 0; i < kCharts.size(); ++i)
      if (kCharts[i].part == part && kCharts[i].side * center.x() >= 0.0) return int(i);
    return 0;
  }

  // The most frequent chart across the edges of some triangles that is not their own; -1 if there is none.
  int other_chart_around(const std::vector<int>& triangles) const {
    std::array<int, kCharts.size()> votes{};
    const int own = charts[std::size_t(triangles.front())];
    for (const int t : triangles)
      for (const int n : neighbours_[std::size_t(t)])
        if (charts[std::size_t(n)] != own) ++votes[std::size_t(charts[std::size_t(n)])];
    const auto best = std::max_element(votes.begin(), votes.end());
    return *best > 0 ? int(best - votes.begin()) : -1;
  }

  void give_away(const std::vector<int>& triangles) {
    const int chart = other_chart_around(triangles);
    if (chart < 0) return;
    for (const int t : triangles) charts[std::size_t(t)] = chart;
  }

  // Leaves every chart one piece: all but its largest go to the charts around them.
  bool drop_islands() {
    std::vector<std::vector<int>> pieces;
    std::vector<char> seen(charts.size(), 0);
    for (std::size_t start = 0; start < charts.size(); ++start) {
      if (seen[start]) continue;
      std::vector<int> piece = {int(start)};
      seen[start] = 1;
      for (std::size_t i = 0; i < piece.size(); ++i)
        for (const int n : neighbours_[std::size_t(piece[i])]) {
          if (seen[std::size_t(n)] || charts[std::size_t(n)] != charts[start]) continue;
          seen[std::size_t(n)] = 1;
          piece.push_back(n);
        }
      pieces.push_back(std::move(piece));
    }
    std::array<std::size_t, kCharts.size()> largest{};
    for (const auto& piece : pieces) {
      std::size_t& size = largest[std::size_t(charts[std::size_t(piece.front())])];
      size = std::max(size, piece.size());
    }
    bool moved = false;
    std::array<bool, kCharts.size()> kept{};
    for (const auto& piece : pieces) {
      const std::size_t chart = std::size_t(charts[std::size_t(piece.front())]);
      if (!kept[chart] && piece.size() == largest[chart]) {
        kept[chart] = true;
        continue;
      }
      give_away(piece);
      moved = true;
    }
    return moved;
  }

  // A triangle with two edges on its chart's border would be flattened to nearly nothing.
  bool cut_teeth() {
    bool moved = false;
    for (std::size_t t = 0; t < charts.size(); ++t) {
      if (foreign_edges(t) < 2) continue;
      give_away({int(t)});
      moved = true;
    }
    return moved;
  }

  // So would one with all three corners there.
  void cut_shallow_teeth() {
    std::vector<char> is_on_border(mesh_.positions_mm.size(), 0);
    for (std::size_t t = 0; t < charts.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c)
        if (charts[std::size_t(neighbours_[t][c])] != charts[t])
          is_on_border[std::size_t(mesh_.triangles[t][c])] =
              is_on_border[std::size_t(mesh_.triangles[t][(c + 1) % 3])] = 1;
    for (std::size_t t = 0; t < charts.size(); ++t) {
      const auto on_border = [&](int v) { return is_on_border[std::size_t(v)] != 0; };
      const auto& corners = mesh_.triangles[t];
      if (foreign_edges(t) == 1 && std::all_of(corners.begin(), corners.end(), on_border))
        give_away({int(t)});
    }
  }

  long foreign_edges(std::size_t t) const {
    const auto is_foreign = [&](int n) { return charts[std::size_t(n)] != charts[t]; };
    return std::count_if(neighbours_[t].begin(), neighbours_[t].end(), is_foreign);
  }

  // A chart that touches itself in a vertex is no disc: the smaller of the two fans goes.
  bool open_pinches() {
    bool moved = false;
    std::vector<std::vector<int>> around(mesh_.positions_mm.size());
    for (std::size_t t = 0; t < charts.size(); ++t)
      for (const int v : mesh_.triangles[t]) around[std::size_t(v)].push_back(int(t));
    for (const auto& ring : around) {
      std::vector<std::vector<int>> fans = fans_of(ring);
      std::sort(fans.begin(), fans.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
      for (std::size_t i = 0; i + 1 < fans.size(); ++i)
        for (std::size_t j = i + 1; j < fans.size(); ++j) {
          if (charts[std::size_t(fans[i].front())] != charts[std::size_t(fans[j].front())]) continue;
          give_away(fans[i]);
          moved = true;
          break;
        }
    }
    return moved;
  }

  // The runs of triangles of one chart around a vertex.
  std::vector<std::vector<int>> fans_of(const std::vector<int>& ring) const {
    std::vector<std::vector<int>> fans;
    std::vector<char> seen(ring.size(), 0);
    for (std::size_t start = 0; start < ring.size(); ++start) {
      if (seen[start]) continue;
      std::vector<int> fan = {ring[start]};
      seen[start] = 1;
      for (std::size_t i = 0; i < fan.size(); ++i)
        for (std::size_t k = 0; k < ring.size(); ++k) {
          const auto& across = neighbours_[std::size_t(fan[i])];
          if (seen[k] || charts[std::size_t(ring[k])] != charts[std::size_t(ring[start])]) continue;
          if (std::find(across.begin(), across.end(), ring[k]) == across.end()) continue;
          seen[k] = 1;
          fan.push_back(ring[k]);
        }
      fans.push_back(std::move(fan));
    }
    return fans;
  }

  const Mesh& mesh_;
  std::vector<std::array<int, 3>> neighbours_;
};

// Where three charts meet, one of them may be left with a tooth that no reassignment cures: a convex border
// squashes it. Turning the tooth's inner edge gives its tip an edge inwards, which holds it open.
class ToothFlips {
 public:
  ToothFlips(Mesh& mesh, const std::vector<int>& charts)
      : mesh_(mesh), charts_(charts), neighbours_(neighbours(mesh)), is_changed_(charts.size(), 0) {
    for (std::size_t t = 0; t < charts.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c)
        if (is_foreign(t, (c + 1) % 3) && is_foreign(t, (c + 2) % 3) && !is_foreign(t, c)) flip(t, c);
  }

 private:
  bool is_foreign(std::size_t t, std::size_t edge) const {
    return charts_[std::size_t(neighbours_[t][edge])] != charts_[t];
  }

  // Turns edge c of triangle t = tip-a-b, which it shares with inner = b-a-w, into tip-w.
  void flip(std::size_t t, std::size_t c) {
    const std::size_t inner = std::size_t(neighbours_[t][c]);
    if (is_changed_[t] || is_changed_[inner]) return;
    const auto& corners = mesh_.triangles[inner];
    const std::size_t b_at = std::size_t(
        std::find(corners.begin(), corners.end(), mesh_.triangles[t][(c + 1) % 3]) - corners.begin());
    if (is_foreign(inner, (b_at + 1) % 3) || is_foreign(inner, (b_at + 2) % 3)) return;
    const std::size_t tip_at = (c + 2) % 3, w_at = (b_at + 2) % 3;
    // tip-a-b loses b to w, b-a-w loses a to the tip.
    mesh_.triangles[t][(c + 1) % 3] = mesh_.triangles[inner][w_at];
    mesh_.corner_normals[t][(c + 1) % 3] = mesh_.corner_normals[inner][w_at];
    mesh_.triangles[inner][(b_at + 1) % 3] = mesh_.triangles[t][tip_at];
    mesh_.corner_normals[inner][(b_at + 1) % 3] = mesh_.corner_normals[t][tip_at];
    is_changed_[t] = is_changed_[inner] = 1;
  }

  Mesh& mesh_;
  const std::vector<int>& charts_;
  std::vector<std::array<int, 3>> neighbours_;
  std::vector<char> is_changed_;
};

// --- Flattening ---

// A chart's triangles with their own vertex numbers.
struct Patch {
  std::vector<int> mesh_triangles;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Vec3d> positions_mm;
  std::vector<int> border;  // counter-clockwise
};

Patch make_patch(const Mesh& mesh, const std::vector<int>& charts, int chart) {
  Patch patch;
  std::map<int, int> local;
  std::map<int, int> next_on_border;
  std::map<Edge, int> edges;
  for (std::size_t t = 0; t < charts.size(); ++t) {
    if (charts[t] != chart) continue;
    std::array<int, 3> triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      const int v = mesh.triangles[t][c];
      const auto [entry, is_new] = local.try_emplace(v, int(patch.positions_mm.size()));
      if (is_new) patch.positions_mm.push_back(mesh.positions_mm[std::size_t(v)]);
      triangle[c] = entry->second;
    }
    patch.mesh_triangles.push_back(int(t));
    patch.triangles.push_back(triangle);
    for (std::size_t c = 0; c < 3; ++c) edges[{triangle[c], triangle[(c + 1) % 3]}] = 1;
  }
  for (const auto& [edge, count] : edges)
    if (!edges.contains({edge.second, edge.first})) next_on_border[edge.first] = edge.second;
  if (!next_on_border.empty()) {
    const int start = next_on_border.begin()->first;
    int v = start;
    do {
      patch.border.push_back(v);
      v = next_on_border.at(v);
    } while (v != start && patch.border.size() <= next_on_border.size());
  }
  const std::size_t undirected = (edges.size() + next_on_border.size()) / 2;
  const bool is_disc = patch.border.size() == next_on_border.size() && !patch.border.empty() &&
                       patch.positions_mm.size() + patch.triangles.size() == undirected + 1;
  if (!is_disc)
    throw_run_error("the built-in head's chart '{}' is not a disc; try another edge length",
                    kCharts[std::size_t(chart)].name);
  return patch;
}

// Starts the border at its highest point (of several, the foremost), so that charts stand upright; where
// the chart lies across the middle, at the highest point there.
void start_border_at_top(Patch& patch, bool is_across_middle) {
  const auto height = [&](int v) {
    const Vec3d& p = patch.positions_mm[std::size_t(v)];
    return p.y() + 0.1 * p.z() - (is_across_middle ? 10.0 * std::abs(p.x()) : 0.0);
  };
  const auto top = std::max_element(patch.border.begin(), patch.border.end(),
                                    [&](int a, int b) { return height(a) < height(b); });
  std::rotate(patch.border.begin(), top, patch.border.end());
}

// A strictly convex outline, between an ellipse and a rectangle, from its top and counter-clockwise.
Vec2d outline_point(double angle) {
  constexpr double kExponent = 2.8;
  const auto rounded = [](double x) { return std::copysign(std::pow(std::abs(x), 2.0 / kExponent), x); };
  return {-rounded(std::sin(angle)), rounded(std::cos(angle))};
}

// Lays the border onto the outline, each edge in proportion to its length.
std::vector<Vec2d> border_uvs(const Patch& patch, const Vec2d& half_size) {
  constexpr int kSteps = 4096;
  std::vector<double> outline_length = {0.0};
  const auto outline = [&](double s) { return outline_point(2.0 * kPi * s).cwiseProduct(half_size).eval(); };
  for (int i = 0; i < kSteps; ++i)
    outline_length.push_back(outline_length.back() +
                             (outline(double(i + 1) / kSteps) - outline(double(i) / kSteps)).norm());
  const std::size_t count = patch.border.size();
  std::vector<double> border_length = {0.0};
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d& a = patch.positions_mm[std::size_t(patch.border[i])];
    const Vec3d& b = patch.positions_mm[std::size_t(patch.border[(i + 1) % count])];
    border_length.push_back(border_length.back() + (b - a).norm());
  }
  std::vector<Vec2d> uvs;
  for (std::size_t i = 0; i < count; ++i) {
    const double wanted = border_length[i] / border_length.back() * outline_length.back();
    const auto after = std::upper_bound(outline_length.begin(), outline_length.end(), wanted);
    const std::size_t k = std::size_t(after - outline_length.begin()) - 1;
    const double t = (wanted - outline_length[k]) / (outline_length[k + 1] - outline_length[k]);
    uvs.push_back(outline((double(k) + t) / kSteps));
  }
  return uvs;
}

// Tutte's embedding with positive weights: inside a convex border it has no overlap and no flip, whatever
// the weights are. They start as mean values (Floater) and are divided by the stretch around their
// vertices (Yoshizawa, Belyaev, Seidel 2004), which evens the stretch out.
class Flattening {
 public:
  Flattening(const Patch& patch, const Vec2d& half_size)
      : patch_(patch), uvs_(patch.positions_mm.size(), Vec2d::Zero()) {
    row_.assign(patch.positions_mm.size(), 0);
    const std::vector<Vec2d> border = border_uvs(patch, half_size);
    for (std::size_t i = 0; i < border.size(); ++i) {
      uvs_[std::size_t(patch.border[i])] = border[i];
      row_[std::size_t(patch.border[i])] = -1;
    }
    for (int& row : row_)
      if (row == 0) row = rows_++;
    set_mean_value_weights();
  }

  std::vector<Vec2d> run() {
    constexpr int kRounds = 5;
    solve();
    double best = spread();
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<Vec2d> before = uvs_;
      divide_weights_by_stretch();
      solve();
      const double now = spread();
      if (now >= best) {
        uvs_ = before;
        break;
      }
      best = now;
    }
    return uvs_;
  }

 private:
  // The weight of the edge from a triangle's corner c to its next corner, in the row of corner c; the two
  // triangles at an edge each give half of a mean-value weight.
  struct Weight {
    int from;
    int to;
    double value;
  };

  void set_mean_value_weights() {
    for (const auto& t : patch_.triangles)
      for (std::size_t c = 0; c < 3; ++c) {
        const int i = t[c], j = t[(c + 1) % 3], k = t[(c + 2) % 3];
        const Vec3d to_j = position(j) - position(i), to_k = position(k) - position(i);
        const double angle = std::atan2(to_j.cross(to_k).norm(), to_j.dot(to_k));
        const double half_tangent = std::tan(0.5 * angle);
        weights_.push_back({i, j, half_tangent / to_j.norm()});
        weights_.push_back({i, k, half_tangent / to_k.norm()});
      }
  }

  const Vec3d& position(int v) const { return patch_.positions_mm[std::size_t(v)]; }

  void solve() {
    std::vector<Eigen::Triplet<double>> entries;
    std::vector<double> sums(uvs_.size(), 0.0);
    for (const Weight& w : weights_) sums[std::size_t(w.from)] += w.value;
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(rows_, 2);
    for (const Weight& w : weights_) {
      const int row = row_[std::size_t(w.from)], column = row_[std::size_t(w.to)];
      if (row < 0) continue;
      const double value = w.value / sums[std::size_t(w.from)];
      if (column < 0)
        right.row(row) += value * uvs_[std::size_t(w.to)].transpose();
      else
        entries.emplace_back(row, column, -value);
    }
    for (int row = 0; row < rows_; ++row) entries.emplace_back(row, row, 1.0);
    Eigen::SparseMatrix<double, Eigen::RowMajor> matrix(rows_, rows_);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::BiCGSTAB<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::IncompleteLUT<double>> solver;
    solver.preconditioner().setDroptol(1e-4);
    solver.preconditioner().setFillfactor(8);
    solver.setTolerance(1e-12);  // so that thin triangles keep their sign
    solver.compute(matrix);
    Eigen::MatrixX2d guess(rows_, 2);
    for_each_row([&](int row, std::size_t v) { guess.row(row) = uvs_[v].transpose(); });
    const Eigen::MatrixX2d solution = solver.solveWithGuess(right, guess);
    for_each_row([&](int row, std::size_t v) { uvs_[v] = solution.row(row).transpose(); });
  }

  template <typename Body>
  void for_each_row(const Body& body) {
    for (std::size_t v = 0; v < uvs_.size(); ++v)
      if (row_[v] >= 0) body(row_[v], v);
  }

  double area_mm2(const std::array<int, 3>& t) const {
    return 0.5 * (position(t[1]) - position(t[0])).cross(position(t[2]) - position(t[0])).norm();
  }

  // Mean square of the two singular values of the map from UV to the surface (Sander's L2 stretch).
  double squared_stretch(const std::array<int, 3>& t) const {
    Eigen::Matrix2d uv;
    uv << uvs_[std::size_t(t[1])] - uvs_[std::size_t(t[0])],
        uvs_[std::size_t(t[2])] - uvs_[std::size_t(t[0])];
    Eigen::Matrix<double, 3, 2> edges;
    edges << position(t[1]) - position(t[0]), position(t[2]) - position(t[0]);
    return 0.5 * (edges * uv.inverse()).squaredNorm();
  }

  // Overall stretch; the measure that must fall.
  double spread() const {
    double sum = 0.0, area = 0.0;
    for (const auto& t : patch_.triangles) {
      sum += area_mm2(t) * squared_stretch(t);
      area += area_mm2(t);
    }
    return std::sqrt(sum / area);
  }

  void divide_weights_by_stretch() {
    std::vector<double> sums(uvs_.size(), 0.0), areas(uvs_.size(), 0.0);
    for (const auto& t : patch_.triangles)
      for (const int v : t) {
        sums[std::size_t(v)] += area_mm2(t) * squared_stretch(t);
        areas[std::size_t(v)] += area_mm2(t);
      }
    for (Weight& w : weights_) {
      const std::size_t to = std::size_t(w.to);
      w.value /= std::sqrt(sums[to] / areas[to]);
    }
  }

  const Patch& patch_;
  std::vector<Vec2d> uvs_;
  std::vector<int> row_;  // of the linear system; -1 on the border
  int rows_ = 0;
  std::vector<Weight> weights_;
};

}  // namespace

void lay_out_head_atlas(Mesh& mesh) {
  const Segmentation segmentation(mesh);
  const ToothFlips flips(mesh, segmentation.charts);
  std::vector<std::array<Vec2d, 3>> corner_uvs(mesh.triangles.size());
  parallel_for(kCharts.size(), [&](std::size_t i) {
    const AtlasChart& chart = kCharts[i];
    Patch patch = make_patch(mesh, segmentation.charts, int(i));
    start_border_at_top(patch, chart.side == 0);
    const std::vector<Vec2d> uvs = Flattening(patch, 0.5 * (chart.upper - chart.lower)).run();
    for (std::size_t t = 0; t < patch.triangles.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c)
        corner_uvs[std::size_t(patch.mesh_triangles[t])][c] =
            0.5 * (chart.lower + chart.upper) + uvs[std::size_t(patch.triangles[t][c])];
  });
  mesh.corner_uvs = std::move(corner_uvs);
}

}  // namespace truescatter
