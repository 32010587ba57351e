#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiment/scene_setup.h"
#include "experiment/scene_truths.h"
#include "experiment/view_points.h"
#include "experiment/view_truth.h"
#include "profile/profile.h"
#include "truth/light_paths.h"

namespace truescatter {

// What LightPaths are sampled from in one view under one profile.
struct LightPathInputs {
  const PreparedScene& scene;
  const SceneTruths& truths;  // with geodesics
  const ViewTruth& view;      // computed
  const Profile& profile;
  double r_max_mm;  // parts near from far along the surface
  std::size_t points;
  std::uint64_t seed;
};

// LightPaths at pixels of a view drawn without repetition: a sample, for geodesics and rays cost some
// milliseconds a pixel. The parts of an experiment compute them once (SceneTruths::shared).
class LightPathSample {
 public:
  // What the inputs refer to outlives it. The mesh carries geodesics.
  explicit LightPathSample(const LightPathInputs& inputs);

  // Of transmittance, air, curvature, their sum and what lies beyond r_max along the surface: RMS and mean
  // over the pixels, relative to the RMS of the raw Euclidean truth there; raw sums over the profile's
  // Gaussians, of luminance. `quadrature_error`: of each part, the RMS of its change as the quadrature's
  // parts are made twice as coarse, likewise relative. `sum_check`: the largest difference between the sum
  // and Euclidean less geodesic truth by their fast engines, in units of the largest irradiance, and what the
  // engines (the Euclidean one to `tolerance`) and the quadrature allow. Throws Error (run) where the sum
  // differs by more.
  nlohmann::json parts(const std::string& view, double tolerance) const;

  // The truth of a target with transmittance, whose r_max is the sample's, or none; 0 off the sampled pixels,
  // and so is the mass. With w_0 the profile's delta, G_i its Gaussians of weight w_i, d along the surface
  // and |x| straight:
  //
  //   w_0 I + sum w_i (L_i / l_i + T_i)
  //   L_i   Euclidean target: integral of G_i(|x|) I over d <= r_max, and of G_i(d) I beyond if it is not cut
  //         off; geodesic target: integral of G_i(d) I, likewise; l_i the same of I = 1, or 1 if it is raw
  //   T_i   integral of G_i(|x|) I over d > r_max, the straight way inside the body; not cut off: of
  //         (G_i(|x|) - G_i(d)) I, for L_i has G_i(d) I already
  //
  // L_i is the fast geodesic engine's, to kEngineTolerance, with LightPaths' curvature for Euclidean targets.
  // The certificate's `audited` points, random ones, were compared with the exact geodesic engine; its
  // `max_error` is the largest difference there and the largest change of a value, at any point, as the
  // quadrature's parts are made twice as coarse. It has not passed where that exceeds kPartsTolerance; such a
  // truth says nothing of methods. Throws Error (run) where the audit fails.
  TruthImage truth(const OwnTarget& target) const;

  std::size_t size() const { return chosen_.size(); }

 private:
  using Split = std::vector<std::vector<LightPaths>>;  // [level][point]

  std::string content() const;
  std::string content_of(const char* what, double r_max_mm) const;
  std::vector<Vec4d> split_finely();
  void take_splits(const std::vector<Vec4d>& values);
  Split split(const std::vector<GeodesicTarget>& targets, double edge_std_devs) const;
  void refine();
  std::vector<TruthLayer> layers(double r_max_mm) const;
  TruthValues along_surface(double r_max_mm) const;  // [level][point]
  Certificate audit_along_surface(const TruthValues& along, double r_max_mm) const;

  LightPathInputs inputs_;
  std::vector<GaussianLevel> levels_;
  std::vector<std::uint32_t> chosen_;  // of the view's points
  std::vector<GeodesicTarget> targets_;
  Split fine_;
  Split coarse_;
  std::string content_;   // a hash of what all of this depends on; empty where nothing is shared
  double seconds_ = 0.0;  // that the splits took
};

}  // namespace truescatter
