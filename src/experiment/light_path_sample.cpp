#include "experiment/light_path_sample.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/stopwatch.h"
#include "truth/geodesic_exact.h"
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
// Of values with transmittance, in units of the largest irradiance: what jumps where the way along the
// surface passes r_max, and where straight ways begin to leave the body, is quadrature's of first order. A
// twentieth of the 2 % that a method may be asked for.
constexpr double kPartsTolerance = 1e-3;
constexpr int kMostHalvings = 4;
constexpr std::size_t kAuditedPoints = 32;

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

constexpr std::array<Vec4d LightPaths::*, 5> kFieldsOfPaths = {&LightPaths::transmittance, &LightPaths::air,
                                                               &LightPaths::curvature, &LightPaths::beyond,
                                                               &LightPaths::through};
static_assert(sizeof(LightPaths) == kFieldsOfPaths.size() * sizeof(Vec4d));

LightAtPoints part(const std::vector<GaussianLevel>& levels,
                   const std::vector<std::vector<LightPaths>>& split, std::size_t points, PartOfPaths of) {
  return weighted(levels, points, [&](std::size_t l, std::size_t i) { return of(split[l][i]); });
}

}  // namespace

LightPathSample::LightPathSample(const LightPathInputs& inputs)
    : inputs_(inputs),
      levels_(gaussian_levels(inputs.profile)),
      chosen_(draw(inputs.view.points().size(), inputs.points, inputs.seed)) {
  assert(inputs.truths.geodesic() != nullptr);
  for (const std::uint32_t i : chosen_) targets_.push_back(inputs.view.points().on_mesh[i]);
  const Progress progress(fmt::format("light by its way at {} points", chosen_.size()), 1);
  const KeptValues& shared = inputs.truths.shared();
  if (shared.are_kept()) content_ = content();
  const CachedLayer splits =
      shared.values(content_of("split", inputs.r_max_mm), 2 * kFieldsOfPaths.size() * levels_.size() * size(),
                    [&] { return split_finely(); });
  take_splits(splits.values);
  seconds_ = splits.seconds;
}

std::string LightPathSample::content() const {
  ContentHash hash;
  append_content(hash, *inputs_.truths.geodesic(), targets_);
  for (const Vec3d& position : inputs_.scene.mesh.positions_mm) hash.append(position);
  for (const std::array<int, 3>& triangle : inputs_.scene.mesh.triangles) {
    for (const int vertex : triangle) hash.append(vertex);
  }
  for (const GaussianLevel& level : levels_) {
    hash.append(level.variance_mm2);
    hash.append(level.weight);
  }
  hash.append(inputs_.scene.largest_irradiance);
  return hash.hex();
}

std::string LightPathSample::content_of(const char* what, double r_max_mm) const {
  return fmt::format("{} {:a} {}", what, r_max_mm, content_);
}

// Both splits: of each the levels, the points, and the fields of LightPaths.
std::vector<Vec4d> LightPathSample::split_finely() {
  fine_ = split(targets_, kEdgeStdDevs);
  coarse_ = split(targets_, 2.0 * kEdgeStdDevs);
  refine();
  std::vector<Vec4d> values;
  for (const Split* of : {&fine_, &coarse_}) {
    for (const std::vector<LightPaths>& level : *of) {
      for (const LightPaths& paths : level) {
        for (const auto field : kFieldsOfPaths) values.push_back(paths.*field);
      }
    }
  }
  return values;
}

// As split_finely gives them.
void LightPathSample::take_splits(const std::vector<Vec4d>& values) {
  auto next = values.begin();
  for (Split* of : {&fine_, &coarse_}) {
    of->assign(levels_.size(), std::vector<LightPaths>(size()));
    for (std::vector<LightPaths>& level : *of) {
      for (LightPaths& paths : level) {
        for (const auto field : kFieldsOfPaths) paths.*field = *next++;
      }
    }
  }
}

// Where halving the quadrature's parts changed light that a truth may take from them by more than a third of
// what is allowed, they are halved again, a few times.
void LightPathSample::refine() {
  const double allowed = kPartsTolerance / 3.0 * inputs_.scene.largest_irradiance;
  const auto change = [&](std::size_t i) {
    Vec3d sum = Vec3d::Zero();
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      const LightPaths& a = fine_[l][i];
      const LightPaths& b = coarse_[l][i];
      const Vec4d far =
          (a.through - b.through).cwiseAbs().cwiseMax((a.transmittance - b.transmittance).cwiseAbs());
      const Vec4d all = far + (a.curvature - b.curvature).cwiseAbs();
      sum += levels_[l].weight.cwiseAbs().cwiseProduct(Vec3d(all.head<3>()));
    }
    return sum.maxCoeff();
  };
  double edge_std_devs = kEdgeStdDevs;
  for (int halved = 0; halved < kMostHalvings; ++halved) {
    std::vector<std::size_t> coarse;
    for (std::size_t i = 0; i < size(); ++i) {
      if (change(i) > allowed) coarse.push_back(i);
    }
    if (coarse.empty()) return;
    std::vector<GeodesicTarget> targets;
    for (const std::size_t i : coarse) targets.push_back(targets_[i]);
    edge_std_devs *= 0.5;
    const Split finer = split(targets, edge_std_devs);
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      for (std::size_t i = 0; i < coarse.size(); ++i) {
        coarse_[l][coarse[i]] = fine_[l][coarse[i]];
        fine_[l][coarse[i]] = finer[l][i];
      }
    }
  }
}

LightPathSample::Split LightPathSample::split(const std::vector<GeodesicTarget>& targets,
                                              double edge_std_devs) const {
  std::vector<double> std_devs_mm;
  for (const GaussianLevel& level : levels_) std_devs_mm.push_back(level.std_dev_mm());
  return LightPathEngine(inputs_.scene.mesh, *inputs_.truths.geodesic(), edge_std_devs)
      .split(targets, std_devs_mm, inputs_.r_max_mm);
}

std::vector<TruthLayer> LightPathSample::layers(double r_max_mm) const {
  std::vector<TruthLayer> layers;
  for (const GaussianLevel& level : levels_) layers.push_back({level.std_dev_mm(), r_max_mm});
  return layers;
}

Certificate LightPathSample::audit_along_surface(const TruthValues& along, double r_max_mm) const {
  // The sample is random, and so are its first points.
  std::vector<std::uint32_t> audited(std::min(size(), kAuditedPoints));
  std::iota(audited.begin(), audited.end(), 0U);
  const std::vector<GeodesicTarget> targets(targets_.begin(),
                                            targets_.begin() + static_cast<std::ptrdiff_t>(audited.size()));
  const GeodesicSurface& surface = *inputs_.truths.geodesic();
  const TruthValues exact = inputs_.truths.shared().truth_values(
      content_of("exact", r_max_mm), levels_.size(), targets.size(), [&] {
        return GeodesicExactEngine(surface, audit_reach_std_devs(kEngineTolerance))
            .convolve(targets, layers(r_max_mm));
      });
  const AuditTerms terms{kEngineTolerance, GeodesicFastEngine(surface, kEngineTolerance).tail_bound(),
                         inputs_.scene.largest_irradiance, audited.size()};
  Certificate worst;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const Certificate one = audit(along[l], exact[l], audited, terms);
    if (!one.passed()) {
      throw_run_error(
          "the audit of the geodesic truth that light through the body is added to failed: at standard "
          "deviation {:.4g} mm the fast engine is off by {:.3g} of the largest irradiance (allowed: {:.3g}); "
          "nothing is ranked",
          levels_[l].std_dev_mm(), one.max_error, one.tolerance);
    }
    if (l == 0 || one.max_error > worst.max_error) worst = one;
  }
  return worst;
}

TruthValues LightPathSample::along_surface(double r_max_mm) const {
  return inputs_.truths.shared().truth_values(content_of("along", r_max_mm), levels_.size(), size(), [&] {
    return GeodesicFastEngine(*inputs_.truths.geodesic(), kEngineTolerance)
        .convolve(targets_, layers(r_max_mm));
  });
}

json LightPathSample::parts(const std::string& view, double tolerance) const {
  const Profile& profile = inputs_.profile;
  const ViewPoints& all = inputs_.view.points();
  json entry = {{"view", view}, {"profile", profile.name}, {"r_max_mm", inputs_.r_max_mm}};
  Vec3d weights = Vec3d::Zero();
  for (const GaussianLevel& level : levels_) weights += level.weight.cwiseAbs();

  const WeightedSum euclidean = inputs_.view.weighted_sum({&profile, OwnTarget{}});
  LightAtPoints straight;
  LightAtPoints truth;
  for (const std::uint32_t i : chosen_) {
    straight.push_back(euclidean.light[i]);
    truth.push_back(euclidean.light[i] + profile.delta_weight.cwiseProduct(all.irradiance[i]));
  }
  const double unit = rms_of(truth);
  entry["points"] = size();
  for (const NamedPart& named : kParts) {
    const LightAtPoints light = part(levels_, fine_, size(), named.of);
    const LightAtPoints change = difference(light, part(levels_, coarse_, size(), named.of));
    entry[named.name] = {{"rms", rms_of(light) / unit},
                         {"mean", mean_of(light) / unit},
                         {"quadrature_error", rms_of(change) / unit}};
  }

  const TruthValues geodesic = along_surface(std::numeric_limits<double>::infinity());
  const LightAtPoints along =
      weighted(levels_, size(), [&](std::size_t l, std::size_t i) { return geodesic[l][i]; });
  const LightAtPoints sum = part(levels_, fine_, size(), kParts[3].of);
  double largest = 0.0;
  for (std::size_t i = 0; i < size(); ++i)
    largest = std::max(largest, (sum[i] - (straight[i] - along[i])).cwiseAbs().maxCoeff());
  largest /= inputs_.scene.largest_irradiance;
  const double allowed = std::max(1.0, weights.maxCoeff()) * (kSumError + kEngineTolerance + tolerance);
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

TruthImage LightPathSample::truth(const OwnTarget& target) const {
  assert(target.transmittance && target.r_max_mm.value_or(inputs_.r_max_mm) == inputs_.r_max_mm);
  const Stopwatch watch;
  const double cut_mm = target.r_max_mm.value_or(std::numeric_limits<double>::infinity());
  const TruthValues along = along_surface(cut_mm);
  const auto local = [&](const Split& split, std::size_t l, std::size_t i) -> Vec4d {
    return target.geodesic ? along[l][i] : along[l][i] + split[l][i].curvature;
  };
  const auto value = [&](const Split& split, std::size_t i) {
    Vec3d sum = inputs_.profile.delta_weight.cwiseProduct(inputs_.view.points().irradiance[chosen_[i]]);
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      const Vec4d near = local(split, l, i);
      const double divisor = target.normalised ? near[3] : 1.0;
      const Vec4d& through = target.r_max_mm ? split[l][i].through : split[l][i].transmittance;
      Vec3d light = through.head<3>();
      if (divisor > 0.0) light += near.head<3>() / divisor;
      sum += levels_[l].weight.cwiseProduct(light);
    }
    return sum;
  };
  const ViewPoints& all = inputs_.view.points();
  std::vector<Vec3d> values(all.size(), Vec3d::Zero());
  std::vector<double> masses(all.size(), 0.0);
  Vec3d weights = Vec3d::Zero();
  double change = 0.0;
  for (std::size_t i = 0; i < size(); ++i) {
    values[chosen_[i]] = value(fine_, i);
    double& mass = masses[chosen_[i]];
    mass = std::numeric_limits<double>::infinity();
    for (std::size_t l = 0; l < levels_.size(); ++l)
      mass = std::min(mass, local(fine_, l, i)[3] / plane_mass({levels_[l].std_dev_mm(), cut_mm}));
    if (mass < kSmallMass) continue;
    change = std::max(change, (values[chosen_[i]] - value(coarse_, i)).cwiseAbs().maxCoeff());
  }
  for (const GaussianLevel& level : levels_) weights += level.weight.cwiseAbs();
  TruthImage truth;
  truth.rgb = inputs_.view.picture_of(values);
  truth.smallest_mass = inputs_.view.picture_of(masses);
  truth.certificate = audit_along_surface(along, cut_mm);
  truth.certificate.weight = std::max(1.0, weights.maxCoeff());
  truth.certificate.max_error += change / (inputs_.scene.largest_irradiance * truth.certificate.weight);
  truth.certificate.tolerance = kPartsTolerance;
  truth.certificate.tail_bound += LightPathEngine::tail_bound();
  truth.seconds = seconds_ + watch.seconds();
  return truth;
}

}  // namespace truescatter
