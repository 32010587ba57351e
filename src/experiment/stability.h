#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/view_runner.h"
#include "scene/camera.h"

namespace truescatter {

// True convolution depends on the surface alone, not on the viewer. So the error of a method at a point of
// the surface is followed through views that are derived from one (README, Definitions):
//   orbit   the eye turned about the view's `up` through its target: what changes is view dependence
//   dolly   the eye at other distances from the target
//   jitter  the image plane shifted by less than half a pixel; what changes here, and in a dolly, flickers
// In every one of them, the pixel that sees the point has the method's value, and the truth of its own
// surface point: their difference is the error there.
struct DerivedViews {
  std::string kind;
  std::vector<Camera> cameras;
};

// Those that are asked for, in the order above. An orbit of n views over a degrees turns by
// -a/2 + i a/(n - 1), a full turn by i 360/n; shifts are Halton's points of bases 2 and 3, less a half.
std::vector<DerivedViews> derived_views(const ViewSpec& view, const StabilitySpec& spec);

// A point of the surface that is followed.
struct FollowedPoint {
  Vec3d position_mm;
  Vec3d normal;  // its face's
  int component;
};

// The pixel of a view that sees a point.
struct SeenPoint {
  std::size_t point;
  int x;
  int y;
};

// Which points a view sees, and where. A pixel sees the point that projects into it if it shows skin of the
// same component and side and one of the two faces' planes carries both points, to half the pixel's width
// there.
std::vector<SeenPoint> seen_points(const std::vector<FollowedPoint>& points, const PreparedScene& scene,
                                   const FrameImages& images, const Camera& camera);

// Does it for one view. `runs`: of every profile and method, `metrics.stability.{orbit,dolly,jitter}`, which
// its run is to be given; `stability`: what was done, an entry for each kind. In units of the
// largest irradiance: RMS, 95 % quantile and maximum over the points of the spread of a point's error
// (ErrorSpread); relative ones are over the RMS of the truth at the same pixels. The truths of derived views
// are computed and audited as any other, where a sample of points is followed at their pixels alone. Throws
// Error (run) for a failed audit or the driver.
nlohmann::json measure_stability(const Setup& setup, const ViewSpec& view);

}  // namespace truescatter
