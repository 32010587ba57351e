#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "scene/builtin.h"
#include "scene/head_shape.h"

namespace truescatter {
namespace {

// Each edge length is meshed once for all tests.
const Mesh& head(double edge_mm) {
  static std::map<double, Mesh> meshes;
  const auto found = meshes.find(edge_mm);
  return found != meshes.end() ? found->second : meshes.emplace(edge_mm, make_head(edge_mm)).first->second;
}

// Joins what is connected; counts what remains.
class Islands {
 public:
  explicit Islands(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[root(a)] = root(b); }
  std::size_t count() {
    std::set<std::size_t> roots;
    for (std::size_t i = 0; i < parent_.size(); ++i) roots.insert(root(i));
    return roots.size();
  }

 private:
  std::vector<std::size_t> parent_;
};

using Edge = std::pair<int, int>;

std::map<Edge, std::size_t> directed_edges(const Mesh& mesh) {
  std::map<Edge, std::size_t> edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) edges[{mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3]}] = t;
  return edges;
}

double smallest_angle_deg(const Mesh& mesh, std::size_t t) {
  double cosine = -1.0;
  for (int c = 0; c < 3; ++c) {
    const Vec3d a = mesh.corner(t, (c + 1) % 3) - mesh.corner(t, c);
    const Vec3d b = mesh.corner(t, (c + 2) % 3) - mesh.corner(t, c);
    cosine = std::max(cosine, a.normalized().dot(b.normalized()));
  }
  return std::acos(std::min(cosine, 1.0)) * 180.0 / kPi;
}

Vec3d face_normal(const Mesh& mesh, std::size_t t) {
  return (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).normalized();
}

double area_mm2(const Mesh& mesh, std::size_t t) {
  return 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
}

// The ratio of the singular values of the map from the surface to UV.
double anisotropy(const Mesh& mesh, std::size_t t) {
  const auto& corners = (*mesh.corner_uvs)[t];
  Eigen::Matrix2d uv;
  uv << corners[1] - corners[0], corners[2] - corners[0];
  Eigen::Matrix<double, 3, 2> edges;
  edges << mesh.corner(t, 1) - mesh.corner(t, 0), mesh.corner(t, 2) - mesh.corner(t, 0);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(edges * uv.inverse()));
  return svd.singularValues()[0] / svd.singularValues()[1];
}

double uv_area(const std::array<Vec2d, 3>& uv) {
  const Vec2d a = uv[1] - uv[0], b = uv[2] - uv[0];
  return 0.5 * (a.x() * b.y() - a.y() * b.x());
}

// The chart of each triangle: what is joined by edges whose UVs agree on both sides.
std::vector<std::size_t> charts(const Mesh& mesh) {
  const auto edges = directed_edges(mesh);
  const auto uv_of = [&](std::size_t t, int vertex) {
    for (std::size_t c = 0; c < 3; ++c)
      if (mesh.triangles[t][c] == vertex) return (*mesh.corner_uvs)[t][c];
    return Vec2d(-1.0, -1.0);
  };
  Islands islands(mesh.triangles.size());
  for (const auto& [edge, t] : edges) {
    const std::size_t other = edges.at({edge.second, edge.first});
    if (uv_of(t, edge.first) == uv_of(other, edge.first) &&
        uv_of(t, edge.second) == uv_of(other, edge.second))
      islands.join(t, other);
  }
  std::vector<std::size_t> result;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) result.push_back(islands.root(t));
  return result;
}

// Calls visit(pixel) for the pixels of a size x size image whose centres lie inside a triangle.
template <typename Visit>
void rasterise(const std::array<Vec2d, 3>& uv, int size, const Visit& visit) {
  const auto range = [&](int axis) {
    const auto [low, high] = std::minmax({uv[0][axis], uv[1][axis], uv[2][axis]});
    return std::pair(std::max(0, int(low * size) - 1), std::min(size - 1, int(high * size) + 1));
  };
  const auto [x0, x1] = range(0);
  const auto [y0, y1] = range(1);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Vec2d p((x + 0.5) / size, (y + 0.5) / size);
      bool is_inside = true;
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec2d edge = uv[(c + 1) % 3] - uv[c], to = p - uv[c];
        is_inside = is_inside && edge.x() * to.y() - edge.y() * to.x() > 0.0;
      }
      if (is_inside) visit(std::size_t(y) * std::size_t(size) + std::size_t(x));
    }
}

// Distances along a ray at which it crosses the skin of the mesh.
std::vector<double> crossings_mm(const Mesh& mesh, const Vec3d& origin, const Vec3d& direction) {
  std::vector<double> result;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Mat3d system;
    system << mesh.corner(t, 1) - mesh.corner(t, 0), mesh.corner(t, 2) - mesh.corner(t, 0), -direction;
    if (std::abs(system.determinant()) < 1e-12) continue;
    const Vec3d hit = system.inverse() * (origin - mesh.corner(t, 0));
    if (hit.x() >= 0.0 && hit.y() >= 0.0 && hit.x() + hit.y() <= 1.0 && hit.z() > 0.0)
      result.push_back(hit.z());
  }
  std::sort(result.begin(), result.end());
  return result;
}

class HeadTest : public testing::TestWithParam<double> {
 protected:
  const Mesh& mesh() const { return head(GetParam()); }
};

TEST_P(HeadTest, IsOneClosedManifoldWithoutHandles) {
  const auto edges = directed_edges(mesh());
  ASSERT_EQ(edges.size(), 3 * mesh().triangles.size()) << "an edge is used twice in one direction";
  Islands islands(mesh().positions_mm.size());
  for (const auto& [edge, t] : edges) {
    ASSERT_TRUE(edges.contains({edge.second, edge.first}));
    islands.join(std::size_t(edge.first), std::size_t(edge.second));
  }
  EXPECT_EQ(islands.count(), 1u);
  const long euler =
      long(mesh().positions_mm.size()) - long(edges.size() / 2) + long(mesh().triangles.size());
  EXPECT_EQ(euler, 2);
}

TEST_P(HeadTest, IsAboutTwoHundredMillimetresTall) {
  double lowest = 0.0, highest = 0.0;
  for (const Vec3d& p : mesh().positions_mm) {
    lowest = std::min(lowest, p.y());
    highest = std::max(highest, p.y());
  }
  EXPECT_GT(highest - lowest, 190.0);
  EXPECT_LT(highest - lowest, 210.0);
}

TEST_P(HeadTest, HasWellShapedTriangles) {
  std::size_t below_20 = 0;
  for (std::size_t t = 0; t < mesh().triangles.size(); ++t) {
    const double angle = smallest_angle_deg(mesh(), t);
    ASSERT_GT(angle, 5.0) << "at " << mesh().corner(t, 0).transpose();
    below_20 += angle < 20.0 ? 1 : 0;
  }
  EXPECT_LT(below_20, mesh().triangles.size() / 500);
}

TEST_P(HeadTest, LiesOnTheSculptedSurface) {
  for (const Vec3d& p : mesh().positions_mm) {
    const ImplicitSample sample = head_sample(p);
    ASSERT_LT(std::abs(sample.value_mm) / sample.gradient.norm(), 0.02) << "at " << p.transpose();
  }
}

TEST_P(HeadTest, HasNormalsThatAgreeWithItsTriangles) {
  std::size_t against = 0;
  for (std::size_t t = 0; t < mesh().triangles.size(); ++t)
    for (const Vec3d& normal : mesh().corner_normals[t]) {
      ASSERT_NEAR(normal.norm(), 1.0, 1e-9);
      against += normal.dot(face_normal(mesh(), t)) <= 0.0 ? 1 : 0;
    }
  EXPECT_LT(against, mesh().triangles.size() / 1000);
}

TEST_P(HeadTest, HasUvsInsideTheUnitSquareWithoutFlips) {
  ASSERT_TRUE(mesh().has_uvs());
  for (const auto& uv : *mesh().corner_uvs) {
    for (const Vec2d& corner : uv) {
      ASSERT_GE(corner.minCoeff(), 0.0);
      ASSERT_LE(corner.maxCoeff(), 1.0);
    }
    ASSERT_GT(uv_area(uv), 1e-12);
  }
}

TEST_P(HeadTest, HasChartsThatDoNotOverlap) {
  // Each texel centre lies in one triangle at most, so the charts neither overlap nor fold.
  constexpr int kSize = 2048;
  std::vector<char> covered(std::size_t(kSize) * kSize, 0);
  std::size_t twice = 0;
  for (const auto& uv : *mesh().corner_uvs)
    rasterise(uv, kSize, [&](std::size_t pixel) {
      twice += covered[pixel] != 0 ? 1 : 0;
      covered[pixel] = 1;
    });
  EXPECT_EQ(twice, 0u);
}

TEST_P(HeadTest, KeepsAGutterBetweenItsCharts) {
  constexpr int kSize = 1024;
  constexpr int kGutter = 8;
  const std::vector<std::size_t> chart_of = charts(mesh());
  std::vector<long> owner(std::size_t(kSize) * kSize, -1);
  for (std::size_t t = 0; t < chart_of.size(); ++t)
    rasterise((*mesh().corner_uvs)[t], kSize, [&](std::size_t pixel) { owner[pixel] = long(chart_of[t]); });
  const auto clash = [&](int x, int y, int other_x, int other_y) {
    if (other_x >= kSize || other_y >= kSize) return false;
    const long a = owner[std::size_t(y) * kSize + std::size_t(x)];
    const long b = owner[std::size_t(other_y) * kSize + std::size_t(other_x)];
    return a >= 0 && b >= 0 && a != b;
  };
  std::size_t clashes = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      for (int d = 1; d <= kGutter; ++d) clashes += clash(x, y, x + d, y) || clash(x, y, x, y + d) ? 1 : 0;
  EXPECT_EQ(clashes, 0u);
}

TEST_P(HeadTest, IsCutIntoSeveralCharts) {
  std::map<std::size_t, std::size_t> triangles_of;
  for (const std::size_t chart : charts(mesh())) ++triangles_of[chart];
  EXPECT_EQ(triangles_of.size(), 9u);
}

TEST_P(HeadTest, GivesTheFaceAFineAndModeratelyStretchedChart) {
  double face_mm2 = 0.0, area_uv = 0.0, stretched_mm2 = 0.0;
  for (std::size_t t = 0; t < mesh().triangles.size(); ++t) {
    const Vec3d center = (mesh().corner(t, 0) + mesh().corner(t, 1) + mesh().corner(t, 2)) / 3.0;
    if (center.z() < 20.0 || center.y() < -60.0 || center.y() > 60.0) continue;
    const auto& uv = (*mesh().corner_uvs)[t];
    const double triangle_mm2 = area_mm2(mesh(), t);
    face_mm2 += triangle_mm2;
    area_uv += uv_area(uv);
    stretched_mm2 += anisotropy(mesh(), t) > 4.0 ? triangle_mm2 : 0.0;
  }
  EXPECT_LT(std::sqrt(face_mm2 / area_uv) / 2048.0, 0.25);
  EXPECT_LT(stretched_mm2, 0.03 * face_mm2);
}

INSTANTIATE_TEST_SUITE_P(EdgeLengths, HeadTest, testing::Values(1.5, 2.5, 5.0));

TEST(Head, IsMirrorSymmetric) {
  for (double x = 1.0; x < 70.0; x += 6.7)
    for (double y = -110.0; y < 100.0; y += 9.1)
      for (double z = -80.0; z < 90.0; z += 8.3)
        ASSERT_EQ(head_distance_mm({x, y, z}), head_distance_mm({-x, y, z}));
}

TEST(Head, IsTheSameEveryTime) {
  const Mesh again = make_head(5.0);
  EXPECT_EQ(again.triangles, head(5.0).triangles);
  EXPECT_EQ(again.positions_mm, head(5.0).positions_mm);
  EXPECT_EQ(*again.corner_uvs, *head(5.0).corner_uvs);
}

TEST(Head, HasThinEarsThatStandOffTheSkull) {
  // Outwards from behind the ear: into the pinna, out of it, and nothing after.
  for (const double side : {-1.0, 1.0}) {
    const std::vector<double> hits = crossings_mm(head(2.5), {side * 51.5, 5.0, -26.0}, {side, 0.0, 0.0});
    ASSERT_GE(hits.size(), 2u);
    EXPECT_GT(hits[1] - hits[0], 1.5);
    EXPECT_LT(hits[1] - hits[0], 5.0);
  }
}

TEST(Head, HasNostrils) {
  const auto depth_at = [](double x, double z) {
    const std::vector<double> hits = crossings_mm(head(2.5), {x, -31.0, z}, Vec3d::UnitY());
    return hits.empty() ? 1e9 : hits.front();
  };
  for (const double side : {-1.0, 1.0}) {
    const double inside = depth_at(side * 5.2, 69.5);
    EXPECT_GT(inside - depth_at(0.0, 69.5), 4.0) << "against the columella";
    EXPECT_GT(inside - depth_at(side * 10.0, 69.5), 4.0) << "against the wing";
  }
}

}  // namespace
}  // namespace truescatter
