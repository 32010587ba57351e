#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "experiment/scene_setup.h"
#include "methods/frame.h"
#include "methods/method.h"
#include "profile/profile.h"
#include "truth/audit.h"
#include "truth/fast.h"

namespace truescatter {

// What a truth aims at: the headline (Euclidean, normalised, not cut), or a method's own target.
struct TruthImage {
  Image rgb;                // 0 off the skin
  Image smallest_mass;      // one channel: the smallest mass of a Gaussian with weight; 0 off the skin
  Certificate certificate;  // over the layers that it is made of
  double seconds = 0.0;
};

// The convolutions behind every truth of one view: all layers that profiles and targets need, each once.
class ViewTruth {
 public:
  // Finds the skin pixels' surface points.
  ViewTruth(const PreparedScene& scene, const Surface& surface, const FrameImages& images);

  std::size_t point_count() const { return points_.size(); }
  // Computes and audits the layers of these targets.
  struct Request {
    const Profile* profile;
    OwnTarget target;
  };
  void compute(const std::vector<Request>& requests, const TruthSpec& spec, const FastEngine& engine);
  // The truth image of a request that `compute` was given. Geodesic targets are not among them.
  TruthImage image(const Request& request) const;

 private:
  struct Pixel {
    int x;
    int y;
  };
  struct LayerResult {
    TruthLayer layer;
    std::vector<Vec4d> values;
    Certificate certificate;
    double seconds;
  };

  TruthLayer layer_of(double variance_mm2, const OwnTarget& target) const;
  const LayerResult& result_of(const TruthLayer& layer) const;
  std::vector<std::uint32_t> audited_points(const TruthSpec& spec) const;

  const Surface& surface_;
  const FrameImages& images_;
  double tolerance_ = 0.0;
  std::vector<Pixel> pixels_;
  std::vector<SurfacePoint> points_;
  std::vector<Vec3d> irradiance_;  // at the points
  std::vector<double> contrast_;   // of irradiance, over the point's shading triangle
  std::vector<LayerResult> layers_;
};

}  // namespace truescatter
