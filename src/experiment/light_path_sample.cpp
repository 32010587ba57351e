#include "experiment/light_path_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "core/error.h"
#include "truth/geodesic_fast.h"
#include "truth/light_paths.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr double kEdgeStdDevs = 0.5;
// Of the light: LightPathEngine's tail, 1e-5, and its kinks: four deviations of those along one cut locus
// that runs through the Gaussian's middle are 0.088 kink_rms h^2.5 = 1.9e-4
// (tests/truth/light_paths_test.cpp); room for five.
constexpr double kSumError = 1e-3;
constexpr double kEngineTolerance = 1e-4;

std::vector<std::uint32_t> draw(std::size_t population, std::size_t wanted, std::uint64_t seed) {
  std::vector<std::uint32_t> all(population);
  std::iota(all.begin(), all.end(), 0U);
  const std::size_t count = std::min(population, wanted);
  std::mt19937_64 generator(seed);
  for (std::size_t i = 0; i < count; ++i) std::swap(all[i], all[i + generator() % (population - i)]);
  all.resize(count);
  return all;
}

// A profile's weighted sum of one part, RGB at every point.
using LightAtPoints = std::vector<Vec3d>;

template <typename PartOf>
LightAtPoints weighted(const std::vector<GaussianLevel>& levels, std::size_t points, const PartOf& part_of) {
  LightAtPoints light(points, Vec3d::Zero());
  for (std::size_t l = 0; l < levels.size(); ++l) {
    for (std::size_t i = 0; i < points; ++i)
      light[i] += levels[l].weight.cwiseProduct(Vec3d(part_of(l, i).template head<3>()));
  }
  return light;
}

double rms_of(const LightAtPoints& light) {
  double squares = 0.0;
  for (const Vec3d& value : light) squares += std::pow(luminance(value), 2);
  return std::sqrt(squares / static_cast<double>(light.size()));
}

double mean_of(const LightAtPoints& light) {
  double sum = 0.0;
  for (const Vec3d& value : light) sum += luminance(value);
  return sum / static_cast<double>(light.size());
}

LightAtPoints difference(const LightAtPoints& a, const LightAtPoints& b) {
  LightAtPoints light(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) light[i] = a[i] - b[i];
  return light;
}

using Split = std::vector<std::vector<LightPaths>>;
using PartOfPaths = Vec4d (*)(const LightPaths&);

struct NamedPart {
  const char* name;
  PartOfPaths of;
};

constexpr std::array<NamedPart, 5> kParts = {{
    {"transmittance", [](const LightPaths& p) { return p.transmittance; }},
    {"air", [](const LightPaths& p) { return p.air; }},
    {"curvature", [](const LightPaths& p) { return p.curvature; }},
    {"sum", [](const LightPaths& p) { return p.sum(); }},
    {"beyond_r_max", [](const LightPaths& p) { return p.beyond; }},
}};

LightAtPoints part(const std::vector<GaussianLevel>& levels, const Split& split, std::size_t points,
                   PartOfPaths of) {
  return weighted(levels, points, [&](std::size_t l, std::size_t i) { return of(split[l][i]); });
}

}  // namespace

json light_paths_json(const std::string& view, const LightPathInputs& inputs) {
  const Profile& profile = inputs.profile;
  const GeodesicSurface* surface = inputs.truths.geodesic();
  json entry = {{"view", view}, {"profile", profile.name}, {"r_max_mm", profile.r_max_mm}};
  if (surface == nullptr) {
    entry["not_computed"] = inputs.truths.obstacle(OwnTarget{true, true, std::nullopt, false});
    return entry;
  }
  const ViewPoints& all = inputs.view.points();
  const std::vector<std::uint32_t> chosen =
      draw(all.size(), static_cast<std::size_t>(inputs.spec.light_paths), inputs.spec.seed);
  const std::vector<GaussianLevel> levels = gaussian_levels(profile);
  std::vector<GeodesicTarget> targets;
  for (const std::uint32_t i : chosen) targets.push_back(all.on_mesh[i]);
  std::vector<double> std_devs_mm;
  std::vector<TruthLayer> layers;
  Vec3d weights = Vec3d::Zero();
  for (const GaussianLevel& level : levels) {
    std_devs_mm.push_back(level.std_dev_mm());
    layers.push_back({level.std_dev_mm()});
    weights += level.weight.cwiseAbs();
  }
  const auto split = [&](double edge_std_devs) {
    return LightPathEngine(inputs.scene.mesh, *surface, edge_std_devs)
        .split(targets, std_devs_mm, profile.r_max_mm);
  };
  const Split fine = split(kEdgeStdDevs);
  const Split coarse = split(2.0 * kEdgeStdDevs);

  const WeightedSum euclidean = inputs.view.weighted_sum({&profile, OwnTarget{}});
  LightAtPoints straight;
  LightAtPoints truth;
  for (const std::uint32_t i : chosen) {
    straight.push_back(euclidean.light[i]);
    truth.push_back(euclidean.light[i] + profile.delta_weight.cwiseProduct(all.irradiance[i]));
  }
  const double unit = rms_of(truth);
  entry["points"] = chosen.size();
  for (const NamedPart& named : kParts) {
    const LightAtPoints light = part(levels, fine, chosen.size(), named.of);
    const LightAtPoints change = difference(light, part(levels, coarse, chosen.size(), named.of));
    entry[named.name] = {{"rms", rms_of(light) / unit},
                         {"mean", mean_of(light) / unit},
                         {"quadrature_error", rms_of(change) / unit}};
  }

  const TruthValues geodesic = GeodesicFastEngine(*surface, kEngineTolerance).convolve(targets, layers);
  const LightAtPoints along =
      weighted(levels, chosen.size(), [&](std::size_t l, std::size_t i) { return geodesic[l][i]; });
  const LightAtPoints sum = part(levels, fine, chosen.size(), kParts[3].of);
  double largest = 0.0;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    largest = std::max(largest, (sum[i] - (straight[i] - along[i])).cwiseAbs().maxCoeff());
  largest /= inputs.scene.largest_irradiance;
  const double allowed =
      std::max(1.0, weights.maxCoeff()) * (kSumError + kEngineTolerance + inputs.spec.tolerance);
  if (!(largest <= allowed)) {
    throw_run_error(
        "view '{}', profile '{}': transmittance, air and curvature miss the difference of the two truths by "
        "{:.3g} of "
        "the largest irradiance, and {:.3g} is allowed",
        view, profile.name, largest, allowed);
  }
  entry["sum_check"] = {{"max_difference", largest}, {"allowed", allowed}};
  return entry;
}

}  // namespace truescatter
