#include "experiment/metrics_json.h"

#include <cmath>

#include "metrics/error_stats.h"
#include "metrics/flip.h"

namespace truescatter {
namespace {

using nlohmann::json;

void put_error_stats(json& object, const ErrorStats& stats) {
  const std::string empty = "no pixel to measure";
  object["pixels"] = stats.pixels;
  put_number(object, "bias", stats.bias, empty);
  put_number(object, "mae", stats.mae, empty);
  put_number(object, "rmse", stats.rmse, empty);
  put_number(object, "rel_rmse", stats.rel_rmse, stats.pixels == 0 ? empty : "the truth is 0 at every pixel");
  put_number(object, "p50", stats.p50, empty);
  put_number(object, "p95", stats.p95, empty);
  put_number(object, "p99", stats.p99, empty);
  put_number(object, "max", stats.max, empty);
}

// `none`: the reason where there is no such line. `unit`: of the distances.
json halo_json(const Halo& halo, const std::string& none, const std::string& unit = "mm") {
  json object;
  object["pixels"] = halo.pixels;
  put_number(object, "peak", halo.peak, none);
  put_number(object, "width_" + unit, halo.width_mm,
             std::isfinite(halo.peak) ? "the error stays above 1 % up to 6 s" : none);
  put_number(object, "energy", halo.energy, none);
  put_number(object, "contrast", halo.contrast,
             std::isfinite(halo.energy) ? "no error, or no pixel, beyond 6 s" : none);
  json errors = json::array();
  for (const double e : halo.profile.relative_error) errors.push_back(std::isfinite(e) ? json(e) : json());
  object["profile"] = {
      {"bin_" + unit, halo.profile.bin_mm}, {"relative_error", errors}, {"pixels", halo.profile.pixels}};
  return object;
}

json all_halos_json(const Image& test, const MetricInputs& in, Quantity quantity) {
  const auto measure = [&](HaloSide side) {
    return halo_json(measure_halo(test, in.truth, in.mask, in.contours, in.widest_std_dev_mm, in.mm_per_px,
                                  quantity, side),
                     "no silhouette of this kind with light beside it");
  };
  json halo = measure(HaloSide::all);
  halo["outer"] = {{"near", measure(HaloSide::outer)}};
  halo["inner"] = {{"near", measure(HaloSide::inner_near)}, {"far", measure(HaloSide::inner_far)}};
  return halo;
}

json stretch_json(const std::vector<StretchBin>& bins) {
  json list = json::array();
  for (const StretchBin& bin : bins) {
    json object = {{"from", bin.from}, {"pixels", bin.pixels}};
    put_number(object, "to", bin.to, "no bound");
    put_number(object, "bias", bin.bias, "no pixel to measure");
    put_number(object, "rel_rmse", bin.rel_rmse,
               bin.pixels == 0 ? "no pixel to measure" : "the truth is 0 at every pixel");
    list.push_back(object);
  }
  return list;
}

json seam_json(const Image& test, const MetricInputs& in, Quantity quantity) {
  json seam = halo_json(measure_band(test, in.truth, in.mask, {in.uv->seam_delta_mm, {}},
                                     in.widest_std_dev_mm, in.mm_per_px, quantity),
                        "no UV seam in view with light beside it");
  seam["stretch"] = stretch_json(measure_stretch(test, in.truth, in.mask, in.uv->anisotropy, quantity));
  return seam;
}

json leak_numbers(const std::vector<LitAlone>& surfaces, double largest_irradiance) {
  const Leak leak = total_leak(surfaces, largest_irradiance);
  json object;
  put_number(object, "energy", leak.energy, "no light leaves the lit surface towards the view");
  put_number(object, "peak", leak.peak, "no surface to light");
  return object;
}

}  // namespace

Image exposed(const Image& image, double exposure) {
  Image result = image;
  for (float& v : result.data()) v *= static_cast<float>(exposure);
  return result;
}

void put_number(json& object, const std::string& key, double value, const std::string& reason) {
  if (std::isfinite(value)) {
    object[key] = value;
  } else {
    object[key] = nullptr;
    object[key + "_reason"] = reason;
  }
}

json error_stats_json(const Image& test, const Image& truth, const Image& mask) {
  json metrics;
  put_error_stats(metrics, error_stats(test, truth, mask, Quantity::luminance));
  for (const Quantity quantity : {Quantity::red, Quantity::green, Quantity::blue}) {
    put_error_stats(metrics["channels"][std::string(name_of(quantity))],
                    error_stats(test, truth, mask, quantity));
  }
  return metrics;
}

json leak_json(const std::vector<LitAlone>& surfaces, double largest_irradiance) {
  json object = leak_numbers(surfaces, largest_irradiance);
  object["by_surface"] = json::array();
  for (const LitAlone& surface : surfaces) {
    json part = leak_numbers({surface}, largest_irradiance);
    part["component"] = surface.component;
    part["pixels"] = surface.pixels;
    object["by_surface"].push_back(part);
  }
  return object;
}

json visible_json(const Image& flip_map, const Image& mask) {
  const VisibleDifference difference = visible_difference(flip_map, mask);
  const std::string empty = "no pixel to measure";
  json object;
  put_number(object, "mean", difference.mean, empty);
  put_number(object, "p95", difference.p95, empty);
  put_number(object, "above_005", difference.above_005, empty);
  put_number(object, "above_01", difference.above_01, empty);
  return object;
}

json mask_halo_json(const Image& test, const Image& truth, const Image& mask, double std_dev_px) {
  // Facing skin at depth 1 before nothing, under a focal length of 1: distances come back in pixels.
  Image position(mask.width(), mask.height(), 3);
  Image face_normal(mask.width(), mask.height(), 3);
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      face_normal.set_rgb(x, y, Vec3d::UnitZ());
      if (mask.at(x, y, 0) != 0.0F) position.set_rgb(x, y, -Vec3d::UnitZ());
    }
  }
  const ContourMap contours = find_contours({mask, position, face_normal, 1.0});
  const auto measured = [&](Quantity quantity) {
    return halo_json(measure_halo(test, truth, mask, contours, std_dev_px, 1.0, quantity, HaloSide::outer),
                     "the mask has no edge within the picture with light beside it", "px");
  };
  json halo = measured(Quantity::luminance);
  for (const Quantity quantity : {Quantity::red, Quantity::green, Quantity::blue})
    halo["channels"][std::string(name_of(quantity))] = measured(quantity);
  return halo;
}

json metrics_json(const Image& test, const MetricInputs& inputs) {
  json metrics = error_stats_json(test, inputs.truth, inputs.mask);
  metrics["halo"] = all_halos_json(test, inputs, Quantity::luminance);
  for (const Quantity quantity : {Quantity::red, Quantity::green, Quantity::blue}) {
    metrics["channels"][std::string(name_of(quantity))]["halo"] = all_halos_json(test, inputs, quantity);
  }
  if (inputs.uv != nullptr) {
    metrics["seam"] = seam_json(test, inputs, Quantity::luminance);
    for (const Quantity quantity : {Quantity::red, Quantity::green, Quantity::blue})
      metrics["channels"][std::string(name_of(quantity))]["seam"] = seam_json(test, inputs, quantity);
  }
  const Image flip = inputs.flip.map(exposed(test, inputs.exposure));
  put_number(metrics, "flip", mean_inside(flip, inputs.mask), "no pixel to measure");
  put_number(metrics, "flip_hdr", mean_inside(inputs.flip_hdr.map(test), inputs.mask), "no pixel to measure");
  return metrics;
}

}  // namespace truescatter
