#include "composite/beckmann.h"

#include <algorithm>
#include <cmath>

namespace truescatter {
namespace {

constexpr int kColumns = 2048;
constexpr int kRows = 512;
// Where n_h = 0: of the size of its neighbour's for the roughest, so that nothing is lost between the two.
constexpr double kDark = -1e7;

double log_beckmann(double n_h, double m) {
  return (1.0 - 1.0 / (n_h * n_h)) / (m * m) - std::log(kPi * m * m) - 4.0 * std::log(n_h);
}

double encode(BeckmannEncoding encoding, double n_h, double m) {
  if (encoding == BeckmannEncoding::power) return 0.5 * std::pow(beckmann(n_h, m), 0.1);
  return n_h > 0.0 ? std::max(log_beckmann(n_h, m), kDark) : kDark;
}

double decode(BeckmannEncoding encoding, double value) {
  return encoding == BeckmannEncoding::power ? std::pow(2.0 * value, 10.0) : std::exp(value);
}

double row_of(double m) {
  return std::log(m / kLeastRoughness) / std::log(kLargestRoughness / kLeastRoughness) * (kRows - 1);
}

}  // namespace

double beckmann(double n_h, double m) { return n_h > 0.0 ? std::exp(log_beckmann(n_h, m)) : 0.0; }

BeckmannTable make_beckmann_table(BeckmannEncoding encoding) {
  BeckmannTable table{encoding, Image(kColumns, kRows, 1)};
  for (int row = 0; row < kRows; ++row) {
    const double m =
        kLeastRoughness * std::pow(kLargestRoughness / kLeastRoughness, double(row) / (kRows - 1));
    for (int column = 0; column < kColumns; ++column) {
      // Row 0 of an image is a texture's last: the smoothest is uploaded to the texture's first.
      table.texels.at(column, kRows - 1 - row, 0) =
          static_cast<float>(encode(encoding, double(column) / (kColumns - 1), m));
    }
  }
  return table;
}

double read_beckmann(const BeckmannTable& table, double n_h, double m) {
  if (n_h <= 0.0) return 0.0;
  const double x = std::min(n_h, 1.0) * (kColumns - 1);
  const double y = std::clamp(row_of(m), 0.0, double(kRows - 1));
  const int column = std::min(static_cast<int>(x), kColumns - 2);
  const int row = std::min(static_cast<int>(y), kRows - 2);
  const auto texel = [&](int c, int r) { return double(table.texels.at(c, kRows - 1 - r, 0)); };
  const double s = x - column;
  const double t = y - row;
  return decode(table.encoding, (1 - t) * ((1 - s) * texel(column, row) + s * texel(column + 1, row)) +
                                    t * ((1 - s) * texel(column, row + 1) + s * texel(column + 1, row + 1)));
}

}  // namespace truescatter
