#include "lit_mesh.h"

#include <cstdio>
#include <cstdlib>

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
