#include "scene/implicit_mesh.h"

#include <OpenMesh/Core/Mesh/Traits.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/parallel.h"

namespace truescatter {
namespace {

// --- Extraction: marching tetrahedra on a grid ---

// The grid's values. Blocks that the surface surely does not reach hold a lower bound.
class Grid {
 public:
  explicit Grid(const ImplicitSurface& surface) : surface_(surface) {
    const Vec3d extent = (surface.upper_mm - surface.lower_mm) / surface.cell_mm;
    for (int axis = 0; axis < 3; ++axis) blocks_[axis] = int(std::ceil((extent[axis] + 1.0) / kBlock));
    values_mm_.resize(std::size_t(nodes(0)) * std::size_t(nodes(1)) * std::size_t(nodes(2)));
    parallel_for(std::size_t(blocks_.prod()), [this](std::size_t i) { fill_block(int(i)); });
  }

  int nodes(int axis) const { return blocks_[axis] * kBlock; }
  std::uint64_t index(const Vec3i& n) const {
    return (std::uint64_t(n.z()) * std::uint64_t(nodes(1)) + std::uint64_t(n.y())) * std::uint64_t(nodes(0)) +
           std::uint64_t(n.x());
  }
  double value_mm(const Vec3i& n) const { return values_mm_[index(n)]; }
  // A value beyond this means that the surface does not cut a cell at that node.
  double cell_reach_mm() const { return 2.0 * surface_.steepness * surface_.cell_mm; }
  Vec3d position_mm(const Vec3i& n) const { return surface_.lower_mm + surface_.cell_mm * n.cast<double>(); }

 private:
  static constexpr int kBlock = 4;

  void fill_block(int block) {
    const Vec3i first = kBlock * Vec3i(block % blocks_.x(), block / blocks_.x() % blocks_.y(),
                                       block / (blocks_.x() * blocks_.y()));
    const double half_mm = 0.5 * (kBlock - 1) * surface_.cell_mm;
    const double middle_mm = surface_.value_mm(position_mm(first) + Vec3d::Constant(half_mm));
    // What the value is at least anywhere in the block; good enough where that has the middle's sign.
    const double least_mm = std::abs(middle_mm) - surface_.steepness * half_mm * std::sqrt(3.0);
    const bool is_far = least_mm > 0.0;
    for (int k = 0; k < kBlock; ++k)
      for (int j = 0; j < kBlock; ++j)
        for (int i = 0; i < kBlock; ++i) {
          const Vec3i node = first + Vec3i(i, j, k);
          values_mm_[index(node)] =
              is_far ? std::copysign(least_mm, middle_mm) : surface_.value_mm(position_mm(node));
        }
  }

  const ImplicitSurface& surface_;
  Vec3i blocks_;
  std::vector<double> values_mm_;
};

Vec3i corner_offset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2 & 1}; }

// Cuts each cell into six tetrahedra around its diagonal, and these by the surface: always a manifold.
class Extraction {
 public:
  explicit Extraction(const Grid& grid) : grid_(grid) {
    for (int z = 0; z + 1 < grid.nodes(2); ++z)
      for (int y = 0; y + 1 < grid.nodes(1); ++y)
        for (int x = 0; x + 1 < grid.nodes(0); ++x) cut_cell({x, y, z});
  }

  std::vector<Vec3d> positions_mm;
  std::vector<std::array<int, 3>> triangles;

 private:
  void cut_cell(const Vec3i& cell) {
    // Most cells are far from the surface: one value tells.
    if (std::abs(grid_.value_mm(cell)) > grid_.cell_reach_mm()) return;
    int inside = 0;
    for (int c = 0; c < 8; ++c) inside += grid_.value_mm(cell + corner_offset(c)) < 0.0 ? 1 : 0;
    if (inside == 0 || inside == 8) return;
    // Paths from corner 0 to corner 7 along the axes, in the six orders; odd orders are mirrored.
    static constexpr int kPaths[6][2] = {{1, 3}, {2, 6}, {4, 5}, {3, 2}, {6, 4}, {5, 1}};
    for (int i = 0; i < 3; ++i) cut_tetrahedron(cell, {0, kPaths[i][0], kPaths[i][1], 7});
    for (int i = 3; i < 6; ++i) cut_tetrahedron(cell, {0, kPaths[i][0], kPaths[i][1], 7});
  }

  // The corners are positively oriented.
  void cut_tetrahedron(const Vec3i& cell, const std::array<int, 4>& corners) {
    std::array<int, 4> order;  // inside corners first
    int inside = 0, outside = 4;
    for (const int c : corners) {
      if (grid_.value_mm(cell + corner_offset(c)) < 0.0)
        order[std::size_t(inside++)] = c;
      else
        order[std::size_t(--outside)] = c;
    }
    if (inside == 0 || inside == 4) return;
    const auto cut = [&](int a, int b) { return vertex(cell, order[std::size_t(a)], order[std::size_t(b)]); };
    if (inside == 1) {
      add(cell, order, 1, cut(0, 1), cut(0, 2), cut(0, 3));
    } else if (inside == 3) {
      add(cell, order, 3, cut(0, 3), cut(1, 3), cut(2, 3));
    } else {
      const int ac = cut(0, 2), ad = cut(0, 3), bc = cut(1, 2), bd = cut(1, 3);
      add(cell, order, 2, ac, ad, bd);
      add(cell, order, 2, ac, bd, bc);
    }
  }

  // Adds a triangle such that its normal points from the inside corners to the outside ones.
  void add(const Vec3i& cell, const std::array<int, 4>& order, int inside, int a, int b, int c) {
    Vec3d outward = Vec3d::Zero();
    for (int i = 0; i < 4; ++i) {
      const Vec3d corner = grid_.position_mm(cell + corner_offset(order[std::size_t(i)]));
      outward += i < inside ? Vec3d(-corner / inside) : Vec3d(corner / (4 - inside));
    }
    const Vec3d normal = (position(b) - position(a)).cross(position(c) - position(a));
    triangles.push_back(normal.dot(outward) > 0.0 ? std::array<int, 3>{a, b, c}
                                                  : std::array<int, 3>{a, c, b});
  }

  const Vec3d& position(int vertex) const { return positions_mm[std::size_t(vertex)]; }

  // Where the surface cuts an edge. Every edge runs from a corner to one with more of its bits set.
  int vertex(const Vec3i& cell, int from, int to) {
    if (from > to) std::swap(from, to);
    const Vec3i a = cell + corner_offset(from), b = cell + corner_offset(to);
    const std::uint64_t key = grid_.index(a) * 8 + std::uint64_t(to ^ from);
    const auto [entry, is_new] = vertices_.try_emplace(key, int(positions_mm.size()));
    if (is_new) {
      const double va = grid_.value_mm(a), vb = grid_.value_mm(b);
      const double t = std::clamp(va / (va - vb), 0.05, 0.95);  // no two vertices may meet in a corner
      positions_mm.push_back((1.0 - t) * grid_.position_mm(a) + t * grid_.position_mm(b));
    }
    return entry->second;
  }

  const Grid& grid_;
  std::unordered_map<std::uint64_t, int> vertices_;
};

// --- Remeshing ---

struct RemeshTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexTraits {
    double edge_mm = 0.0;  // wanted here
    OpenMesh::Vec3d outward = {0.0, 0.0, 0.0};
  };
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status);
};
using Surface = OpenMesh::TriMesh_ArrayKernelT<RemeshTraits>;
using Point = Surface::Point;

Vec3d to_eigen(const Point& p) { return {p[0], p[1], p[2]}; }
Point to_point(const Vec3d& p) { return {p.x(), p.y(), p.z()}; }

Point unit_normal(const Point& a, const Point& b, const Point& c) {
  const Point n = OpenMesh::cross(b - a, c - a);
  const double length = n.norm();
  return length > 0.0 ? n / length : n;
}

double cotangent(const Point& apex, const Point& a, const Point& b) {
  return OpenMesh::dot(a - apex, b - apex) / OpenMesh::cross(a - apex, b - apex).norm();
}

// Botsch and Kobbelt's isotropic remeshing with a size field; the surface is known, so normals and
// positions are taken from it.
class Remesher {
 public:
  Remesher(const ImplicitSurface& surface, const Extraction& extraction) : surface_(surface) {
    std::vector<Surface::VertexHandle> handles;
    for (const Vec3d& p : extraction.positions_mm) handles.push_back(mesh_.add_vertex(to_point(p)));
    for (const auto& t : extraction.triangles)
      mesh_.add_face(handles[std::size_t(t[0])], handles[std::size_t(t[1])], handles[std::size_t(t[2])]);
    settle_all(1);
  }

  Mesh run() {
    // The extraction is denser than most of the result: thin it out before anything costs much.
    for (int i = 0; i < 3; ++i) collapse_short_edges();
    for (int i = 0; i < 5; ++i) {
      split_long_edges();
      collapse_short_edges();
      flip(&Remesher::flip_evens_valences);
      relax(1);
    }
    for (int i = 0; i < 4; ++i) {
      flip(&Remesher::flip_is_delaunay);
      relax(i < 3 ? 1 : 4);
    }
    flip(&Remesher::flip_is_delaunay);
    return result();
  }

 private:
  double wanted_mm(Surface::HalfedgeHandle h) const {
    return 0.5 *
           (mesh_.data(mesh_.from_vertex_handle(h)).edge_mm + mesh_.data(mesh_.to_vertex_handle(h)).edge_mm);
  }
  const Point& from(Surface::HalfedgeHandle h) const { return mesh_.point(mesh_.from_vertex_handle(h)); }
  const Point& to(Surface::HalfedgeHandle h) const { return mesh_.point(mesh_.to_vertex_handle(h)); }

  // Pulls a vertex onto the surface in Newton steps (one is enough where it will move again) and reads what
  // it must know of it.
  void settle(Surface::VertexHandle v, int steps) {
    Vec3d p = to_eigen(mesh_.point(v));
    Vec3d gradient;
    for (int step = 0; step < steps; ++step) {
      const ImplicitSample sample = surface_.sample(p);
      gradient = sample.gradient;
      const double reach_mm = 0.5 * surface_.cell_mm;
      const double move_mm = std::clamp(sample.value_mm / gradient.norm(), -reach_mm, reach_mm);
      p -= move_mm * gradient.normalized();
      if (std::abs(move_mm) < 1e-3) break;
    }
    mesh_.set_point(v, to_point(p));
    mesh_.data(v).outward = to_point(gradient.normalized());
    mesh_.data(v).edge_mm = surface_.edge_mm(p);
  }
  void settle_all(int steps) {
    parallel_for(mesh_.n_vertices(),
                 [this, steps](std::size_t i) { settle(Surface::VertexHandle{int(i)}, steps); });
  }

  void split_long_edges() {
    const std::size_t edges = mesh_.n_edges();
    for (std::size_t i = 0; i < edges; ++i) {
      const Surface::EdgeHandle e{int(i)};
      if (mesh_.status(e).deleted()) continue;
      const Surface::HalfedgeHandle h = mesh_.halfedge_handle(e, 0);
      if ((to(h) - from(h)).norm() <= 4.0 / 3.0 * wanted_mm(h)) continue;
      const Surface::VertexHandle v = mesh_.add_vertex(0.5 * (from(h) + to(h)));
      mesh_.split(e, v);
      settle(v, 2);
    }
  }

  void collapse_short_edges() {
    for (std::size_t i = 0; i < mesh_.n_edges(); ++i) {
      const Surface::EdgeHandle e{int(i)};
      if (mesh_.status(e).deleted()) continue;
      const Surface::HalfedgeHandle h = mesh_.halfedge_handle(e, 0);
      if ((to(h) - from(h)).norm() >= 0.8 * wanted_mm(h)) continue;
      const Surface::HalfedgeHandle opposite = mesh_.opposite_halfedge_handle(h);
      if (may_collapse(h))
        mesh_.collapse(h);
      else if (may_collapse(opposite))
        mesh_.collapse(opposite);
    }
    mesh_.garbage_collection();
  }

  // Moving h's start into its end must make no edge too long, and no triangle turn away from the surface.
  bool may_collapse(Surface::HalfedgeHandle h) {
    if (!mesh_.is_collapse_ok(h)) return false;
    const Surface::VertexHandle gone = mesh_.from_vertex_handle(h), kept = mesh_.to_vertex_handle(h);
    for (const auto around : mesh_.voh_range(gone)) {
      if (around.to() == kept) continue;
      const double wanted = 0.5 * (mesh_.data(around.to()).edge_mm + mesh_.data(kept).edge_mm);
      if ((mesh_.point(around.to()) - mesh_.point(kept)).norm() > 4.0 / 3.0 * wanted) return false;
      const Surface::VertexHandle next = around.next().to();
      if (next != kept && !faces_outward(kept, around.to(), next)) return false;
    }
    return true;
  }

  bool faces_outward(Surface::VertexHandle a, Surface::VertexHandle b, Surface::VertexHandle c) const {
    const Point normal = unit_normal(mesh_.point(a), mesh_.point(b), mesh_.point(c));
    return OpenMesh::dot(normal, mesh_.data(a).outward) > 0.4 &&
           OpenMesh::dot(normal, mesh_.data(b).outward) > 0.4 &&
           OpenMesh::dot(normal, mesh_.data(c).outward) > 0.4;
  }

  // The edge a-b between the triangles a-b-c and b-a-d.
  struct Diamond {
    Surface::VertexHandle a, b, c, d;
  };
  void flip(bool (Remesher::*improves)(const Diamond&) const) {
    for (std::size_t i = 0; i < mesh_.n_edges(); ++i) {
      const Surface::EdgeHandle e{int(i)};
      if (!mesh_.is_flip_ok(e)) continue;
      const Surface::HalfedgeHandle h = mesh_.halfedge_handle(e, 0);
      const Surface::HalfedgeHandle o = mesh_.opposite_halfedge_handle(h);
      const Diamond diamond{mesh_.from_vertex_handle(h), mesh_.to_vertex_handle(h),
                            mesh_.to_vertex_handle(mesh_.next_halfedge_handle(h)),
                            mesh_.to_vertex_handle(mesh_.next_halfedge_handle(o))};
      if ((this->*improves)(diamond) && faces_outward(diamond.c, diamond.d, diamond.b) &&
          faces_outward(diamond.d, diamond.c, diamond.a))
        mesh_.flip(e);
    }
  }
  bool flip_evens_valences(const Diamond& q) const {
    const auto excess = [this](Surface::VertexHandle v, int change) {
      return std::abs(int(mesh_.valence(v)) + change - 6);
    };
    return excess(q.a, -1) + excess(q.b, -1) + excess(q.c, 1) + excess(q.d, 1) <
           excess(q.a, 0) + excess(q.b, 0) + excess(q.c, 0) + excess(q.d, 0);
  }
  bool flip_is_delaunay(const Diamond& q) const {
    const Point &a = mesh_.point(q.a), &b = mesh_.point(q.b);
    return cotangent(mesh_.point(q.c), a, b) + cotangent(mesh_.point(q.d), a, b) < -1e-6;
  }

  // Moves each vertex along the surface to the middle of its triangles; large triangles for their place
  // pull more.
  void relax(int settling_steps) {
    std::vector<Point> moved(mesh_.n_vertices());
    parallel_for(mesh_.n_vertices(), [&](std::size_t i) {
      const Surface::VertexHandle v{int(i)};
      Point sum(0.0, 0.0, 0.0);
      double weights = 0.0;
      for (const auto h : mesh_.voh_range(v)) {
        const Point &p = mesh_.point(v), &q = mesh_.point(h.to()), &r = mesh_.point(h.next().to());
        const double size = mesh_.data(h.to()).edge_mm + mesh_.data(h.next().to()).edge_mm;
        const double weight = OpenMesh::cross(q - p, r - p).norm() / (size * size);
        sum += weight / 3.0 * (p + q + r);
        weights += weight;
      }
      const Point step = sum / weights - mesh_.point(v);
      const Point& n = mesh_.data(v).outward;
      moved[i] = mesh_.point(v) + step - OpenMesh::dot(step, n) * n;
    });
    for (std::size_t i = 0; i < moved.size(); ++i) mesh_.set_point(Surface::VertexHandle(int(i)), moved[i]);
    settle_all(settling_steps);
  }

  Mesh result() const {
    Mesh mesh;
    for (const auto v : mesh_.vertices()) mesh.positions_mm.push_back(to_eigen(mesh_.point(v)));
    for (const auto f : mesh_.faces()) {
      std::array<int, 3> triangle;
      std::array<Vec3d, 3> normals;
      std::size_t c = 0;
      for (const auto v : mesh_.fv_range(f)) {
        triangle[c] = v.idx();
        normals[c++] = to_eigen(mesh_.data(v).outward);
      }
      mesh.triangles.push_back(triangle);
      mesh.corner_normals.push_back(normals);
    }
    return mesh;
  }

  const ImplicitSurface& surface_;
  Surface mesh_;
};

}  // namespace

Mesh mesh_implicit(const ImplicitSurface& surface) {
  const Grid grid(surface);
  const Extraction extraction(grid);
  return Remesher(surface, extraction).run();
}

}  // namespace truescatter
