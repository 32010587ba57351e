#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/image.h"
#include "experiment/audit_sample.h"
#include "experiment/layer_source.h"
#include "experiment/scene_setup.h"
#include "experiment/view_points.h"
#include "methods/frame.h"
#include "methods/method.h"
#include "profile/profile.h"
#include "truth/audit.h"

namespace truescatter {

// Those of the pixels that are measured: where the smallest mass (TruthImage) is at least kSmallMass.
Image measured_mask(Image mask, const Image& smallest_mass);

// The layer's mass on a plane.
double plane_mass(const TruthLayer& layer);

// The layer that a Gaussian of this target is computed as. A cut that removes less than a hundredth of the
// tolerance is no cut: the layer is shared.
TruthLayer truth_layer(double variance_mm2, const OwnTarget& target, double tolerance);

// What a truth aims at: the headline (Euclidean, normalised, not cut), or another target.
struct TruthImage {
  Image rgb;  // 0 off the skin
  // One channel: the smallest mass of a Gaussian with weight, as a share of what a plane would have (1, or
  // less where the Gaussian is cut off); 0 off the skin.
  Image smallest_mass;
  // One channel, for a truth of the visible surface only, else empty: in units of the largest irradiance, how
  // far the value may be from that of exactly what is seen (VisibleSurface::unsure).
  Image visibility_bound;
  Certificate certificate;  // over the layers that it is made of
  double seconds = 0.0;     // that computing them took, whenever that was
  bool cached = false;      // all of them were there from an earlier run
};

// A profile's Gaussians summed, at every point of a view.
struct WeightedSum {
  std::vector<Vec3d> light;  // sum_i w_i M_i
  std::vector<Vec3d> mass;   // sum_i w_i m_i, per channel
  Certificate certificate;   // over the layers; its weight is that of this sum
  double seconds = 0.0;      // as in TruthImage
  bool cached = false;
};

// The convolutions behind every truth of one view: all layers that profiles and targets need, each once.
class ViewTruth {
 public:
  // Finds the skin pixels' surface points. Scene and images outlive it.
  ViewTruth(const PreparedScene& scene, const FrameImages& images);

  const ViewPoints& points() const { return points_; }

  struct Request {
    const Profile* profile;
    OwnTarget target;
  };
  using SourceOf = std::function<std::unique_ptr<LayerSource>(LayerKind, const ViewPoints&)>;

  // Computes and audits the layers of these targets; there is at least one point. `geodesic`: null if no
  // target is. What comes from a cache is audited as well, which costs little and leaves nothing to be
  // believed; if it fails, all layers of its kind are computed afresh. Throws Error (run) if an audit fails.
  void compute(const std::vector<Request>& requests, const TruthSpec& spec, const SourceOf& source_of,
               const GeodesicSurface* geodesic);
  // The truth image of a request that `compute` was given.
  TruthImage image(const Request& request) const;
  // The raw sum of a request that `compute` was given, without the profile's delta.
  WeightedSum weighted_sum(const Request& request) const;
  // One channel: a value for each point; 0 off the skin.
  Image picture_of(const std::vector<double>& values) const;
  // Three channels.
  Image picture_of(const std::vector<Vec3d>& values) const;
  // How many points were audited for which reason; the same ones for every truth.
  const AuditSample& audited() const { return sample_; }

 private:
  struct LayerResult {
    LayerKind kind;
    TruthLayer layer;
    ComputedLayer computed;
    Certificate certificate;
  };

  using Wanted = std::vector<std::pair<LayerKind, std::vector<TruthLayer>>>;

  // What a sum over layers takes from each of them.
  struct Tally {
    Certificate certificate;
    Vec3d weights = Vec3d::Zero();
    double seconds = 0.0;
    bool cached = true;

    void add(const LayerResult& result, const Vec3d& weight);
  };

  Wanted wanted_layers(const std::vector<Request>& requests) const;
  // To nothing where all of them are kept.
  static CacheClaim claim_of(const Wanted& wanted, const std::vector<std::unique_ptr<LayerSource>>& sources);
  std::vector<double> visibility_bounds(const Request& request) const;
  TruthLayer layer_of(double variance_mm2, const OwnTarget& target) const {
    return truth_layer(variance_mm2, target, tolerance_);
  }
  std::size_t index_of(LayerKind kind, const TruthLayer& layer) const;  // in layers_
  void compute_kind(LayerKind kind, const std::vector<TruthLayer>& layers, const LayerSource& source);
  // The certificates of all layers of a kind, whose order is that of `layers`.
  std::vector<Certificate> audit_kind(LayerKind kind, const std::vector<TruthLayer>& layers,
                                      const LayerSource& source) const;
  void certify_kind(LayerKind kind, const std::vector<TruthLayer>& layers, const LayerSource& source);

  const PreparedScene& scene_;
  const FrameImages& images_;
  double tolerance_ = 0.0;
  ViewPoints points_;
  std::vector<LayerResult> layers_;
  AuditSample sample_;
};

}  // namespace truescatter
