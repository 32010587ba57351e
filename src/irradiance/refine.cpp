#include "irradiance/refine.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "core/parallel.h"

namespace truescatter {
namespace {

constexpr int kMaxRounds = 24;

// The lighting at a vertex or at an edge's midpoint: one sample for each distinct normal. It is evaluated
// once and shared, so that the irradiance is continuous across an edge, shadow tests included.
struct Sample {
  Vec3d normal;
  MeshPoint point;
  Vec3d irradiance = Vec3d::Zero();
};
using Samples = std::vector<Sample>;

const Sample* find_sample(const Samples& samples, const Vec3d& normal) {
  for (const Sample& sample : samples) {
    if (same_normal(sample.normal, normal)) return &sample;
  }
  return nullptr;
}

using EdgeId = std::uint32_t;

struct Edge {
  Samples middle;
  int midpoint = -1;               // the vertex there, once the edge is split
  std::array<EdgeId, 2> halves{};  // then: the one at its vertex of the lower number, and the other
};

// What a triangle's edges are known by: edge c leads from its corner c to the next.
using TriangleEdges = std::array<EdgeId, 3>;

// Whether a triangle's front may be seen: it faces the eye, and does not lie outside one of the frustum's
// sides. What hides it is not asked. No part of a triangle that is not seen is.
bool may_see(const Camera& camera, const std::array<Vec3d, 3>& corners_mm) {
  const Vec3d normal = (corners_mm[1] - corners_mm[0]).cross(corners_mm[2] - corners_mm[0]);
  if (normal.dot(camera.eye_mm - corners_mm[0]) <= 0.0) return false;
  const Mat4d view = camera.view_matrix();
  const double half_width = 0.5 * camera.width_px / camera.focal_px();
  const double half_height = 0.5 * camera.height_px / camera.focal_px();
  // In view space the frustum's sides are planes through the eye, and the eye's own plane.
  const std::array<Vec3d, 5> inward{Vec3d(1.0, 0.0, -half_width), Vec3d(-1.0, 0.0, -half_width),
                                    Vec3d(0.0, 1.0, -half_height), Vec3d(0.0, -1.0, -half_height),
                                    Vec3d(0.0, 0.0, -1.0)};
  return std::all_of(inward.begin(), inward.end(), [&](const Vec3d& side) {
    return std::any_of(corners_mm.begin(), corners_mm.end(), [&](const Vec3d& corner) {
      return side.dot((view * corner.homogeneous()).head<3>()) >= 0.0;
    });
  });
}

class Refiner {
 public:
  Refiner(ShadingMesh& shading, const Mesh& mesh, const Lighting& lighting, const SkinMask& mask,
          const RefinementSettings& settings)
      : shading_(shading),
        mesh_(mesh),
        lighting_(lighting),
        mask_(mask),
        floor_mm_(settings.floor_mm),
        views_(settings.views),
        visible_edge_mm_(settings.visible_edge_mm),
        tolerance_(settings.tolerance * lighting.largest_possible()) {}

  void run() {
    start();
    number_edges();
    for (int round = 0; round < kMaxRounds; ++round) {
      light_new_edges();
      if (!mark_edges()) return;
      close_marks();
      split_triangles();
    }
  }

 private:
  void start() {
    shading_.positions_mm = mesh_.positions_mm;
    vertex_samples_.resize(mesh_.positions_mm.size());
    std::vector<Sample*> wanted;
    shading_.triangles.reserve(mesh_.triangle_count());
    for (std::size_t t = 0; t < mesh_.triangle_count(); ++t) {
      ShadingTriangle triangle;
      triangle.vertices = mesh_.triangles[t];
      triangle.base = t;
      for (std::size_t c = 0; c < 3; ++c) {
        triangle.base_barycentric[c] = Vec3d::Unit(static_cast<Eigen::Index>(c));
        triangle.normals[c] = mesh_.corner_normals[t][c];
        triangle.uvs[c] = mesh_.has_uvs() ? (*mesh_.corner_uvs)[t][c] : Vec2d::Zero();
        Samples& samples = vertex_samples_[static_cast<std::size_t>(triangle.vertices[c])];
        if (find_sample(samples, triangle.normals[c]) == nullptr) {
          samples.push_back({triangle.normals[c], {t, triangle.base_barycentric[c]}});
        }
      }
      shading_.triangles.push_back(triangle);
    }
    for (Samples& samples : vertex_samples_) {
      for (Sample& sample : samples) wanted.push_back(&sample);
    }
    light(wanted);
    for (ShadingTriangle& triangle : shading_.triangles) {
      for (std::size_t c = 0; c < 3; ++c) {
        triangle.irradiance[c] =
            find_sample(vertex_samples_[static_cast<std::size_t>(triangle.vertices[c])], triangle.normals[c])
                ->irradiance;
      }
    }
    new_triangles_.resize(shading_.triangles.size());
    for (std::size_t t = 0; t < new_triangles_.size(); ++t) new_triangles_[t] = t;
  }

  void number_edges() {
    std::unordered_map<std::uint64_t, EdgeId> known;
    known.reserve(2 * shading_.triangles.size());
    edges_of_.reserve(shading_.triangles.size());
    for (const ShadingTriangle& triangle : shading_.triangles) {
      TriangleEdges& ids = edges_of_.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint64_t key = edge_key(triangle.vertices[c], triangle.vertices[(c + 1) % 3]);
        const auto [found, is_new] = known.try_emplace(key, static_cast<EdgeId>(edges_.size()));
        if (is_new) add_edge();
        ids[c] = found->second;
      }
    }
  }

  EdgeId add_edge() {
    edges_.emplace_back();
    split_.push_back(0);
    refuses_linear_.push_back(0);
    return static_cast<EdgeId>(edges_.size() - 1);
  }

  void light(const std::vector<Sample*>& samples) const {
    parallel_for(samples.size(), [&](std::size_t i) {
      samples[i]->irradiance = lighting_.smooth_irradiance(samples[i]->point);
    });
  }

  double length_mm(int a, int b) const {
    return (shading_.positions_mm[static_cast<std::size_t>(a)] -
            shading_.positions_mm[static_cast<std::size_t>(b)])
        .norm();
  }

  MeshPoint edge_middle(const ShadingTriangle& triangle, std::size_t c) const {
    return {triangle.base, 0.5 * (triangle.base_barycentric[c] + triangle.base_barycentric[(c + 1) % 3])};
  }

  bool mask_differs(const ShadingTriangle& triangle, std::size_t c) const {
    if (mask_.everywhere()) return false;
    const Vec2d& a = triangle.uvs[c];
    const Vec2d& b = triangle.uvs[(c + 1) % 3];
    const bool skin = mask_.is_skin(a);
    return mask_.is_skin(b) != skin || mask_.is_skin(0.5 * (a + b)) != skin;
  }

  // Adds the lighting at an edge's midpoint to what is to be evaluated, if it is not known.
  void want_middle(const ShadingTriangle& triangle, std::size_t c, EdgeId id,
                   std::vector<std::pair<EdgeId, std::size_t>>& wanted) {
    const MeshPoint middle = edge_middle(triangle, c);
    const Vec3d normal = interpolated_normal(mesh_, middle);
    Samples& samples = edges_[id].middle;
    if (find_sample(samples, normal) != nullptr) return;
    wanted.emplace_back(id, samples.size());
    samples.push_back({normal, middle});
  }

  void light_middles(const std::vector<std::pair<EdgeId, std::size_t>>& wanted) {
    std::vector<Sample*> samples;
    for (const auto& [id, index] : wanted) samples.push_back(&edges_[id].middle[index]);
    light(samples);
  }

  // Evaluates the lighting at the midpoints of edges that are new, and compares.
  void light_new_edges() {
    std::vector<std::pair<EdgeId, std::size_t>> wanted;  // edge, index into its samples
    for (const std::size_t t : new_triangles_) {
      const ShadingTriangle& triangle = shading_.triangles[t];
      for (std::size_t c = 0; c < 3; ++c) {
        if (length_mm(triangle.vertices[c], triangle.vertices[(c + 1) % 3]) <= floor_mm_) continue;
        want_middle(triangle, c, edges_of_[t][c], wanted);
      }
    }
    light_middles(wanted);
    for (const std::size_t t : new_triangles_) {
      const ShadingTriangle& triangle = shading_.triangles[t];
      for (std::size_t c = 0; c < 3; ++c) {
        const EdgeId id = edges_of_[t][c];
        if (edges_[id].middle.empty()) continue;
        const Vec3d normal = interpolated_normal(mesh_, edge_middle(triangle, c));
        const Sample* sample = find_sample(edges_[id].middle, normal);
        if (sample == nullptr) continue;
        const Vec3d linear = 0.5 * (triangle.irradiance[c] + triangle.irradiance[(c + 1) % 3]);
        if ((sample->irradiance - linear).cwiseAbs().maxCoeff() > tolerance_ || mask_differs(triangle, c)) {
          refuses_linear_[id] = 1;
        }
      }
    }
  }

  std::size_t longest_edge(const ShadingTriangle& triangle) const {
    std::size_t longest = 0;
    std::pair<double, std::uint64_t> best(-1.0, 0);
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = triangle.vertices[c];
      const int b = triangle.vertices[(c + 1) % 3];
      // The key breaks ties alike for both triangles of an edge.
      const std::pair<double, std::uint64_t> candidate(length_mm(a, b), edge_key(a, b));
      if (candidate > best) {
        best = candidate;
        longest = c;
      }
    }
    return longest;
  }

  bool centroid_refuses_linear(const ShadingTriangle& triangle) const {
    const MeshPoint centroid{
        triangle.base,
        (triangle.base_barycentric[0] + triangle.base_barycentric[1] + triangle.base_barycentric[2]) / 3.0};
    const Vec3d linear = (triangle.irradiance[0] + triangle.irradiance[1] + triangle.irradiance[2]) / 3.0;
    return (lighting_.smooth_irradiance(centroid) - linear).cwiseAbs().maxCoeff() > tolerance_;
  }

  bool in_view(const ShadingTriangle& triangle) const {
    const std::array<Vec3d, 3> corners{shading_.corner(triangle, 0), shading_.corner(triangle, 1),
                                       shading_.corner(triangle, 2)};
    return std::any_of(views_.begin(), views_.end(),
                       [&](const Camera& camera) { return may_see(camera, corners); });
  }

  bool is_skin(const ShadingTriangle& triangle) const {
    return mask_.is_skin((triangle.uvs[0] + triangle.uvs[1] + triangle.uvs[2]) / 3.0);
  }

  // Marks the edges of new triangles of visible skin that are longer than wanted there.
  bool mark_visible_edges() {
    if (!std::isfinite(visible_edge_mm_)) return false;
    bool any = false;
    for (const std::size_t t : new_triangles_) {
      const ShadingTriangle& triangle = shading_.triangles[t];
      if (!is_skin(triangle) || !in_view(triangle)) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        if (length_mm(triangle.vertices[c], triangle.vertices[(c + 1) % 3]) <= visible_edge_mm_) continue;
        split_[edges_of_[t][c]] = 1;
        any = true;
      }
    }
    return any;
  }

  // Marks the edges that must be split; false when there is none. Centroids are tested once per triangle,
  // for triangles whose edges all pass.
  bool mark_edges() {
    bool any = mark_visible_edges();
    for (const std::size_t t : new_triangles_) {
      for (const EdgeId id : edges_of_[t]) {
        if (refuses_linear_[id] == 0) continue;
        split_[id] = 1;
        any = true;
      }
    }
    std::vector<char> refuses(new_triangles_.size(), 0);
    parallel_for(new_triangles_.size(), [&](std::size_t i) {
      const ShadingTriangle& triangle = shading_.triangles[new_triangles_[i]];
      const std::size_t c = longest_edge(triangle);
      if (length_mm(triangle.vertices[c], triangle.vertices[(c + 1) % 3]) <= floor_mm_) return;
      refuses[i] = centroid_refuses_linear(triangle) ? 1 : 0;
    });
    for (std::size_t i = 0; i < new_triangles_.size(); ++i) {
      if (refuses[i] == 0) continue;
      const std::size_t t = new_triangles_[i];
      split_[edges_of_[t][longest_edge(shading_.triangles[t])]] = 1;
      any = true;
    }
    return any;
  }

  // Rivara's closure: a triangle with a marked edge has its longest edge marked.
  void close_marks() {
    bool changed = true;
    while (changed) {
      changed = false;
      for (std::size_t t = 0; t < shading_.triangles.size(); ++t) {
        if (!has_mark(edges_of_[t])) continue;
        char& longest = split_[edges_of_[t][longest_edge(shading_.triangles[t])]];
        if (longest == 0) {
          longest = 1;
          changed = true;
        }
      }
    }
  }

  bool has_mark(const TriangleEdges& ids) const {
    return std::any_of(ids.begin(), ids.end(), [&](EdgeId id) { return split_[id] != 0; });
  }

  // Vertices and their lighting for the marked edges, then the triangles.
  void split_triangles() {
    const std::vector<EdgeId> marked = place_midpoints();
    Triangles kept;
    Triangles fresh;
    for (std::size_t t = 0; t < shading_.triangles.size(); ++t) {
      const ShadingTriangle& triangle = shading_.triangles[t];
      if (has_mark(edges_of_[t])) {
        bisect(triangle, edges_of_[t], longest_edge(triangle), fresh);
      } else {
        kept.add(triangle, edges_of_[t]);
      }
    }
    for (const EdgeId id : marked) edges_[id].middle = Samples();
    new_triangles_.clear();
    for (std::size_t i = 0; i < fresh.triangles.size(); ++i)
      new_triangles_.push_back(kept.triangles.size() + i);
    kept.triangles.insert(kept.triangles.end(), fresh.triangles.begin(), fresh.triangles.end());
    kept.edges.insert(kept.edges.end(), fresh.edges.begin(), fresh.edges.end());
    shading_.triangles = std::move(kept.triangles);
    edges_of_ = std::move(kept.edges);
  }

  // Of the marked edges, which it returns. Those at or below the floor get here only through the closure,
  // without samples.
  std::vector<EdgeId> place_midpoints() {
    std::vector<EdgeId> marked;
    std::vector<std::pair<EdgeId, std::size_t>> wanted;
    for (std::size_t t = 0; t < shading_.triangles.size(); ++t) {
      const ShadingTriangle& triangle = shading_.triangles[t];
      for (std::size_t c = 0; c < 3; ++c) {
        const EdgeId id = edges_of_[t][c];
        if (split_[id] == 0) continue;
        want_middle(triangle, c, id, wanted);
        if (edges_[id].midpoint >= 0) continue;
        marked.push_back(id);
        edges_[id].midpoint = static_cast<int>(shading_.positions_mm.size());
        shading_.positions_mm.push_back(
            0.5 * (shading_.positions_mm[static_cast<std::size_t>(triangle.vertices[c])] +
                   shading_.positions_mm[static_cast<std::size_t>(triangle.vertices[(c + 1) % 3])]));
        const std::array<EdgeId, 2> halves{add_edge(), add_edge()};
        edges_[id].halves = halves;
      }
    }
    light_middles(wanted);
    return marked;
  }

  // Triangles beside their edges.
  struct Triangles {
    void add(const ShadingTriangle& triangle, const TriangleEdges& ids) {
      triangles.push_back(triangle);
      edges.push_back(ids);
    }
    std::vector<ShadingTriangle> triangles;
    std::vector<TriangleEdges> edges;
  };

  // Splits a triangle at the midpoint of edge c; the halves go on where they still have a marked edge.
  void bisect(const ShadingTriangle& triangle, const TriangleEdges& ids, std::size_t c, Triangles& out) {
    const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
    const Edge& edge = edges_[ids[c]];
    const MeshPoint middle = edge_middle(triangle, c);
    const Vec3d normal = interpolated_normal(mesh_, middle);
    const Sample* sample = find_sample(edge.middle, normal);
    assert(sample != nullptr);
    const auto half = [&](std::size_t replaced) {
      ShadingTriangle result = triangle;
      result.vertices[replaced] = edge.midpoint;
      result.base_barycentric[replaced] = middle.barycentric;
      result.normals[replaced] = normal;
      result.uvs[replaced] = 0.5 * (triangle.uvs[c] + triangle.uvs[next]);
      result.irradiance[replaced] = sample->irradiance;
      return result;
    };
    const ShadingTriangle first = half(next), second = half(c);
    const bool ascends = triangle.vertices[c] < triangle.vertices[next];
    TriangleEdges of_first = ids, of_second = ids;
    of_first[c] = edge.halves[ascends ? 0 : 1];
    of_second[c] = edge.halves[ascends ? 1 : 0];
    of_first[next] = of_second[last] = add_edge();  // between them; `edge` may have moved
    add_or_bisect(first, of_first, out);
    add_or_bisect(second, of_second, out);
  }

  void add_or_bisect(const ShadingTriangle& triangle, const TriangleEdges& ids, Triangles& out) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (split_[ids[c]] != 0) return bisect(triangle, ids, c, out);
    }
    out.add(triangle, ids);
  }

  ShadingMesh& shading_;
  const Mesh& mesh_;
  const Lighting& lighting_;
  const SkinMask& mask_;
  double floor_mm_;
  const std::vector<Camera>& views_;
  double visible_edge_mm_;
  double tolerance_;
  std::vector<Samples> vertex_samples_;
  std::vector<Edge> edges_;
  std::vector<char> split_;              // of each edge: it is to be split, or was
  std::vector<char> refuses_linear_;     // of each: the lighting at its midpoint, or the mask, asks for it
  std::vector<TriangleEdges> edges_of_;  // of shading_.triangles
  std::vector<std::size_t> new_triangles_;
};

}  // namespace

void refine(ShadingMesh& shading, const Mesh& mesh, const Lighting& lighting, const SkinMask& mask,
            const RefinementSettings& settings) {
  Refiner(shading, mesh, lighting, mask, settings).run();
}

}  // namespace truescatter
