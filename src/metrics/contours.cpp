#include "metrics/contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace truescatter {
namespace {

constexpr double kPlaneFactor = 4.0;
constexpr double kMinimumGap_mm = 0.5;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

// The lower envelope of parabolas (Felzenszwalb & Huttenlocher 2012): exact squared distances along one line.
void transform_line(std::vector<double>& f, std::vector<std::size_t>& source) {
  const std::size_t n = f.size();
  std::vector<std::size_t> v(n);
  std::vector<double> z(n + 1);
  std::size_t k = 0;
  bool any = false;
  for (std::size_t q = 0; q < n; ++q) {
    if (!std::isfinite(f[q])) continue;
    const auto dq = static_cast<double>(q);
    if (!any) {
      v[0] = q;
      z[0] = -kInfinity;
      z[1] = kInfinity;
      any = true;
      continue;
    }
    double s = 0.0;
    for (;;) {
      const auto dv = static_cast<double>(v[k]);
      s = ((f[q] + dq * dq) - (f[v[k]] + dv * dv)) / (2.0 * (dq - dv));
      if (s > z[k] || k == 0) break;
      --k;
    }
    if (s <= z[k]) {
      v[k] = q;
    } else {
      v[++k] = q;
      z[k] = s;
    }
    z[k + 1] = kInfinity;
  }
  if (!any) return;
  std::vector<double> result(n);
  std::vector<std::size_t> from(n);
  k = 0;
  for (std::size_t q = 0; q < n; ++q) {
    while (z[k + 1] < static_cast<double>(q)) ++k;
    const double d = static_cast<double>(q) - static_cast<double>(v[k]);
    result[q] = d * d + f[v[k]];
    from[q] = source[v[k]];
  }
  f = std::move(result);
  source = std::move(from);
}

// For every pixel, the squared distance in pixels to the nearest contour pixel, and which one it is.
struct DistanceField {
  std::vector<double> squared;
  std::vector<std::size_t> nearest;
};

DistanceField distance_to_contours(const ContourMap& map) {
  const auto width = static_cast<std::size_t>(map.width);
  const auto height = static_cast<std::size_t>(map.height);
  DistanceField field{std::vector<double>(width * height, kInfinity),
                      std::vector<std::size_t>(width * height)};
  for (std::size_t i = 0; i < width * height; ++i) {
    field.nearest[i] = i;
    if (map.contour[i] != ContourClass::none) field.squared[i] = 0.0;
  }
  const auto along = [&](std::size_t first, std::size_t stride, std::size_t count) {
    std::vector<double> f(count);
    std::vector<std::size_t> source(count);
    for (std::size_t i = 0; i < count; ++i) {
      f[i] = field.squared[first + i * stride];
      source[i] = field.nearest[first + i * stride];
    }
    transform_line(f, source);
    for (std::size_t i = 0; i < count; ++i) {
      field.squared[first + i * stride] = f[i];
      field.nearest[first + i * stride] = source[i];
    }
  };
  for (std::size_t x = 0; x < width; ++x) along(x, width, height);
  for (std::size_t y = 0; y < height; ++y) along(y * width, 1, width);
  return field;
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
  const DistanceField field = distance_to_contours(map);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = map.index(x, y);
      if (inputs.mask.at(x, y, 0) == 0.0F || !std::isfinite(field.squared[i])) continue;
      map.nearest[i] = map.contour[field.nearest[i]];
      map.delta_mm[i] =
          std::sqrt(field.squared[i]) * -static_cast<double>(inputs.position.at(x, y, 2)) / inputs.focal_px;
    }
  }
  return map;
}

}  // namespace truescatter
