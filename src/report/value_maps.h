#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/image.h"

namespace truescatter {

// Linear values on 65535 levels between the least and the largest that occur, evenly spaced: what is read
// back, low + step * (code - 1), differs from what went in by at most step / 2. Code 0: no value.
struct QuantizedImage {
  int width = 0;
  int height = 0;
  double low = 0.0;
  double step = 0.0;
  std::vector<std::uint16_t> codes;  // red, then green, then blue, each row after row
};

// Every `stride`-th pixel of every `stride`-th row of an image of three channels, from (0, 0); pixels where
// `mask`, of one channel, is 0 have no value.
QuantizedImage quantized(const Image& rgb, const Image& mask, int stride);

// What is left of each code after the prediction left + above - above left of its own plane (0 beyond the
// edge), modulo 2^16, with the sign in the lowest bit: small numbers where the image is smooth. All low
// bytes, then all high ones, deflated (RFC 1950). Throws Error (run) where memory runs out.
std::string packed(const QuantizedImage& image);

// The values behind the pictures that a results.json names: its truths' (where they are measured, mass at
// least one half) and its runs' (where there is skin), in units of the irradiance.
// {"stride": n, "maps": {exr path: {"width", "height", "low", "step", "data": base 64 of packed()}},
// "missing": [paths]}. Values take at most `max_bytes` of base 64: where they take more, `stride` grows
// from 1. A file that is not there is listed; one that is broken or lies outside of `folder` is an Error
// (input).
nlohmann::json embedded_values(const std::filesystem::path& folder, const nlohmann::json& results,
                               std::size_t max_bytes);

}  // namespace truescatter
