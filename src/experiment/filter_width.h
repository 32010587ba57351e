#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "experiment/plan.h"
#include "gpu/context.h"
#include "irradiance/shading_mesh.h"
#include "methods/frame.h"
#include "methods/method.h"
#include "profile/profile.h"

namespace truescatter {

// The variance that a method's filter has on a plane, for one Gaussian of variance v: the mean of u^2 under
// its weights, as shares of v, u being the distance along the plane. The truth's is 1; cut off at r_max it is
// 1 - x / (e^x - 1) with x = r_max^2 / 2 v.
struct FilterWidth {
  double facing = 0.0;        // the plane faces the camera
  double along_slope = 0.0;   // it is turned away by kSlopeDeg: in the direction in which it recedes
  double across_slope = 0.0;  // and perpendicular to that
};

inline constexpr double kSlopeDeg = 60.0;

// Measures it for the widest Gaussian of `profile`, of its standard deviation s and its r_max, by drawing a
// plane of 15 s with the method's own shaders under the irradiances 1 and u^2, each in a channel of one
// picture, from so far that it is parallel (2000 s): the exitance in the middle under the second over that
// under the first. A pixel there
// is 1/8 s wide; where a method reads at most 300 texels a pixel and pixels of s / 9.7 give a share that
// differs by more than 2e-3, so that it is the rounding of taps to pixels that is seen, s / 96.
//
// Error. Irradiance is linear between vertices h = s / 17.3 apart, so u^2 is too large by h^2 / 6 on average,
// which is subtracted, and by h^2 / 4 at most: 6e-4 of v for a single tap. Taps in pixels of p = s / 96
// (twice that along the slope) err by p E|u| + p^2 / 4 at most, 0.009 (0.017), if all are rounded the same
// way. Where a method's targets hold 16 bits: by 5e-4. The plane ends at 7.5 s, where 1e-11 of the variance
// is left.
class FilterWidthProbe {
 public:
  // Only of a profile with a Gaussian can anything be measured. The context outlives this. A UV unit of the
  // plane is as long as given, and at least the plane's 15 s: as many texels to a standard deviation as a
  // scene has. What is filtered in texture space is measured once, facing: slopes do not matter to it.
  FilterWidthProbe(const gpu::Context& context, const Profile& profile, double mm_per_uv_unit = 0.0);

  // Keeps the planes that it draws for the next method. Throws Error (input) as preparing the method does.
  FilterWidth measure(const Method& method, const Settings& settings);

 private:
  struct Plane {
    Plane(const gpu::Context& context, ShadingMesh lit) : mesh(std::move(lit)), buffers(context, mesh) {}
    const ShadingMesh mesh;
    const SurfaceBuffers buffers;
  };
  const Plane& plane_at(double slope_deg);
  // Along the plane's x and y.
  Vec2d shares(const Method& method, const Settings& settings, double slope_deg);

  const gpu::Context& context_;
  Profile gaussian_;  // that one alone, alike in all channels
  double std_dev_mm_;
  double mm_per_uv_unit_;
  std::map<double, Plane> planes_;  // by their slope in degrees
};

// 1 - x / (e^x - 1), x = r_max^2 / 2 v: what of a Gaussian's variance is left, normalised, where it is cut
// off.
double cut_variance_share(double variance_mm2, double r_max_mm);

// Widths that are known, by what they depend on: a sweep's scenes share most of them.
using KnownWidths = std::map<std::string, FilterWidth>;

// Of every profile and every rung of the plan's ladders, each once: `profile`, `rung` (its name) and
// `filter_width`: facing, along_slope, across_slope and slope_deg; of a truth's rung, which does not care for
// slopes, in closed form. Null where a profile has no Gaussian, where the method is pictures, and where it is
// skipped. What is measured is added to `known`.
nlohmann::json measure_filter_widths(const gpu::Context& context, const Plan& plan,
                                     const SurfaceBuffers& scene, KnownWidths& known);

}  // namespace truescatter
