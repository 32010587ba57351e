#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/image.h"
#include "metrics/contours.h"
#include "metrics/flip.h"
#include "metrics/halo.h"
#include "metrics/leak.h"
#include "metrics/seam.h"

namespace truescatter {

// Sets object[key], or null and object[key + "_reason"] where the value is not finite: NaN never reaches a
// JSON.
void put_number(nlohmann::json& object, const std::string& key, double value, const std::string& reason);

// A picture times a factor.
Image exposed(const Image& image, double exposure);

// What a picture is measured against.
struct MetricInputs {
  const Image& truth;
  const Image& mask;  // the pixels that count
  const ContourMap& contours;
  double widest_std_dev_mm;
  double mm_per_px;
  const FlipReference& flip;         // of exposed(truth, exposure)
  double exposure;                   // for FLIP: what turns the brightest irradiance into the display's white
  const HdrFlipReference& flip_hdr;  // of truth; needs no exposure
  const UvView* uv = nullptr;        // for seam and stretch; null: not asked for
};

// The `metrics` object of results.json: luminance at the top, r, g, b under `channels` (README, Commands).
nlohmann::json metrics_json(const Image& test, const MetricInputs& inputs);

// The `leak` object: energy, peak, and by_surface[] {component, pixels, energy, peak}, each of what leaves
// that surface when it is the only one lit.
nlohmann::json leak_json(const std::vector<LitAlone>& surfaces, double largest_irradiance);

// The error statistics alone: what `compare` prints, and what own targets carry.
nlohmann::json error_stats_json(const Image& test, const Image& truth, const Image& mask);

// The `visible` object: FLIP between composites, {mean, p95, above_005, above_01} (visible_difference).
nlohmann::json visible_json(const Image& flip_map, const Image& mask);

// The halo of two pictures of which nothing but the skin's mask is known: beside its outer contour alone, and
// in pixels, for the widest standard deviation `std_dev_px`. {peak, width_px, energy, contrast, pixels,
// profile: {bin_px, relative_error, pixels}} of luminance, and of r, g, b under `channels`.
nlohmann::json mask_halo_json(const Image& test, const Image& truth, const Image& mask, double std_dev_px);

}  // namespace truescatter
