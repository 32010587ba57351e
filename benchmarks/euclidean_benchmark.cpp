// The Euclidean truth: points per second of the engines, against plain SIMD brute force at the same
// tolerance, and against Monte Carlo probes. What carries over to other machines are ratios of rows of one
// run.
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>

#include "core/parallel.h"
#include "lit_mesh.h"
#include "monte_carlo.h"
#include "scene/builtin.h"
#include "simd_brute_force.h"
#include "truth/exact.h"
#include "truth/fast.h"

namespace truescatter::benchmarks {
namespace {

constexpr double kTolerance = 1e-4;
constexpr std::size_t kAudited = 64;

// The built-in head with edges of a hundredth of a millimetre times `edge`.
const LitMesh& head(std::int64_t edge) {
  static std::map<std::int64_t, LitMesh> heads;
  const auto known = heads.find(edge);
  if (known != heads.end()) return known->second;
  return heads.try_emplace(edge, make_builtin("head", {{"edge_mm", static_cast<double>(edge) / 100.0}}), 1)
      .first->second;
}

bool around_the_nose(const Vec3d& x) { return x.z() > 75.0; }

// A dense close-up: a hundred thousand points, some 16 to the square millimetre.
std::vector<SurfacePoint> close_up(const LitMesh& scene, std::size_t count) {
  return scene.euclidean(scene.sample(count, 2, around_the_nose));
}

double std_dev_mm(const benchmark::State& state) { return static_cast<double>(state.range(0)) / 100.0; }

template <typename Convolve>
double error_against_exact(const LitMesh& scene, const TruthLayer& layer, const Convolve& convolve) {
  const std::vector<SurfacePoint> some = close_up(scene, kAudited);
  const TruthValues exact = ExactEngine(scene.surface).convolve(some, std::span(&layer, 1));
  const TruthValues values = {convolve(some)};
  return largest_difference(values, exact, scene.surface.largest_irradiance());
}

void report(benchmark::State& state, std::size_t points, double error) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points));
  state.counters["error"] = error;
}

void fast_engine(benchmark::State& state) {
  const LitMesh& scene = head(state.range(1));
  const JobLimit jobs(static_cast<int>(state.range(3)));
  const TruthLayer layer{std_dev_mm(state)};
  const FastEngine engine(scene.surface, kTolerance);
  const double error = error_against_exact(scene, layer, [&](const auto& points) {
    return engine.convolve(points, std::span(&layer, 1)).front();
  });
  if (error > kTolerance) wrong_result("the fast engine", error, kTolerance);
  const std::vector<SurfacePoint> points = close_up(scene, static_cast<std::size_t>(state.range(2)));
  for (auto _ : state) benchmark::DoNotOptimize(engine.convolve(points, std::span(&layer, 1)));
  report(state, points.size(), error);
  state.counters["triangles"] = static_cast<double>(scene.surface.triangles.size());
}

// The head with edges of 2 mm, of which every triangle 40 mm or more behind the points (8.6 s of 2.72 is 23
// mm) is cut in four, `times` times: the cost of a point is not to know.
const LitMesh& head_refined_far_away(std::int64_t times) {
  static std::map<std::int64_t, LitMesh> heads;
  const auto known = heads.find(times);
  if (known != heads.end()) return known->second;
  return heads
      .try_emplace(times,
                   refined_where(make_builtin("head", {{"edge_mm", 2.0}}), static_cast<int>(times),
                                 [](const Vec3d& x) { return x.z() < 35.0; }),
                   1)
      .first->second;
}

void fast_engine_refined_far_away(benchmark::State& state) {
  const LitMesh& scene = head_refined_far_away(state.range(1));
  const TruthLayer layer{std_dev_mm(state)};
  const FastEngine engine(scene.surface, kTolerance);
  const double error = error_against_exact(scene, layer, [&](const auto& points) {
    return engine.convolve(points, std::span(&layer, 1)).front();
  });
  if (error > kTolerance) wrong_result("the fast engine", error, kTolerance);
  const std::vector<SurfacePoint> points = close_up(scene, 100000);
  for (auto _ : state) benchmark::DoNotOptimize(engine.convolve(points, std::span(&layer, 1)));
  report(state, points.size(), error);
  state.counters["triangles"] = static_cast<double>(scene.surface.triangles.size());
}

void brute_force(benchmark::State& state) {
  const LitMesh& scene = head(state.range(1));
  const TruthLayer layer{std_dev_mm(state)};
  const SimdBruteForce brute(scene.surface, kTolerance, layer.std_dev_mm);
  const double error =
      error_against_exact(scene, layer, [&](const auto& points) { return brute.convolve(points); });
  if (error > kTolerance) wrong_result("SIMD brute force", error, kTolerance);
  const std::vector<SurfacePoint> points = close_up(scene, 2000);
  for (auto _ : state) benchmark::DoNotOptimize(brute.convolve(points));
  report(state, points.size(), error);
  state.counters["nodes"] = static_cast<double>(brute.node_count());
}

void exact_engine(benchmark::State& state) {
  const LitMesh& scene = head(state.range(1));
  const TruthLayer layer{std_dev_mm(state)};
  const ExactEngine engine(scene.surface);
  const std::vector<SurfacePoint> points = close_up(scene, 200);
  for (auto _ : state) benchmark::DoNotOptimize(engine.convolve(points, std::span(&layer, 1)));
  report(state, points.size(), 0.0);
}

// Error against time: the root mean square over points of the difference from exact, in units of the largest
// irradiance. It must be unbiased: the mean over the points is within 5 standard errors of 0.
void monte_carlo(benchmark::State& state) {
  const LitMesh& scene = head(state.range(1));
  const TruthLayer layer{std_dev_mm(state)};
  const MonteCarlo probes(scene);
  const std::vector<MeshPoint> points = scene.sample(kAudited, 2, around_the_nose);
  const TruthValues exact =
      ExactEngine(scene.surface).convolve(scene.euclidean(points), std::span(&layer, 1));
  const int count = static_cast<int>(state.range(2));
  const auto convolve_all = [&] {
    std::vector<Vec4d> values(points.size());
    parallel_for(points.size(), [&](std::size_t i) {
      std::mt19937_64 generator(i);
      values[i] = probes.convolve(points[i], layer.std_dev_mm, count, generator);
    });
    return values;
  };
  double mean = 0.0;
  double square = 0.0;
  const std::vector<Vec4d> values = convolve_all();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double error = values[i][3] - exact[0][i][3];
    mean += error / static_cast<double>(points.size());
    square += error * error / static_cast<double>(points.size());
  }
  const double allowed = 5.0 * std::sqrt(square / static_cast<double>(points.size()));
  if (std::abs(mean) > allowed) wrong_result("the mean of Monte Carlo", std::abs(mean), allowed);
  for (auto _ : state) benchmark::DoNotOptimize(convolve_all());
  report(state, points.size(), std::sqrt(square));
}

// Standard deviation and edge in hundredths of a millimetre, points, jobs.
BENCHMARK(fast_engine)
    ->ArgNames({"s", "edge", "points", "jobs"})
    ->ArgsProduct({{8, 22, 43, 75, 141, 272}, {200}, {100000}, {0}})  // against s
    ->ArgsProduct({{100, 200, 400}, {150}, {100000}, {0}})            // s doubles on a dense mesh
    ->ArgsProduct({{141}, {150, 300, 600}, {100000}, {0}})            // against the mesh
    ->ArgsProduct({{141}, {200}, {1000, 10000, 1000000}, {0}})        // against the points
    ->ArgsProduct({{141}, {200}, {100000}, {1, 2}})                   // against the jobs
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
// Standard deviation in hundredths of a millimetre; how often what is far from the points is cut in four.
BENCHMARK(fast_engine_refined_far_away)
    ->ArgNames({"s", "cuts"})
    ->ArgsProduct({{43, 272}, {0, 1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(brute_force)
    ->ArgNames({"s", "edge"})
    ->ArgsProduct({{43, 75, 141, 272}, {200}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(exact_engine)
    ->ArgNames({"s", "edge"})
    ->ArgsProduct({{8, 43, 141, 272}, {200}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(monte_carlo)
    ->ArgNames({"s", "edge", "probes"})
    ->ArgsProduct({{141}, {200}, {16, 64, 256, 1024, 4096, 16384}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace truescatter::benchmarks
