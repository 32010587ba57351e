#include "metrics/distance_field.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace truescatter {
namespace {

// The lower envelope of parabolas: exact squared distances along one line, given those across it.
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

}  // namespace

DistanceField distance_to(const std::vector<char>& flagged, int width_px, int height_px) {
  const auto width = static_cast<std::size_t>(width_px);
  const auto height = static_cast<std::size_t>(height_px);
  assert(flagged.size() == width * height);
  DistanceField field{std::vector<double>(width * height, kInfinity),
                      std::vector<std::size_t>(width * height)};
  for (std::size_t i = 0; i < width * height; ++i) {
    field.nearest[i] = i;
    if (flagged[i] != 0) field.squared_px[i] = 0.0;
  }
  const auto along = [&](std::size_t first, std::size_t stride, std::size_t count) {
    std::vector<double> f(count);
    std::vector<std::size_t> source(count);
    for (std::size_t i = 0; i < count; ++i) {
      f[i] = field.squared_px[first + i * stride];
      source[i] = field.nearest[first + i * stride];
    }
    transform_line(f, source);
    for (std::size_t i = 0; i < count; ++i) {
      field.squared_px[first + i * stride] = f[i];
      field.nearest[first + i * stride] = source[i];
    }
  };
  for (std::size_t x = 0; x < width; ++x) along(x, width, height);
  for (std::size_t y = 0; y < height; ++y) along(y * width, 1, width);
  return field;
}

}  // namespace truescatter
