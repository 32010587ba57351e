#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "config/experiment_spec.h"
#include "experiment/memory_estimate.h"
#include "gpu/context.h"
#include "truth/cache.h"

namespace truescatter {

// How parts of the model are measured.
struct NeedOptions {
  gpu::Backend gl = gpu::Backend::osmesa;
  int frame_px = 96;              // longer side of the frames that are drawn for it
  std::size_t light_paths = 512;  // pixels at which light is split by its way
  TruthCache* cache = nullptr;
  std::uint64_t memory_limit_bytes = default_memory_limit();
};

// What each part of the model is worth in each view under each profile of an experiment (of several sizes of
// one camera's frame the largest, of several sums of Gaussians for one diffusion profile that of the most),
// which is an array of
//
//   view, profile, width_px, height_px   of the frame that it was measured in
//   gaussians[]    by width: std_dev_mm, std_dev_px (at the view's own size and median depth, of the
//                  camera's focal length: s f / z), below_pixel (less than half a one), and
//                  difference: of the truth with this Gaussian and all narrower ones left unblurred
//   layers         difference: of cbf-unnormalised with one layer from that with two
//   shadows        difference: of the irradiance without shadows and occlusion from that with them
//   geodesics      difference: of the geodesic truth from the Euclidean one
//   transmittance  difference: what comes through the body beyond r_max along the surface; beside it
//                  quadrature_error and points (see LightPathSample)
//
// A difference is the RMS over skin pixels of that of luminance, over the RMS of the latter: the headline
// truth's for Gaussians and geodesics, the raw one's for transmittance. Null with a `reason` where there is
// none. Throws Error as run_experiment does.
nlohmann::json scene_needs(const ExperimentSpec& spec, const NeedOptions& options);

}  // namespace truescatter
