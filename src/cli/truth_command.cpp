#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "arguments.h"
#include "commands.h"
#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "experiment/fit_file.h"
#include "experiment/truth_files.h"
#include "truth/brute.h"
#include "truth/exact.h"
#include "truth/fast.h"
#include "truth/geodesic_brute.h"
#include "truth/geodesic_exact.h"
#include "truth/geodesic_fast.h"

namespace truescatter::cli {
namespace {

// Squares of these and of their quotients with a mesh's size are good doubles.
constexpr double kSmallestStdDev = 1e-9;
constexpr double kLargestStdDev = 1e9;

enum class Engine { fast, exact, brute, cgal };

struct TruthRequest {
  Engine engine = Engine::fast;
  bool geodesic = false;
  double tolerance = 0.0;
  std::vector<TruthLayer> layers;
  std::vector<GaussianLevel> fit;  // of each layer; empty: layers stand for themselves
};

double r_max_of(const TruthArguments& arguments) {
  return arguments.r_max.empty() ? std::numeric_limits<double>::infinity()
                                 : positive(arguments.r_max, "r-max", "a cut-off in mm");
}

// One layer for each of --sigma.
std::vector<TruthLayer> layers_of(const TruthArguments& arguments) {
  TruthLayer layer{0.0, r_max_of(arguments)};
  std::vector<TruthLayer> layers;
  for (const std::string_view word : comma_separated(arguments.sigma)) {
    layer.std_dev_mm = positive(word, "sigma", "a standard deviation in mm");
    if (layer.std_dev_mm < kSmallestStdDev || layer.std_dev_mm > kLargestStdDev) {
      throw_input_error(option("sigma"), "\"{}\" is out of range: a standard deviation is {} to {} mm", word,
                        kSmallestStdDev, kLargestStdDev);
    }
    layers.push_back(layer);
  }
  return layers;
}

// One layer for each Gaussian of --fit.
std::vector<TruthLayer> layers_of(const TruthArguments& arguments, std::span<const GaussianLevel> fit) {
  std::vector<TruthLayer> layers;
  for (const GaussianLevel& level : fit) {
    if (level.std_dev_mm() < kSmallestStdDev || level.std_dev_mm() > kLargestStdDev) {
      throw_input_error({arguments.fit.string()}, "variances[{}] is {}: it must be {} to {} mm^2",
                        layers.size(), level.variance_mm2, kSmallestStdDev * kSmallestStdDev,
                        kLargestStdDev * kLargestStdDev);
    }
    layers.push_back({level.std_dev_mm(), r_max_of(arguments)});
  }
  return layers;
}

void set_layers(const TruthArguments& arguments, TruthRequest& request) {
  if (arguments.sigma.empty() && arguments.fit.empty()) throw_input_error({}, "--sigma or --fit is required");
  if (!arguments.sigma.empty() && !arguments.fit.empty())
    throw_input_error({}, "--sigma and --fit contradict each other: each says which Gaussians");
  if (!arguments.fit.empty()) request.fit = read_fit(arguments.fit);
  request.layers = arguments.fit.empty() ? layers_of(arguments) : layers_of(arguments, request.fit);
}

bool is_geodesic(const TruthArguments& arguments) {
  const std::string metric = arguments.metric.empty() ? "euclidean" : arguments.metric;
  return one_of(metric, "metric", {"euclidean", "geodesic"}) == "geodesic";
}

Engine engine_of(const TruthArguments& arguments) {
  const std::string given =
      arguments.engine.empty() ? (arguments.exact ? "exact" : "fast") : arguments.engine;
  const std::string name = one_of(given, "engine", {"fast", "exact", "brute", "cgal"});
  if (arguments.exact && name != "exact") {
    throw_input_error(
        {}, "--exact and --engine {} contradict each other: --exact is short for --engine exact", name);
  }
  if (name == "cgal" && !is_geodesic(arguments)) {
    throw_input_error(option("engine"), "cgal computes geodesic distances: it needs --metric geodesic");
  }
  if (name == "exact") return Engine::exact;
  if (name == "cgal") return Engine::cgal;
  return name == "brute" ? Engine::brute : Engine::fast;
}

// What each engine can promise in double precision.
double smallest_tolerance(const TruthRequest& request) {
  switch (request.engine) {
    case Engine::fast:
      return request.geodesic ? 1e-7 : 1e-9;
    case Engine::brute:
      return request.geodesic ? 1e-9 : 1e-13;
    case Engine::cgal:
      return 1e-9;
    case Engine::exact:
      return 0.0;
  }
  std::abort();
}

double default_tolerance(const TruthRequest& request) {
  if (request.engine == Engine::fast || request.engine == Engine::exact) return 1e-4;
  return request.geodesic ? 1e-6 : 1e-10;
}

double tolerance_of(const TruthArguments& arguments, const TruthRequest& request) {
  if (arguments.tolerance.empty()) return default_tolerance(request);
  const double tolerance = positive(arguments.tolerance, "tolerance", "a tolerance");
  const double smallest = smallest_tolerance(request);
  if (tolerance < smallest || tolerance > 0.1) {
    throw_input_error(option("tolerance"), "{} is out of range: with this engine it is {} to 0.1", tolerance,
                      smallest);
  }
  return tolerance;
}

// A weighted sum errs by at most the sum of |weights| times what a Gaussian does: each is computed to so much
// less that the sum keeps to the tolerance.
double tolerance_of_each(const TruthRequest& request) {
  Vec3d weights = Vec3d::Zero();
  for (const GaussianLevel& level : request.fit) weights += level.weight.cwiseAbs();
  const double each = request.tolerance / std::max(1.0, weights.maxCoeff());
  if (each < smallest_tolerance(request)) {
    throw_input_error(option("tolerance"),
                      "{} is out of reach: the fit's weights sum to {} in magnitude, and with this engine a "
                      "Gaussian is good to {}",
                      request.tolerance, weights.maxCoeff(), smallest_tolerance(request));
  }
  return each;
}

// one(i) gives every layer at point i, in parallel: [layer][point].
template <typename One>
TruthValues convolve_each(std::size_t points, std::size_t layers, const One& one, Progress& progress) {
  TruthValues values(layers, std::vector<Vec4d>(points));
  parallel_for(points, [&](std::size_t i) {
    const std::vector<Vec4d> sums = one(i);
    for (std::size_t l = 0; l < layers; ++l) values[l][i] = sums[l];
    progress.advance(layers);
  });
  return values;
}

// The engine's single-point function for every layer.
template <typename OneEngine>
auto every_layer(const OneEngine& engine, const TruthProblem& problem, const TruthRequest& request) {
  return [&engine, &problem, &request](std::size_t i) {
    std::vector<Vec4d> sums;
    for (const TruthLayer& layer : request.layers) sums.push_back(engine.convolve(problem.points[i], layer));
    return sums;
  };
}

TruthValues compute_geodesic(const TruthProblem& problem, const TruthRequest& request,
                             const SourceLocation& mesh_file) {
  std::vector<GeodesicPiece> pieces;
  for (std::size_t i = 0; i < problem.surface.triangles.size(); ++i) {
    const SurfaceTriangle& triangle = problem.surface.triangles[i];
    pieces.push_back({problem.mesh_triangle[i],
                      {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()},
                      triangle.irradiance,
                      triangle.component});
  }
  std::vector<GeodesicTarget> targets;
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    targets.push_back(
        {{problem.places[i].triangle, problem.places[i].barycentric}, problem.points[i].component});
  }
  const GeodesicSurface surface(IntrinsicMesh(problem.mesh.positions_mm, problem.mesh.triangles, mesh_file),
                                pieces);
  if (request.engine == Engine::exact) return GeodesicExactEngine(surface).convolve(targets, request.layers);
  Progress progress(
      fmt::format("geodesic truth of {} points, {} Gaussians", targets.size(), request.layers.size()),
      targets.size() * request.layers.size());
  if (request.engine == Engine::fast) {
    return GeodesicFastEngine(surface, request.tolerance)
        .convolve(targets, request.layers, [&](std::size_t steps) { progress.advance(steps); });
  }
  const std::optional<CgalGeodesics> cgal =
      request.engine == Engine::cgal
          ? std::make_optional<CgalGeodesics>(problem.mesh.positions_mm, problem.mesh.triangles)
          : std::nullopt;
  const GeodesicBruteEngine engine(
      surface, cgal ? distances_by_cgal(surface.mesh(), *cgal) : distances_by_windows(surface.mesh()),
      request.tolerance);
  return convolve_each(
      targets.size(), request.layers.size(),
      [&](std::size_t i) { return engine.convolve(targets[i], request.layers); }, progress);
}

TruthValues compute(const TruthProblem& problem, const TruthRequest& request,
                    const SourceLocation& mesh_file) {
  if (request.geodesic) return compute_geodesic(problem, request, mesh_file);
  const std::span<const SurfacePoint> points = problem.points;
  const std::span<const TruthLayer> layers = request.layers;
  Progress progress(fmt::format("truth of {} points, {} Gaussians", points.size(), layers.size()),
                    points.size() * layers.size());
  switch (request.engine) {
    case Engine::fast:
      return FastEngine(problem.surface, request.tolerance).convolve(points, layers, [&](std::size_t steps) {
        progress.advance(steps);
      });
    case Engine::exact: {
      const ExactEngine engine(problem.surface);
      return convolve_each(points.size(), layers.size(), every_layer(engine, problem, request), progress);
    }
    case Engine::brute: {
      const BruteEngine engine(problem.surface, request.tolerance);
      return convolve_each(points.size(), layers.size(), every_layer(engine, problem, request), progress);
    }
    case Engine::cgal:
      break;  // refused with this metric
  }
  std::abort();
}

}  // namespace

int truth(const TruthArguments& arguments) {
  const JobLimit limit(arguments.jobs);
  TruthRequest request;
  request.engine = engine_of(arguments);
  request.geodesic = is_geodesic(arguments);
  request.tolerance = tolerance_of(arguments, request);
  set_layers(arguments, request);
  request.tolerance = tolerance_of_each(request);
  check_out(arguments.out);
  if (request.engine == Engine::exact && !arguments.tolerance.empty())
    fmt::print(stderr, "note: --tolerance changes nothing of the exact engine, which keeps to rounding\n");
  const TruthProblem problem =
      read_truth_problem({arguments.mesh, arguments.irradiance, arguments.points, arguments.mask});
  const TruthValues values = compute(problem, request, {arguments.mesh.string()});
  write_text_file(arguments.out, request.fit.empty() ? truth_csv(request.layers, values)
                                                     : fit_truth_csv(request.fit, values));
  fmt::print("{}\n", arguments.out.string());
  return 0;
}

}  // namespace truescatter::cli
