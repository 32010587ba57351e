#include "experiment/audit_sample.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <unordered_map>
#include <unordered_set>

namespace truescatter {
namespace {

// A point of this score is not of the class.
constexpr double kNone = -std::numeric_limits<double>::infinity();

// Distinct points, in the order in which they were chosen.
class Sample {
 public:
  explicit Sample(std::size_t population) : taken_(population, 0) {}

  const std::vector<std::uint32_t>& chosen() const { return chosen_; }

  // Draws until there are `size` (at most the population).
  void draw_to(std::size_t size, std::mt19937_64& generator) {
    while (chosen_.size() < size) add(static_cast<std::uint32_t>(generator() % taken_.size()));
  }

  // The `count` points of the largest scores among those not chosen yet, ties by index: first no two of one
  // group. Returns how many there were.
  std::size_t add_largest(const std::vector<double>& score, const std::vector<int>& group,
                          std::size_t count) {
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < score.size(); ++i) {
      if (taken_[i] == 0 && score[i] > kNone) order.push_back(i);
    }
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return score[a] != score[b] ? score[a] > score[b] : a < b;
    });
    const std::size_t before = chosen_.size();
    const std::size_t wanted = before + std::min(count, order.size());
    std::unordered_set<int> used;
    for (auto i = order.begin(); i != order.end() && chosen_.size() < wanted; ++i) {
      if (used.insert(group[*i]).second) add(*i);
    }
    for (auto i = order.begin(); i != order.end() && chosen_.size() < wanted; ++i) add(*i);
    return chosen_.size() - before;
  }

 private:
  void add(std::uint32_t i) {
    if (taken_[i] != 0) return;
    taken_[i] = 1;
    chosen_.push_back(i);
  }

  std::vector<char> taken_;
  std::vector<std::uint32_t> chosen_;
};

double irradiance_contrast(const ShadingTriangle& triangle) {
  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  for (const Vec3d& value : triangle.irradiance) {
    low = std::min(low, luminance(value));
    high = std::max(high, luminance(value));
  }
  return high - low;
}

std::vector<double> shadow_edge_scores(const AuditInputs& in) {
  std::vector<double> score;
  for (const int t : in.points.triangles)
    score.push_back(irradiance_contrast(in.shading.triangles[static_cast<std::size_t>(t)]));
  return score;
}

std::vector<double> crease_scores(const AuditInputs& in) {
  std::vector<double> score(in.points.size(), 0.0);
  const Image& mask = in.images.mask;
  for (std::size_t i = 0; i < score.size(); ++i) {
    const auto [x, y] = in.points.pixels[i];
    const Vec3d normal = in.images.face_normal.rgb(x, y);
    for (const auto& [nx, ny] : {ViewPoints::Pixel{x + 1, y}, ViewPoints::Pixel{x, y + 1}}) {
      if (nx >= mask.width() || ny >= mask.height() || mask.at(nx, ny, 0) == 0.0F) continue;
      score[i] = std::max(score[i], 1.0 - normal.dot(in.images.face_normal.rgb(nx, ny)));
    }
  }
  return score;
}

double distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  return std::sqrt(squared_distance_to_triangle(p, a, b, b));
}

// The edges and vertices at which S ends.
class SurfaceBorder {
 public:
  explicit SurfaceBorder(const ShadingMesh& shading) : shading_(shading) {
    std::unordered_map<std::uint64_t, int> uses;
    for_edges([&](int a, int b) { ++uses[edge_key(a, b)]; });
    for_edges([&](int a, int b) {
      if (uses[edge_key(a, b)] != 1) return;
      edges_.insert(edge_key(a, b));
      vertices_.insert({a, b});
    });
  }

  // From a point of a triangle to the border that the triangle touches; infinite where it touches none.
  double distance_mm(const ShadingTriangle& triangle, const Vec3d& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = triangle.vertices[c];
      const int b = triangle.vertices[(c + 1) % 3];
      if (vertices_.contains(a)) nearest = std::min(nearest, (p - at(a)).norm());
      if (edges_.contains(edge_key(a, b))) nearest = std::min(nearest, distance_to_segment(p, at(a), at(b)));
    }
    return nearest;
  }

 private:
  template <typename Use>
  void for_edges(const Use& use) const {
    for (const ShadingTriangle& triangle : shading_.triangles) {
      if (!triangle.scatters) continue;
      for (std::size_t c = 0; c < 3; ++c) use(triangle.vertices[c], triangle.vertices[(c + 1) % 3]);
    }
  }
  const Vec3d& at(int vertex) const { return shading_.positions_mm[static_cast<std::size_t>(vertex)]; }

  const ShadingMesh& shading_;
  std::unordered_set<std::uint64_t> edges_;
  std::unordered_set<int> vertices_;
};

std::vector<double> border_distances_mm(const AuditInputs& in) {
  const SurfaceBorder border(in.shading);
  std::vector<double> distance;
  for (std::size_t i = 0; i < in.points.size(); ++i) {
    const auto t = static_cast<std::size_t>(in.points.triangles[i]);
    distance.push_back(border.distance_mm(in.shading.triangles[t], in.points.on_surface[i].position_mm));
  }
  return distance;
}

std::vector<double> smallest_s_scores(const AuditInputs& in, const std::vector<double>& border_mm) {
  std::vector<double> score;
  for (std::size_t i = 0; i < in.points.size(); ++i)
    score.push_back(std::isfinite(border_mm[i]) ? kNone : std::abs(1.0 - in.narrowest[i][3]));
  return score;
}

std::vector<double> cut_locus_scores(const GeodesicSurface& surface, const ViewPoints& points) {
  const IntrinsicMesh& mesh = surface.mesh();
  std::vector<double> score;
  for (const GeodesicTarget& target : points.on_mesh) {
    double worst = kNone;
    for (int j = 0; j < 3; ++j) {
      const IntrinsicMesh::Vertex& vertex = mesh.vertex(mesh.vertex(target.point.face, j));
      const double missing = 2.0 * kPi - vertex.angle;
      if (!vertex.open && missing > 0.0) worst = std::max(worst, missing * target.point.barycentric[j]);
    }
    score.push_back(worst);
  }
  return score;
}

}  // namespace

AuditSample draw_audit_sample(const AuditInputs& inputs, std::size_t wanted, std::uint64_t seed) {
  wanted = std::min(wanted, inputs.points.size());
  const std::vector<double> border_mm = border_distances_mm(inputs);
  std::vector<double> mask_edge;
  mask_edge.reserve(border_mm.size());
  for (const double d : border_mm) mask_edge.push_back(-d);
  std::vector<std::pair<std::string, std::vector<double>>> risks = {
      {"mask_edge", std::move(mask_edge)},  // first, for it may be empty
      {"shadow_edge", shadow_edge_scores(inputs)},
      {"crease", crease_scores(inputs)},
      {"smallest_s", smallest_s_scores(inputs, border_mm)}};
  if (inputs.geodesic != nullptr)
    risks.emplace_back("cut_locus", cut_locus_scores(*inputs.geodesic, inputs.points));

  Sample sample(inputs.points.size());
  std::mt19937_64 generator(seed);
  AuditSample result;
  result.random_count = (wanted + 1) / 2;
  sample.draw_to(result.random_count, generator);
  result.classes.emplace_back("random", result.random_count);
  for (std::size_t k = 0; k < risks.size(); ++k) {
    // What an earlier class could not use falls to the later ones.
    const std::size_t share = (wanted - sample.chosen().size()) / (risks.size() - k);
    result.classes.emplace_back(risks[k].first,
                                sample.add_largest(risks[k].second, inputs.points.triangles, share));
  }
  result.classes.front().second += wanted - sample.chosen().size();
  sample.draw_to(wanted, generator);
  result.points = sample.chosen();
  return result;
}

}  // namespace truescatter
