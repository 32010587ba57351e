#include "profile/layered.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/csv.h"
#include "core/error.h"
#include "core/vec.h"

namespace truescatter {
namespace {

using Complex = std::complex<double>;

constexpr double kEtaOfAir = 1.0;
// Of log k l: below, k R(k) is less than rounding of its largest value; above, exp(-k l) is 0.
constexpr double kLowestLogFrequency = -38.0;
constexpr double kHighestLogFrequency = 6.6;
// Harmonics fall as exp(-pi/2 w), to 1e-17 here.
constexpr double kHighestHarmonic = 25.0;

double diffuse_reflectance(double eta) {
  if (eta >= 1.0) return classical_diffuse_reflectance(eta);
  return -0.4399 + 0.7099 / eta - 0.3319 / (eta * eta) + 0.0636 / (eta * eta * eta);
}

// 2 A D, where the fluence is extrapolated to 0.
double extrapolation_mm(const Medium& medium, double eta_outside) {
  const double a = extrapolation_factor(diffuse_reflectance(medium.eta / eta_outside));
  return 2.0 * a * medium.mean_free_path_mm() / 3.0;
}

// sinh(a) / sinh(b), |a| <= b.
double sinh_ratio(double a, double b) {
  const double size = std::abs(a);
  return std::copysign(std::exp(size - b) * std::expm1(-2.0 * size) / std::expm1(-2.0 * b), a);
}

// arg Gamma(1/2 + i y): Stirling's series where |z| > 12 leaves 1e-17, and the recurrence from there.
double gamma_phase(double y) {
  constexpr int kSteps = 12;
  const Complex z(0.5, y);
  double phase = 0.0;
  for (int i = 0; i < kSteps; ++i) phase -= std::arg(z + static_cast<double>(i));
  const Complex far = z + static_cast<double>(kSteps);
  const Complex inverse = 1.0 / far;
  const Complex square = inverse * inverse;
  const Complex series =
      inverse *
      (1.0 / 12.0 -
       square * (1.0 / 360.0 -
                 square * (1.0 / 1260.0 -
                           square * (1.0 / 1680.0 - square * (1.0 / 1188.0 - square * (691.0 / 360360.0))))));
  return phase + ((far - 0.5) * std::log(far) - far + series).imag();
}

// Of one layer by itself.
void require_valid_layer(const Layer& layer) {
  require_valid(layer.medium);
  require_thick(layer.medium, layer.thickness_mm, "layer");
}

void require_valid_stack(const std::vector<Layer>& layers) {
  if (layers.empty()) throw_input_error({}, "a stack needs at least one layer");
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const Layer& layer = layers[i];
    require_valid_layer(layer);
    if (std::isinf(layer.thickness_mm) && i + 1 < layers.size())
      throw_input_error({}, "layer {} has no end, and layers follow", i + 1);
  }
}

std::array<std::vector<Layer>, 3> stack(const std::vector<Vec3d>& sigma_a, const std::vector<Vec3d>& sigma_s,
                                        const std::vector<double>& eta,
                                        const std::vector<double>& thickness_mm) {
  std::array<std::vector<Layer>, 3> channels;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto at = static_cast<Eigen::Index>(c);
    for (std::size_t i = 0; i < eta.size(); ++i)
      channels[c].push_back({{sigma_a[i][at], sigma_s[i][at], eta[i]}, thickness_mm[i]});
  }
  return channels;
}

}  // namespace

SlabResponse slab_response(const Layer& layer, double eta_above, double eta_below, double k_per_mm) {
  const Medium& medium = layer.medium;
  const double path = medium.mean_free_path_mm();
  const double g = std::hypot(std::sqrt(3.0 * medium.sigma_a_per_mm / path), k_per_mm);
  const double strength = 0.5 * medium.reduced_albedo();
  const double above = extrapolation_mm(medium, eta_above);
  if (std::isinf(layer.thickness_mm)) {
    const double back = strength * (std::exp(-g * path) + std::exp(-g * (path + 2.0 * above)));
    return {back, 0.0, 0.0, 0.0};
  }
  const double below = extrapolation_mm(medium, eta_below);
  const double d = layer.thickness_mm;
  const double half = d + above + below;
  // Where g is 0, its limit.
  const auto ratio = [&](double depth) {
    return g * half < 1e-8 ? depth / half : sinh_ratio(g * depth, g * half);
  };
  const auto reflect = [&](double zb) {
    return strength * (ratio(half - path) + ratio(half - path - 2.0 * zb));
  };
  const auto transmit = [&](double zb) {
    return strength * (ratio(half - d + path) - ratio(half - d - path - 2.0 * zb));
  };
  return {reflect(above), transmit(above), reflect(below), transmit(below)};
}

LayeredProfile::LayeredProfile(std::vector<Layer> layers) : layers_(std::move(layers)) {
  require_valid_stack(layers_);
  const double low = kLowestLogFrequency - std::log(shortest_length_mm());
  const double length = kHighestLogFrequency - kLowestLogFrequency;
  log_step_ = 2.0 * kPi / length;
  const int harmonics = static_cast<int>(std::ceil(kHighestHarmonic / log_step_));
  const int samples = 2 * harmonics + 1;
  std::vector<double> light(static_cast<std::size_t>(samples));
  for (int j = 0; j < samples; ++j) {
    const double k_per_mm = std::exp(low + length * j / samples);
    light[static_cast<std::size_t>(j)] = k_per_mm * response(k_per_mm);
  }
  for (int m = 0; m <= harmonics; ++m) {
    Complex sum = 0.0;
    const Complex turn = std::polar(1.0, -2.0 * kPi * m / samples);
    Complex phase = 1.0;
    for (int j = 0; j < samples; ++j) {
      sum += light[static_cast<std::size_t>(j)] * phase;
      // Anew now and then, as products drift.
      phase = j % 16 == 15
                  ? std::polar(1.0, -2.0 * kPi * ((static_cast<long>(m) * (j + 1)) % samples) / samples)
                  : phase * turn;
    }
    const double w = m * log_step_;
    const double angle = w * (std::numbers::ln2 - low) + 2.0 * gamma_phase(0.5 * w);
    // A real series: each harmonic stands for its conjugate too.
    const double pair = m == 0 ? 1.0 : 2.0;
    harmonics_.push_back(sum * std::polar(pair / samples, angle) / (2.0 * kPi));
  }
}

double LayeredProfile::response(double k_per_mm) const {
  const auto eta = [&](std::size_t i) { return layers_[i].medium.eta; };
  double below = 0.0;
  for (std::size_t i = layers_.size(); i-- > 0;) {
    const double eta_above = i == 0 ? kEtaOfAir : eta(i - 1);
    const double eta_below = i + 1 == layers_.size() ? kEtaOfAir : eta(i + 1);
    const SlabResponse slab = slab_response(layers_[i], eta_above, eta_below, k_per_mm);
    below = slab.reflect_above +
            slab.transmit_above * below * slab.transmit_below / (1.0 - slab.reflect_below * below);
  }
  return below;
}

double LayeredProfile::value(double r_mm) const {
  assert(r_mm > 0.0);
  const Complex turn = std::polar(1.0, -log_step_ * std::log(r_mm));
  Complex sum = 0.0;
  for (std::size_t m = harmonics_.size(); m-- > 0;) sum = sum * turn + harmonics_[m];
  return sum.real() / r_mm;
}

double LayeredProfile::antiderivative(double r_mm) const {
  const double at_zero = -albedo() / (2.0 * kPi);
  if (r_mm == 0.0) return at_zero;
  const Complex turn = std::polar(1.0, -log_step_ * std::log(r_mm));
  Complex sum = 0.0;
  for (std::size_t m = harmonics_.size(); m-- > 0;)
    sum = sum * turn + harmonics_[m] / Complex(1.0, -log_step_ * static_cast<double>(m));
  return at_zero + r_mm * sum.real();
}

double LayeredProfile::shortest_length_mm() const { return layers_.front().medium.mean_free_path_mm(); }

const std::vector<LayeredMaterial>& layered_materials() {
  static const std::vector<LayeredMaterial> table = {
      {"skin-three-layer", stack({{2.1, 2.1, 5.0}, {0.16, 0.19, 0.30}, {0.085, 1.0, 25.0}},
                                 {{48.0, 60.0, 65.0}, {32.0, 40.0, 46.0}, {4.5, 4.7, 4.8}}, {1.4, 1.34, 1.4},
                                 {0.25, 0.20, std::numeric_limits<double>::infinity()})}};
  return table;
}

std::array<std::vector<Layer>, 3> read_layers(const std::filesystem::path& path) {
  CsvReader reader(path, {"thickness_mm", "sigma_a_r", "sigma_a_g", "sigma_a_b", "sigma_s_prime_r",
                          "sigma_s_prime_g", "sigma_s_prime_b", "eta"});
  std::array<std::vector<Layer>, 3> channels;
  bool ended = false;
  while (reader.next()) {
    if (ended) throw_input_error(reader.where(), "the layer above has no end, and layers follow");
    const double stated_mm = reader.number(0);
    if (stated_mm < 0.0)
      throw_input_error(reader.where(0), "{}: a thickness must not be negative", stated_mm);
    ended = stated_mm == 0.0;
    const double thickness_mm = ended ? std::numeric_limits<double>::infinity() : stated_mm;
    for (std::size_t c = 0; c < 3; ++c) {
      channels[c].push_back({{reader.number(1 + c), reader.number(4 + c), reader.number(7)}, thickness_mm});
      try {
        require_valid_layer(channels[c].back());
      } catch (const Error& error) {
        throw Error(error.kind(), reader.where(), error.what());
      }
    }
  }
  if (channels[0].empty()) throw_input_error({path.string()}, "there is no layer below the header");
  return channels;
}

}  // namespace truescatter
