#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "core/image.h"

namespace truescatter {

// The quantities that a metric may be taken of, in the order of the arrays below.
enum class Quantity { luminance, red, green, blue };
inline constexpr std::array<Quantity, 4> kQuantities = {Quantity::luminance, Quantity::red, Quantity::green,
                                                        Quantity::blue};
std::string_view name_of(Quantity quantity);
// The quantity of one pixel of an RGB image.
double value_of(const Image& image, int x, int y, Quantity quantity);

// Errors of `test` against `truth` over n pixels, e_i = test_i - truth_i. Quantiles are of |e| (nearest rank:
// the smallest value that at least the share q of the pixels does not exceed).
struct ErrorStats {
  std::size_t pixels = 0;
  double bias = 0.0;      // (1/n) sum e
  double mae = 0.0;       // (1/n) sum |e|
  double rmse = 0.0;      // sqrt((1/n) sum e^2)
  double rel_rmse = 0.0;  // rmse / sqrt((1/n) sum truth^2); NaN where the truth is 0 everywhere
  double p50 = 0.0;
  double p95 = 0.0;
  double p99 = 0.0;
  double max = 0.0;  // largest |e|
};

// Over the pixels where `mask` (one channel) is not 0. All images have one size; test and truth have at least
// three channels. Without a pixel every value is NaN.
ErrorStats error_stats(const Image& test, const Image& truth, const Image& mask, Quantity quantity);

// The smallest of some values, ascending and not none, that at least the share of them does not exceed.
double quantile(const std::vector<double>& sorted, double share);

// test - truth per channel inside the mask, 0 outside.
Image signed_error(const Image& test, const Image& truth, const Image& mask);

}  // namespace truescatter
