#include "metrics/halo.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace truescatter {
namespace {

constexpr double kBandStdDevs = 3.0;
constexpr double kRangeStdDevs = 6.0;
constexpr double kWithin = 0.01;
constexpr double kDark = 1e-3;  // of the truth's RMS

bool counts(ContourClass nearest, HaloSide side) {
  switch (side) {
    case HaloSide::all:
      return nearest != ContourClass::none;
    case HaloSide::outer:
      return nearest == ContourClass::outer;
    case HaloSide::inner_near:
      return nearest == ContourClass::inner_near;
    case HaloSide::inner_far:
      return nearest == ContourClass::inner_far;
  }
  return false;
}

struct Sums {
  double error = 0.0;
  double magnitude = 0.0;
  double square = 0.0;
  double truth = 0.0;
  std::size_t pixels = 0;

  void add(double e, double t) {
    error += e;
    magnitude += std::abs(e);
    square += e * e;
    truth += t;
    ++pixels;
  }
  double mean_truth() const { return pixels > 0 ? truth / static_cast<double>(pixels) : 0.0; }
  double rmse() const { return pixels > 0 ? std::sqrt(square / static_cast<double>(pixels)) : kNan; }
};

double peak_of(const std::vector<double>& relative_error) {
  double peak = kNan;
  for (const double e : relative_error) {
    if (std::isfinite(e) && !(std::abs(e) <= peak)) peak = std::abs(e);
  }
  return peak;
}

double width_of(const HaloProfile& profile) {
  for (std::size_t i = profile.relative_error.size(); i-- > 0;) {
    const double e = profile.relative_error[i];
    if (!std::isfinite(e) || std::abs(e) <= kWithin) continue;
    const bool last = i + 1 == profile.relative_error.size();
    return last ? kNan : static_cast<double>(i + 1) * profile.bin_mm;
  }
  return 0.0;
}

}  // namespace

Halo measure_band(const Image& test, const Image& truth, const Image& mask, const Band& band_of,
                  double widest_std_dev_mm, double mm_per_px, Quantity quantity) {
  assert(widest_std_dev_mm > 0.0 && mm_per_px > 0.0);
  Halo halo;
  halo.profile.bin_mm = std::max(0.25 * mm_per_px, widest_std_dev_mm / 8.0);
  // The quotient's rounding (48 + 1 ulp for some s) must not add a bin beyond 6 s.
  const double exact_bins = kRangeStdDevs * widest_std_dev_mm / halo.profile.bin_mm;
  const auto bins = static_cast<std::size_t>(std::ceil(exact_bins * (1.0 - 1e-12)));
  std::vector<Sums> binned(bins);
  Sums band;
  Sums beyond;
  double truth_square = 0.0;
  std::size_t masked = 0;
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x) {
      if (mask.at(x, y, 0) == 0.0F) continue;
      const double reference = value_of(truth, x, y, quantity);
      const double error = value_of(test, x, y, quantity) - reference;
      truth_square += reference * reference;
      ++masked;
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(truth.width()) + static_cast<std::size_t>(x);
      const double delta_mm = band_of.delta_mm[i];
      if (delta_mm > kRangeStdDevs * widest_std_dev_mm) beyond.add(error, reference);
      if (!std::isfinite(delta_mm) || (band_of.counts && !band_of.counts(i))) continue;
      if (delta_mm <= kBandStdDevs * widest_std_dev_mm) band.add(error, reference);
      const auto bin = static_cast<std::size_t>(delta_mm / halo.profile.bin_mm);
      if (bin < bins) binned[bin].add(error, reference);
    }
  }
  const double dark = masked > 0 ? kDark * std::sqrt(truth_square / static_cast<double>(masked)) : 0.0;
  for (const Sums& sums : binned) {
    halo.profile.relative_error.push_back(sums.mean_truth() > dark ? sums.error / sums.truth : kNan);
    halo.profile.pixels.push_back(sums.pixels);
  }
  halo.pixels = band.pixels;
  halo.peak = peak_of(halo.profile.relative_error);
  halo.width_mm = std::isfinite(halo.peak) ? width_of(halo.profile) : kNan;
  halo.energy = band.mean_truth() > dark ? band.magnitude / band.truth : kNan;
  halo.contrast = beyond.rmse() > 0.0 ? band.rmse() / beyond.rmse() : kNan;
  return halo;
}

Halo measure_halo(const Image& test, const Image& truth, const Image& mask, const ContourMap& contours,
                  double widest_std_dev_mm, double mm_per_px, Quantity quantity, HaloSide side) {
  const auto on_side = [&](std::size_t i) { return counts(contours.nearest[i], side); };
  return measure_band(test, truth, mask, {contours.delta_mm, on_side}, widest_std_dev_mm, mm_per_px,
                      quantity);
}

}  // namespace truescatter
