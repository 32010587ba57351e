// Points per second of the truth's engines on the built-in head, against the standard deviation. The figure
// that carries over to other machines is the ratio of two rows of one run.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <random>

#include "core/parallel.h"
#include "scene/builtin.h"
#include "truth/exact.h"
#include "truth/fast.h"

namespace truescatter {
namespace {

constexpr double kTolerance = 1e-4;

// The head with irradiance that varies from vertex to vertex, and neighbouring points on it as a close view
// has them.
struct Fixture {
  Surface surface;
  std::vector<SurfacePoint> points;

  Fixture() {
    const Mesh mesh = make_builtin("head");
    std::mt19937_64 generator(1);
    const auto uniform = [&] { return static_cast<double>(generator() >> 11U) * 0x1.0p-53; };
    std::vector<Vec3d> value(mesh.positions_mm.size());
    for (Vec3d& v : value) v = Vec3d::Constant(uniform());
    for (const auto& t : mesh.triangles) {
      SurfaceTriangle triangle;
      for (std::size_t c = 0; c < 3; ++c) {
        triangle.corners_mm[c] = mesh.positions_mm[static_cast<std::size_t>(t[c])];
        triangle.irradiance[c] = value[static_cast<std::size_t>(t[c])];
      }
      surface.triangles.push_back(triangle);
    }
    // 20 points on each triangle of a patch around the nose.
    for (const SurfaceTriangle& t : surface.triangles) {
      if (t.centroid_mm().z() < 75.0) continue;
      for (int i = 0; i < 20; ++i) {
        Vec3d b(uniform(), uniform(), uniform());
        b /= b.sum();
        points.push_back({b[0] * t.corners_mm[0] + b[1] * t.corners_mm[1] + b[2] * t.corners_mm[2], 0});
      }
    }
  }
};

const Fixture& fixture() {
  static const Fixture shared;
  return shared;
}

TruthLayer layer_of(const benchmark::State& state) { return {static_cast<double>(state.range(0)) / 100.0}; }

// Ends the program if the two engines disagree: a wrong result has no speed.
void compare_first(const TruthLayer& layer) {
  const std::span<const SurfacePoint> some = std::span(fixture().points).first(64);
  const TruthValues fast = FastEngine(fixture().surface, kTolerance).convolve(some, std::span(&layer, 1));
  const TruthValues exact = ExactEngine(fixture().surface).convolve(some, std::span(&layer, 1));
  for (std::size_t i = 0; i < some.size(); ++i) {
    if ((fast[0][i] - exact[0][i]).cwiseAbs().maxCoeff() <= kTolerance) continue;
    std::fprintf(stderr, "the engines disagree at s = %g mm\n", layer.std_dev_mm);
    std::exit(1);
  }
}

void fast_engine(benchmark::State& state) {
  const TruthLayer layer = layer_of(state);
  compare_first(layer);
  const FastEngine engine(fixture().surface, kTolerance);
  for (auto _ : state) benchmark::DoNotOptimize(engine.convolve(fixture().points, std::span(&layer, 1)));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(fixture().points.size()));
}

void exact_engine(benchmark::State& state) {
  const TruthLayer layer = layer_of(state);
  compare_first(layer);
  const ExactEngine engine(fixture().surface);
  const std::span<const SurfacePoint> some = std::span(fixture().points).first(200);
  for (auto _ : state) benchmark::DoNotOptimize(engine.convolve(some, std::span(&layer, 1)));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(some.size()));
}

// Standard deviation in hundredths of a millimetre.
BENCHMARK(fast_engine)
    ->Arg(8)
    ->Arg(43)
    ->Arg(75)
    ->Arg(152)
    ->Arg(272)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(exact_engine)
    ->Arg(8)
    ->Arg(43)
    ->Arg(75)
    ->Arg(152)
    ->Arg(272)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace truescatter

BENCHMARK_MAIN();
