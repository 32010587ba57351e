#include "lit_mesh.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>

namespace truescatter::benchmarks {

LitMesh::LitMesh(Mesh from, std::uint64_t seed) : mesh(std::move(from)) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Vec3d> light(mesh.positions_mm.size());
  for (Vec3d& value : light) value = {uniform(generator), uniform(generator), uniform(generator)};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    SurfaceTriangle triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = static_cast<std::size_t>(mesh.triangles[t][c]);
      triangle.corners_mm[c] = mesh.positions_mm[v];
      triangle.irradiance[c] = light[v];
    }
    surface.triangles.push_back(triangle);
    pieces.push_back({t, {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()}, triangle.irradiance, 0});
  }
}

std::vector<SurfacePoint> LitMesh::euclidean(const std::vector<MeshPoint>& points) const {
  std::vector<SurfacePoint> result;
  for (const MeshPoint& point : points) result.push_back({position_mm(mesh, point), 0});
  return result;
}

std::vector<GeodesicTarget> LitMesh::geodesic(const std::vector<MeshPoint>& points) const {
  std::vector<GeodesicTarget> result;
  for (const MeshPoint& point : points) result.push_back({{point.triangle, point.barycentric}, 0});
  return result;
}

GeodesicSurface LitMesh::geodesic_surface() const {
  return {IntrinsicMesh(mesh.positions_mm, mesh.triangles), pieces};
}

Mesh refined_where(Mesh mesh, int times, const std::function<bool(const Vec3d&)>& cut) {
  for (int time = 0; time < times; ++time) {
    const auto accepted = [&](int v) { return cut(mesh.positions_mm[static_cast<std::size_t>(v)]); };
    std::map<std::uint64_t, int> middles;
    for (const auto& t : mesh.triangles) {
      if (!std::all_of(t.begin(), t.end(), accepted)) continue;
      for (std::size_t e = 0; e < 3; ++e) {
        const int a = t[e];
        const int b = t[(e + 1) % 3];
        const auto count = static_cast<int>(mesh.positions_mm.size());
        if (!middles.try_emplace(edge_key(a, b), count).second) continue;
        mesh.positions_mm.emplace_back(0.5 * (mesh.positions_mm[static_cast<std::size_t>(a)] +
                                              mesh.positions_mm[static_cast<std::size_t>(b)]));
      }
    }
    std::vector<std::array<int, 3>> finer;
    for (const auto& t : mesh.triangles) {
      // The corners and what middles there are, in order round: a fan about a middle, or the four parts.
      std::array<int, 3> middle = {-1, -1, -1};
      int count = 0;
      for (std::size_t e = 0; e < 3; ++e) {
        const auto found = middles.find(edge_key(t[e], t[(e + 1) % 3]));
        if (found == middles.end()) continue;
        middle[e] = found->second;
        ++count;
      }
      if (count == 3) {
        finer.insert(finer.end(), {{t[0], middle[0], middle[2]},
                                   {middle[0], t[1], middle[1]},
                                   {middle[2], middle[1], t[2]},
                                   {middle[0], middle[1], middle[2]}});
        continue;
      }
      std::vector<int> round;
      for (std::size_t e = 0; e < 3; ++e) {
        round.push_back(t[e]);
        if (middle[e] >= 0) round.push_back(middle[e]);
      }
      if (count > 0) {
        // About a middle: about a corner, a triangle could be without area.
        const auto hub = std::find_if(round.begin(), round.end(), [&](int v) {
          return std::find(middle.begin(), middle.end(), v) != middle.end();
        });
        std::rotate(round.begin(), hub, round.end());
      }
      for (std::size_t i = 1; i + 1 < round.size(); ++i) finer.push_back({round[0], round[i], round[i + 1]});
    }
    mesh.triangles = finer;
  }
  return mesh;
}

Mesh roughened(Mesh mesh, double amplitude_mm, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (Vec3d& p : mesh.positions_mm)
    p += amplitude_mm * Vec3d(uniform(generator), uniform(generator), uniform(generator));
  return mesh;
}

void wrong_result(const char* what, double error, double allowed) {
  std::fprintf(stderr, "%s is wrong: off by %g, allowed %g; nothing is timed\n", what, error, allowed);
  std::exit(1);
}

double largest_difference(const TruthValues& a, const TruthValues& b, double largest_irradiance) {
  const Vec4d unit(largest_irradiance, largest_irradiance, largest_irradiance, 1.0);
  double worst = 0.0;
  for (std::size_t l = 0; l < a.size(); ++l) {
    for (std::size_t i = 0; i < a[l].size(); ++i)
      worst = std::max(worst, (a[l][i] - b[l][i]).cwiseAbs().cwiseQuotient(unit).maxCoeff());
  }
  return worst;
}

}  // namespace truescatter::benchmarks
