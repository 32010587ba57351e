#include "experiment/piece_cost.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <string>

#include "experiment/scene_setup.h"

namespace truescatter {
namespace {

// Measured with the pieces of quickstart.toml, Euclidean audits included; geodesics, light paths and derived
// views by README, Speed, and the time of small runs.
constexpr double kPointsPerSecond = 0.35e6;  // of a Gaussian, Euclidean
constexpr double kGeodesicPointsPerSecond = 0.02e6;
constexpr double kGeodesicAudit = 0.014;    // a point and Gaussian, along the surface of ear.toml's head
constexpr double kSecondsPerRead = 12e-9;   // a texel that a shader reads
constexpr double kSecondsPerTexel = 30e-9;  // a pass over a map in texture space, per texel and Gaussian
constexpr double kMeasuring = 1.2e-6;       // both FLIPs, quantiles, EXR: seconds a pixel
constexpr double kSeeing = 0.8e-6;          // a composite and its FLIP
constexpr double kFrame = 1e-6;             // a frame drawn and read back
constexpr double kLightPath = 0.012;        // a point of truth.light_paths
constexpr double kDerivedViews = 1.3;       // a derived view's frames and truths, of a view's
constexpr double kWidth = 4.0;              // of a method's filter under a profile, on planes

const ViewSpec& view_of(const ExperimentSpec& spec, const std::string& name) {
  const auto found = std::find_if(spec.views.begin(), spec.views.end(),
                                  [&](const ViewSpec& view) { return view.name == name; });
  assert(found != spec.views.end());
  return *found;
}

double pixels(const ViewSpec& view) { return static_cast<double>(view.width_px) * view.height_px; }

double gaussians(const Profile& profile) { return static_cast<double>(gaussian_levels(profile).size()); }

// Reads of a frame, a pixel, or of a map, a texel.
double drawing_s(const PlannedMethod& method, const Profile& profile, const ViewSpec& view) {
  if (method.pictures != nullptr) return 0.0;
  const Settings& settings = method.settings;
  const MethodMemory& memory = method.method->memory;
  if (memory.bytes_per_pixel == 0.0 && memory.bytes_per_texel == 0.0) return 0.0;  // no pass at all
  if (memory.bytes_per_texel > 0.0) {
    const double size = settings.number("texture_size");
    return size * size * gaussians(profile) * kSecondsPerTexel + pixels(view) * kFrame;
  }
  double reads = 16.0 * gaussians(profile);
  const auto taps = settings.values().find("taps");
  if (taps != settings.values().end() && std::holds_alternative<double>(taps->second))
    reads = 2.0 * std::get<double>(taps->second) * gaussians(profile);
  if (method.method->reads_all_within_r_max) {
    const double px_mm = (view.eye_mm - view.target_mm).norm() / camera_of(view).focal_px();
    const double radius_px = profile.r_max_mm / px_mm;
    reads = std::min(60000.0, kPi * radius_px * radius_px);
  }
  return pixels(view) * (reads * kSecondsPerRead + 0.05e-6);
}

double truths_s(const ExperimentSpec& spec, const Plan& plan, const ViewSpec& view, const Profile& profile) {
  double seconds = 0.0;
  for (const PlannedTruth& truth : planned_truths(plan, true)) {
    if (truth.profile != &profile || !truth.not_computed.empty()) continue;
    if (truth.target.transmittance) {
      seconds += spec.truth.transmittance_points() * kLightPath;
    } else if (truth.target.follows_surface()) {
      seconds += gaussians(profile) *
                 (pixels(view) / kGeodesicPointsPerSecond + spec.truth.audit_points * kGeodesicAudit);
    } else {
      seconds += pixels(view) * gaussians(profile) / kPointsPerSecond;
    }
  }
  return seconds + spec.truth.light_paths * kLightPath + pixels(view) * kMeasuring;
}

double run_s(const ExperimentSpec& spec, const PlannedMethod& method, const Profile& profile,
             const ViewSpec& view) {
  const double frames = 2.0 + spec.timing.warm_up + spec.timing.repeats;
  return frames * drawing_s(method, profile, view) +
         pixels(view) * (kMeasuring + (spec.composite ? kSeeing : 0.0));
}

const Profile& profile_of(const Plan& plan, const Piece& piece) {
  const auto found = std::find_if(plan.profiles.begin(), plan.profiles.end(),
                                  [&](const Profile& profile) { return profile.name == piece.profile; });
  assert(found != plan.profiles.end());
  return *found;
}

const PlannedMethod& method_of(const Plan& plan, const Piece& piece) {
  const auto found = std::find_if(plan.methods.begin(), plan.methods.end(),
                                  [&](const PlannedMethod& method) { return method.label == piece.name; });
  assert(found != plan.methods.end());
  return *found;
}

double ladder_s(const Plan& plan, const Piece& piece, const ViewSpec& view) {
  const auto found = std::find_if(plan.ladders.begin(), plan.ladders.end(),
                                  [&](const LadderSpec& ladder) { return ladder.name == piece.name; });
  assert(found != plan.ladders.end());
  return static_cast<double>(found->rungs.size()) * pixels(view) * kMeasuring;
}

double stability_s(const ExperimentSpec& spec, const Plan& plan, const ViewSpec& view) {
  double one = pixels(view) * kFrame;
  for (const Profile& profile : plan.profiles) {
    one += pixels(view) * gaussians(profile) / kPointsPerSecond;
    for (const PlannedMethod& method : plan.methods) one += drawing_s(method, profile, view);
  }
  const StabilitySpec& asked = *spec.stability;
  const double views =
      asked.orbit_views + asked.jitter_views + static_cast<double>(asked.dolly_factors.size());
  return kDerivedViews * views * one;
}

double widths_s(const Plan& plan) {
  std::set<std::string> methods;
  for (const LadderSpec& ladder : plan.ladders) {
    for (const LadderSpec::Rung& rung : ladder.rungs) methods.insert(rung.method);
  }
  methods.erase("");
  return kWidth * static_cast<double>(methods.size() * plan.profiles.size());
}

}  // namespace

double piece_cost_s(const ExperimentSpec& spec, const Plan& plan, const Piece& piece) {
  const ViewSpec& view = view_of(spec, piece.view);
  switch (piece.kind) {
    case Piece::Kind::view:
      return pixels(view) * kFrame;
    case Piece::Kind::truth:
      return truths_s(spec, plan, view, profile_of(plan, piece));
    case Piece::Kind::run:
      return run_s(spec, method_of(plan, piece), profile_of(plan, piece), view);
    case Piece::Kind::ladder:
      return ladder_s(plan, piece, view);
    case Piece::Kind::stability:
      return stability_s(spec, plan, view);
    case Piece::Kind::widths:
      return widths_s(plan);
  }
  return 0.0;
}

}  // namespace truescatter
