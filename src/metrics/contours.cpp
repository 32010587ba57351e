#include "metrics/contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "metrics/distance_field.h"

namespace truescatter {
namespace {

constexpr double kPlaneFactor = 4.0;
constexpr double kMinimumGap_mm = 0.5;
Vec3d pixel_ray(const ContourInputs& in, int x, int y) {
  const double column = x + 0.5 - 0.5 * in.mask.width();
  const double row = 0.5 * in.mask.height() - (y + 0.5);
  return {column / in.focal_px, row / in.focal_px, -1.0};
}

// The change of depth from a pixel to its neighbour if the facet went on; infinite where it never meets the
// neighbour's ray in front of the camera.
double predicted_step_mm(const ContourInputs& in, int x, int y, int nx, int ny) {
  const Vec3d position = in.position.rgb(x, y);
  const Vec3d normal = in.face_normal.rgb(x, y);
  const double along = normal.dot(pixel_ray(in, nx, ny));
  const double depth = normal.dot(position) / along;
  if (!std::isfinite(depth) || depth <= 0.0) return kInfinity;
  return std::abs(depth + position.z());
}

bool separated(const ContourInputs& in, int x, int y, int nx, int ny) {
  const double gap_mm = std::abs(static_cast<double>(in.position.at(x, y, 2)) - in.position.at(nx, ny, 2));
  if (gap_mm <= kMinimumGap_mm) return false;
  const double step_mm = std::max(predicted_step_mm(in, x, y, nx, ny), predicted_step_mm(in, nx, ny, x, y));
  return gap_mm > kPlaneFactor * step_mm;
}

struct Neighbourhood {
  ContourClass contour = ContourClass::none;
  bool mask_edge = false;
};

Neighbourhood classify(const ContourInputs& in, int x, int y) {
  static constexpr std::array<std::array<int, 2>, 4> kSteps = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
  Neighbourhood result;
  for (const auto& step : kSteps) {
    const int nx = x + step[0];
    const int ny = y + step[1];
    if (nx < 0 || ny < 0 || nx >= in.mask.width() || ny >= in.mask.height()) continue;
    if (in.position.at(nx, ny, 2) == 0.0F) {
      result.contour = ContourClass::outer;
    } else if (separated(in, x, y, nx, ny)) {
      const bool nearer = in.position.at(x, y, 2) > in.position.at(nx, ny, 2);
      // A pixel with both kinds of neighbour counts as the rarer and worse one: outer over near over far.
      if (nearer && result.contour != ContourClass::outer) result.contour = ContourClass::inner_near;
      if (!nearer && result.contour == ContourClass::none) result.contour = ContourClass::inner_far;
    } else if (in.mask.at(nx, ny, 0) == 0.0F) {
      result.mask_edge = true;
    }
  }
  return result;
}

}  // namespace

ContourMap find_contours(const ContourInputs& inputs) {
  ContourMap map;
  map.width = inputs.mask.width();
  map.height = inputs.mask.height();
  const std::size_t count = inputs.mask.pixel_count();
  map.contour.assign(count, ContourClass::none);
  map.mask_edge.assign(count, 0);
  map.nearest.assign(count, ContourClass::none);
  map.delta_mm.assign(count, kInfinity);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (inputs.mask.at(x, y, 0) == 0.0F) continue;
      const Neighbourhood found = classify(inputs, x, y);
      map.contour[map.index(x, y)] = found.contour;
      map.mask_edge[map.index(x, y)] = found.mask_edge ? 1 : 0;
    }
  }
  std::vector<char> flagged(count, 0);
  std::transform(map.contour.begin(), map.contour.end(), flagged.begin(),
                 [](ContourClass contour) { return contour != ContourClass::none ? 1 : 0; });
  const DistanceField field = distance_to(flagged, map.width, map.height);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = map.index(x, y);
      if (inputs.mask.at(x, y, 0) == 0.0F || !std::isfinite(field.squared_px[i])) continue;
      map.nearest[i] = map.contour[field.nearest[i]];
      map.delta_mm[i] = std::sqrt(field.squared_px[i]) * -static_cast<double>(inputs.position.at(x, y, 2)) /
                        inputs.focal_px;
    }
  }
  return map;
}

}  // namespace truescatter
