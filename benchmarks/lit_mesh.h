#pragma once

#include <array>
#include <functional>
#include <random>
#include <vector>

#include "irradiance/mesh_point.h"
#include "scene/mesh.h"
#include "truth/geodesic_surface.h"
#include "truth/surface.h"

namespace truescatter::benchmarks {

// A mesh with light that is linear on each triangle and random at each vertex, and points on it: what the
// truth's engines are timed on. The same seed gives the same points.
struct LitMesh {
  Mesh mesh;
  Surface surface;
  std::vector<GeodesicPiece> pieces;

  LitMesh(Mesh from, std::uint64_t seed);

  // `count` points drawn by area from the triangles whose centroid `keep` accepts.
  template <typename Keep>
  std::vector<MeshPoint> sample(std::size_t count, std::uint64_t seed, const Keep& keep) const {
    std::vector<std::size_t> kept;
    std::vector<double> area;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      if (!keep(surface.triangles[t].centroid_mm())) continue;
      kept.push_back(t);
      area.push_back(surface.triangles[t].area_mm2());
    }
    std::mt19937_64 generator(seed);
    std::discrete_distribution<std::size_t> choose(area.begin(), area.end());
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::vector<MeshPoint> points;
    for (std::size_t i = 0; i < count; ++i) {
      const double root = std::sqrt(uniform(generator));
      const double share = uniform(generator);
      points.push_back({kept[choose(generator)], {1.0 - root, root * (1.0 - share), root * share}});
    }
    return points;
  }

  std::vector<SurfacePoint> euclidean(const std::vector<MeshPoint>& points) const;
  std::vector<GeodesicTarget> geodesic(const std::vector<MeshPoint>& points) const;
  GeodesicSurface geodesic_surface() const;
};

// Cuts every triangle whose corners `cut` all accepts in four, `times` times; its neighbours are cut in two
// or three to fit. What is left whole keeps its shape, and its number if it comes before what is cut.
Mesh refined_where(Mesh mesh, int times, const std::function<bool(const Vec3d& position_mm)>& cut);

// Moves every vertex at random by at most amplitude_mm / 2 along each axis: a rough surface, half of whose
// vertices are saddles.
Mesh roughened(Mesh mesh, double amplitude_mm, std::uint64_t seed);

// Ends the program with a message: a wrong result has no speed.
[[noreturn]] void wrong_result(const char* what, double error, double allowed);

// The largest difference over all points and layers; colours in units of the largest irradiance.
double largest_difference(const TruthValues& a, const TruthValues& b, double largest_irradiance);

}  // namespace truescatter::benchmarks
