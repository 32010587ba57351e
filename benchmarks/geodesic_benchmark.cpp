// The geodesic truth: propagation against CGAL on the same local patch, and points per second of the engines.
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>

#include "lit_mesh.h"
#include "scene/builtin.h"
#include "truth/cgal_geodesic.h"
#include "truth/geodesic_exact.h"
#include "truth/geodesic_fast.h"

namespace truescatter::benchmarks {
namespace {

constexpr double kTolerance = 1e-4;

// A rough sphere, half of whose vertices are saddles: hard for geodesics.
const LitMesh& rough_sphere() {
  static const LitMesh scene(
      roughened(make_builtin("sphere", {{"radius_mm", 50.0}, {"edge_mm", 1.0}}), 0.3, 3), 4);
  return scene;
}

const LitMesh& head() {
  static const LitMesh scene(make_builtin("head", {{"edge_mm", 2.0}}), 1);
  return scene;
}

// The triangles that meet a ball, as a mesh of their own.
struct Patch {
  std::vector<Vec3d> positions_mm;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::size_t> from;  // triangle of the whole
};

Patch patch_around(const LitMesh& scene, const Vec3d& center_mm, double radius_mm) {
  Patch patch;
  std::vector<int> renamed(scene.mesh.positions_mm.size(), -1);
  for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
    const auto& corners = scene.surface.triangles[t].corners_mm;
    // Centroids within the radius and an edge: no path of that length leaves these triangles.
    if ((scene.surface.triangles[t].centroid_mm() - center_mm).norm() >
        radius_mm + (corners[0] - corners[1]).norm())
      continue;
    std::array<int, 3> triangle{};
    for (std::size_t c = 0; c < 3; ++c) {
      const int v = scene.mesh.triangles[t][c];
      int& name = renamed[static_cast<std::size_t>(v)];
      if (name < 0) {
        name = static_cast<int>(patch.positions_mm.size());
        patch.positions_mm.push_back(scene.mesh.positions_mm[static_cast<std::size_t>(v)]);
      }
      triangle[c] = name;
    }
    patch.triangles.push_back(triangle);
    patch.from.push_back(t);
  }
  return patch;
}

struct Source {
  MeshPoint on_whole;
  MeshPoint on_patch;
  Patch patch;
};

std::vector<Source> sources(double radius_mm) {
  const LitMesh& scene = rough_sphere();
  std::vector<Source> result;
  for (const MeshPoint& point : scene.sample(8, 5, [](const Vec3d&) { return true; })) {
    Source source{point, point, patch_around(scene, position_mm(scene.mesh, point), radius_mm)};
    const auto& from = source.patch.from;
    source.on_patch.triangle =
        static_cast<std::size_t>(std::find(from.begin(), from.end(), point.triangle) - from.begin());
    result.push_back(std::move(source));
  }
  return result;
}

// A random point of every fifth triangle of the patch.
std::vector<MeshPoint> probes(const Patch& patch) {
  std::mt19937_64 generator(6);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<MeshPoint> points;
  for (std::size_t t = 0; t < patch.triangles.size(); t += 5) {
    const Vec3d b(uniform(generator), uniform(generator), uniform(generator));
    points.push_back({t, b / b.sum()});
  }
  return points;
}

void compare_distances(const std::vector<Source>& all, double radius_mm) {
  const LitMesh& scene = rough_sphere();
  const IntrinsicMesh mesh(scene.mesh.positions_mm, scene.mesh.triangles);
  GeodesicField field(mesh);
  for (const Source& source : all) {
    const CgalGeodesics cgal(source.patch.positions_mm, source.patch.triangles);
    const std::vector<MeshPoint> points = probes(source.patch);
    const std::vector<double> expected = cgal.distances_mm(source.on_patch, points);
    field.propagate({source.on_whole.triangle, source.on_whole.barycentric}, radius_mm);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (expected[i] >= radius_mm) continue;
      const std::size_t face = source.patch.from[points[i].triangle];
      const double difference =
          std::abs(field.distance(face, flat_position(mesh, {face, points[i].barycentric})) - expected[i]);
      if (!(difference <= 1e-10 * radius_mm)) wrong_result("a distance", difference, 1e-10 * radius_mm);
    }
  }
}

double radius_mm(const benchmark::State& state) { return static_cast<double>(state.range(0)) / 10.0; }

void windows(benchmark::State& state) {
  const double radius = radius_mm(state);
  const std::vector<Source> all = sources(radius);
  compare_distances(all, radius);
  const LitMesh& scene = rough_sphere();
  const IntrinsicMesh mesh(scene.mesh.positions_mm, scene.mesh.triangles);
  GeodesicField field(mesh);
  double faces = 0.0;
  double count = 0.0;
  for (auto _ : state) {
    faces = count = 0.0;
    for (const Source& source : all) {
      field.propagate({source.on_whole.triangle, source.on_whole.barycentric}, radius);
      faces += static_cast<double>(field.faces().size());
      count += static_cast<double>(field.window_count());
    }
  }
  const auto n = static_cast<double>(all.size());
  state.counters["faces"] = faces / n;
  state.counters["windows"] = count / n;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(all.size()));
}

// Makes CGAL's structure of each patch and its sequence tree from the source; distances are asked for at one
// point, for the tree is built with the first.
void cgal_on_a_patch(benchmark::State& state) {
  const double radius = radius_mm(state);
  const std::vector<Source> all = sources(radius);
  compare_distances(all, radius);
  for (auto _ : state) {
    for (const Source& source : all) {
      const CgalGeodesics cgal(source.patch.positions_mm, source.patch.triangles);
      benchmark::DoNotOptimize(cgal.distances_mm(source.on_patch, std::span(&source.on_patch, 1)));
    }
  }
  double faces = 0.0;
  for (const Source& source : all) faces += static_cast<double>(source.patch.triangles.size());
  state.counters["faces"] = faces / static_cast<double>(all.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(all.size()));
}

std::vector<GeodesicTarget> close_up(const LitMesh& scene, std::size_t count) {
  return scene.geodesic(scene.sample(count, 2, [](const Vec3d& x) { return x.z() > 75.0; }));
}

TruthLayer layer_of(const benchmark::State& state) { return {static_cast<double>(state.range(0)) / 100.0}; }

// Compares the fast engine with the exact one at `audited` points, then times it at 2000.
void time_fast_engine(benchmark::State& state, const LitMesh& scene, std::size_t audited) {
  const GeodesicSurface surface = scene.geodesic_surface();
  const TruthLayer layer = layer_of(state);
  const GeodesicFastEngine engine(surface, kTolerance);
  const std::vector<GeodesicTarget> some = close_up(scene, audited);
  const double error = largest_difference(engine.convolve(some, std::span(&layer, 1)),
                                          GeodesicExactEngine(surface).convolve(some, std::span(&layer, 1)),
                                          surface.largest_irradiance());
  if (error > kTolerance) wrong_result("the fast geodesic engine", error, kTolerance);
  const std::vector<GeodesicTarget> targets = close_up(scene, 2000);
  for (auto _ : state) benchmark::DoNotOptimize(engine.convolve(targets, std::span(&layer, 1)));
  state.counters["error"] = error;
  state.counters["triangles"] = static_cast<double>(scene.surface.triangles.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(targets.size()));
}

void geodesic_fast_engine(benchmark::State& state) { time_fast_engine(state, head(), 32); }

// As its Euclidean counterpart.
void geodesic_fast_engine_refined_far_away(benchmark::State& state) {
  static std::map<std::int64_t, LitMesh> heads;
  const auto [known, fresh] = heads.try_emplace(
      state.range(1),
      refined_where(make_builtin("head", {{"edge_mm", 2.0}}), static_cast<int>(state.range(1)),
                    [](const Vec3d& x) { return x.z() < 35.0; }),
      1);
  time_fast_engine(state, known->second, 16);
}

void geodesic_exact_engine(benchmark::State& state) {
  const GeodesicSurface surface = head().geodesic_surface();
  const TruthLayer layer = layer_of(state);
  const std::vector<GeodesicTarget> targets = close_up(head(), 32);
  for (auto _ : state)
    benchmark::DoNotOptimize(GeodesicExactEngine(surface).convolve(targets, std::span(&layer, 1)));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(targets.size()));
}

// Radius in tenths of a millimetre: about 130, 500, 1200, 2000 triangles.
BENCHMARK(windows)->ArgName("radius")->Arg(40)->Arg(80)->Arg(127)->Arg(164)->Unit(benchmark::kMillisecond);
BENCHMARK(cgal_on_a_patch)
    ->ArgName("radius")
    ->Arg(40)
    ->Arg(80)
    ->Arg(127)
    ->Arg(164)
    ->Unit(benchmark::kMillisecond);
// Standard deviation in hundredths of a millimetre.
BENCHMARK(geodesic_fast_engine)
    ->ArgName("s")
    ->Arg(8)
    ->Arg(43)
    ->Arg(141)
    ->Arg(272)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
// Standard deviation in hundredths of a millimetre; how often what is far from the points is cut in four.
BENCHMARK(geodesic_fast_engine_refined_far_away)
    ->ArgNames({"s", "cuts"})
    ->ArgsProduct({{43, 272}, {0, 1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(geodesic_exact_engine)
    ->ArgName("s")
    ->Arg(8)
    ->Arg(43)
    ->Arg(141)
    ->Arg(272)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace truescatter::benchmarks

BENCHMARK_MAIN();
