#include "metrics/error_stats.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace truescatter {

double quantile(const std::vector<double>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

std::string_view name_of(Quantity quantity) {
  static constexpr std::array<std::string_view, 4> kNames = {"luminance", "r", "g", "b"};
  return kNames[static_cast<std::size_t>(quantity)];
}

double value_of(const Image& image, int x, int y, Quantity quantity) {
  if (quantity == Quantity::luminance) return luminance(image.rgb(x, y));
  return static_cast<double>(image.at(x, y, static_cast<int>(quantity) - 1));
}

ErrorStats error_stats(const Image& test, const Image& truth, const Image& mask, Quantity quantity) {
  assert(test.width() == truth.width() && test.height() == truth.height());
  assert(mask.width() == truth.width() && mask.height() == truth.height());
  std::vector<double> magnitudes;
  double sum = 0.0;
  double sum_squares = 0.0;
  double truth_squares = 0.0;
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x) {
      if (mask.at(x, y, 0) == 0.0F) continue;
      const double reference = value_of(truth, x, y, quantity);
      const double error = value_of(test, x, y, quantity) - reference;
      sum += error;
      sum_squares += error * error;
      truth_squares += reference * reference;
      magnitudes.push_back(std::abs(error));
    }
  }
  ErrorStats stats;
  stats.pixels = magnitudes.size();
  if (magnitudes.empty()) {
    stats.bias = stats.mae = stats.rmse = stats.rel_rmse = stats.p50 = stats.p95 = stats.p99 = stats.max =
        kNan;
    return stats;
  }
  const auto n = static_cast<double>(magnitudes.size());
  double sum_magnitudes = 0.0;
  for (const double magnitude : magnitudes) sum_magnitudes += magnitude;
  std::sort(magnitudes.begin(), magnitudes.end());
  stats.bias = sum / n;
  stats.mae = sum_magnitudes / n;
  stats.rmse = std::sqrt(sum_squares / n);
  stats.rel_rmse = truth_squares > 0.0 ? std::sqrt(sum_squares / truth_squares) : kNan;
  stats.p50 = quantile(magnitudes, 0.50);
  stats.p95 = quantile(magnitudes, 0.95);
  stats.p99 = quantile(magnitudes, 0.99);
  stats.max = magnitudes.back();
  return stats;
}

Image signed_error(const Image& test, const Image& truth, const Image& mask) {
  Image error(truth.width(), truth.height(), 3);
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x) {
      if (mask.at(x, y, 0) != 0.0F) error.set_rgb(x, y, test.rgb(x, y) - truth.rgb(x, y));
    }
  }
  return error;
}

}  // namespace truescatter
