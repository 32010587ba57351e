#include "metrics/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/parallel.h"
#include "metrics/error_stats.h"

namespace truescatter {
namespace {

// Linear RGB (Rec. 709) to XYZ, relative to the white of D65.
const Mat3d& rgb_to_xyz() {
  static const Mat3d m = (Mat3d() << 10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0,
                          2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0,
                          1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0)
                             .finished();
  return m;
}

Vec3d white_xyz() { return rgb_to_xyz() * Vec3d::Ones(); }

Vec3d clipped(const Vec3d& rgb) { return rgb.cwiseMax(0.0).cwiseMin(1.0); }

// The opponent space in which contrast sensitivity is given: L*a*b* without its cube root.
Vec3d ycxcz_from_rgb(const Vec3d& rgb) {
  const Vec3d t = (rgb_to_xyz() * rgb).cwiseQuotient(white_xyz());
  return {116.0 * t.y() - 16.0, 500.0 * (t.x() - t.y()), 200.0 * (t.y() - t.z())};
}

Vec3d rgb_from_ycxcz(const Vec3d& v) {
  static const Mat3d inverse = rgb_to_xyz().inverse();
  const double y = (v.x() + 16.0) / 116.0;
  const Vec3d t(y + v.y() / 500.0, y, y - v.z() / 200.0);
  return inverse * t.cwiseProduct(white_xyz());
}

Vec3d hunt_lab_from_rgb(const Vec3d& rgb) {
  constexpr double kDelta = 6.0 / 29.0;
  const auto f = [](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
  };
  const Vec3d t = (rgb_to_xyz() * rgb).cwiseQuotient(white_xyz());
  const double lightness = 116.0 * f(t.y()) - 16.0;
  // Hunt effect: colours look less colourful when dark.
  return {lightness, 0.01 * lightness * 500.0 * (f(t.x()) - f(t.y())),
          0.01 * lightness * 200.0 * (f(t.y()) - f(t.z()))};
}

double hyab(const Vec3d& a, const Vec3d& b) {
  const Vec3d d = a - b;
  return std::abs(d.x()) + std::hypot(d.y(), d.z());
}

using Plane = std::vector<double>;

struct Size {
  int width;
  int height;
  std::size_t count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

// Convolution along rows; borders repeat. Sums run tap by tap over a whole row, which compilers vectorise.
Plane convolve_rows(const Plane& in, const Size& size, const std::vector<double>& kernel) {
  Plane out(in.size(), 0.0);
  const auto width = static_cast<std::size_t>(size.width);
  const std::size_t radius = kernel.size() / 2;
  parallel_for(static_cast<std::size_t>(size.height), [&](std::size_t y) {
    std::vector<double> padded(width + 2 * radius);
    for (std::size_t x = 0; x < padded.size(); ++x)
      padded[x] = in[y * width + std::min(x > radius ? x - radius : 0, width - 1)];
    double* const to = &out[y * width];
    for (std::size_t k = 0; k < kernel.size(); ++k) {
      const double weight = kernel[k];
      const double* const from = &padded[k];
      for (std::size_t x = 0; x < width; ++x) to[x] += weight * from[x];
    }
  });
  return out;
}

// The same along columns.
Plane convolve_columns(const Plane& in, const Size& size, const std::vector<double>& kernel) {
  Plane out(in.size(), 0.0);
  const auto width = static_cast<std::size_t>(size.width);
  const auto last = static_cast<std::size_t>(size.height) - 1;
  const std::size_t radius = kernel.size() / 2;
  parallel_for(static_cast<std::size_t>(size.height), [&](std::size_t y) {
    double* const to = &out[y * width];
    for (std::size_t k = 0; k < kernel.size(); ++k) {
      const double weight = kernel[k];
      const std::size_t row = std::min(y + k > radius ? y + k - radius : 0, last);
      const double* const from = &in[row * width];
      for (std::size_t x = 0; x < width; ++x) to[x] += weight * from[x];
    }
  });
  return out;
}

std::vector<double> sampled(int radius, const std::function<double(double)>& f) {
  std::vector<double> kernel;
  for (int i = -radius; i <= radius; ++i) kernel.push_back(f(i));
  return kernel;
}

double sum_of(const std::vector<double>& kernel) {
  double sum = 0.0;
  for (const double k : kernel) sum += k;
  return sum;
}

// One channel's contrast sensitivity in space: sum_j a_j sqrt(pi / b_j) exp(-pi^2 x^2 / b_j), x in degrees.
struct Sensitivity {
  std::array<double, 2> a;
  std::array<double, 2> b;
};
constexpr std::array<Sensitivity, 3> kSensitivity = {
    {{{1.0, 0.0}, {0.0047, 1e-5}}, {{1.0, 0.0}, {0.0053, 1e-5}}, {{34.1, 13.5}, {0.04, 0.025}}}};

Plane filter_sensitivity(const Plane& plane, const Size& size, const Sensitivity& s, int radius, double ppd) {
  Plane result(plane.size(), 0.0);
  double total = 0.0;
  for (std::size_t j = 0; j < 2; ++j) {
    if (s.a[j] == 0.0) continue;
    const std::vector<double> kernel =
        sampled(radius, [&](double i) { return std::exp(-kPi * kPi * (i / ppd) * (i / ppd) / s.b[j]); });
    const double weight = s.a[j] * std::sqrt(kPi / s.b[j]);
    const Plane part = convolve_columns(convolve_rows(plane, size, kernel), size, kernel);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] += weight * part[i];
    total += weight * sum_of(kernel) * sum_of(kernel);
  }
  for (double& v : result) v /= total;
  return result;
}

// Positive and negative parts of the kernel's weights each sum to 1 (in two dimensions: times the sum of the
// smoothing kernel across).
std::vector<double> normalised_parts(std::vector<double> kernel, double across) {
  double positive = 0.0;
  double negative = 0.0;
  for (const double k : kernel) (k > 0.0 ? positive : negative) += std::abs(k);
  for (double& k : kernel) k /= (k > 0.0 ? positive : negative) * across;
  return kernel;
}

// What a picture is compared by, pixel by pixel. In single precision, for a reference is kept for many
// pictures at many exposures; both pictures are rounded alike, so equal ones do not differ.
struct Perceived {
  std::array<std::vector<float>, 3> lab;  // Hunt-adjusted, after the contrast sensitivity filters
  std::vector<float> edge;                // magnitude of the first derivative of luminance
  std::vector<float> point;               // and of the second
};

std::vector<float> magnitude(const Plane& a, const Plane& b) {
  std::vector<float> m(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) m[i] = static_cast<float>(std::sqrt(a[i] * a[i] + b[i] * b[i]));
  return m;
}

// The light that a display gives for a picture's, in [0, 1].
using Display = std::function<Vec3d(const Vec3d&)>;

Perceived perceive(const Image& image, const Size& size, double ppd, const Display& display) {
  std::array<Plane, 3> ycxcz;
  for (Plane& plane : ycxcz) plane.resize(size.count());
  Plane gray(size.count());
  parallel_for(static_cast<std::size_t>(size.height), [&](std::size_t y) {
    for (int x = 0; x < size.width; ++x) {
      const std::size_t i = y * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x);
      const Vec3d v = ycxcz_from_rgb(display(image.rgb(x, static_cast<int>(y))));
      for (std::size_t c = 0; c < 3; ++c) ycxcz[c][i] = v[static_cast<Eigen::Index>(c)];
      gray[i] = (v.x() + 16.0) / 116.0;
    }
  });
  Perceived result;
  constexpr double kFeatureWidthDeg = 0.082;
  const double sd = 0.5 * kFeatureWidthDeg * ppd;
  const int feature_radius = static_cast<int>(std::ceil(3.0 * sd));
  const std::vector<double> smooth =
      sampled(feature_radius, [&](double i) { return std::exp(-i * i / (2 * sd * sd)); });
  const double across = sum_of(smooth);
  const std::vector<double> first = normalised_parts(
      sampled(feature_radius, [&](double i) { return -i * std::exp(-i * i / (2 * sd * sd)); }), across);
  const std::vector<double> second = normalised_parts(
      sampled(feature_radius,
              [&](double i) { return (i * i / (sd * sd) - 1.0) * std::exp(-i * i / (2 * sd * sd)); }),
      across);
  const Plane smooth_rows = convolve_rows(gray, size, smooth);
  result.edge = magnitude(convolve_columns(convolve_rows(gray, size, first), size, smooth),
                          convolve_columns(smooth_rows, size, first));
  result.point = magnitude(convolve_columns(convolve_rows(gray, size, second), size, smooth),
                           convolve_columns(smooth_rows, size, second));

  // One radius for all channels: that of the widest filter.
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * ppd));
  for (std::size_t c = 0; c < 3; ++c) {
    ycxcz[c] = filter_sensitivity(ycxcz[c], size, kSensitivity[c], radius, ppd);
    result.lab[c].resize(size.count());
  }
  parallel_for(static_cast<std::size_t>(size.height), [&](std::size_t y) {
    const std::size_t begin = y * static_cast<std::size_t>(size.width);
    for (std::size_t i = begin; i < begin + static_cast<std::size_t>(size.width); ++i) {
      const Vec3d lab = hunt_lab_from_rgb(clipped(rgb_from_ycxcz({ycxcz[0][i], ycxcz[1][i], ycxcz[2][i]})));
      for (std::size_t c = 0; c < 3; ++c)
        result.lab[c][i] = static_cast<float>(lab[static_cast<Eigen::Index>(c)]);
    }
  });
  return result;
}

// The tone curve's coefficients: Narkowicz 2016, with x for 0.6 x.
struct Tone {
  double square;
  double linear;
  double square_below;
  double linear_below;
  double constant_below;
};
constexpr Tone kTone = {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};
constexpr double kToneAtEnds = 0.85;

// The light x > 0 that the tone curve maps to y < 1: of (k0 - y k3) x^2 + (k1 - y k4) x - y k5 = 0 the
// positive root (k0 > k3 and k5 > 0, so the roots' product is negative: there is one).
double light_of_tone(double y) {
  const double a = kTone.square - y * kTone.square_below;
  const double half_b = 0.5 * (kTone.linear - y * kTone.linear_below) / a;
  return -half_b + std::sqrt(half_b * half_b + y * kTone.constant_below / a);
}

double remapped_color_difference(const Vec3d& a, const Vec3d& b) {
  constexpr double kPower = 0.7;
  constexpr double kKnee = 0.4;
  constexpr double kKneeValue = 0.95;
  static const double largest =
      std::pow(hyab(hunt_lab_from_rgb(Vec3d::UnitY()), hunt_lab_from_rgb(Vec3d::UnitZ())), kPower);
  const double d = std::pow(hyab(a, b), kPower);
  if (d < kKnee * largest) return kKneeValue / (kKnee * largest) * d;
  return std::min(1.0, kKneeValue + (d - kKnee * largest) / (largest - kKnee * largest) * (1.0 - kKneeValue));
}

}  // namespace

struct FlipReference::Perception {
  Size size;
  double pixels_per_degree;
  Display display;
  Perceived perceived;
};

FlipReference::FlipReference(const Image& reference, double pixels_per_degree)
    : FlipReference(reference, pixels_per_degree, clipped) {}

FlipReference::FlipReference(const Image& reference, double pixels_per_degree,
                             std::function<Vec3d(const Vec3d&)> display) {
  const Size size{reference.width(), reference.height()};
  Perceived perceived = perceive(reference, size, pixels_per_degree, display);
  perception_ = std::make_unique<Perception>(
      Perception{size, pixels_per_degree, std::move(display), std::move(perceived)});
}

FlipReference::~FlipReference() = default;
FlipReference::FlipReference(FlipReference&&) noexcept = default;
FlipReference& FlipReference::operator=(FlipReference&&) noexcept = default;

Image FlipReference::map(const Image& test) const {
  const Size& size = perception_->size;
  assert(test.width() == size.width && test.height() == size.height);
  const Perceived& a = perception_->perceived;
  const Perceived b = perceive(test, size, perception_->pixels_per_degree, perception_->display);
  const auto lab = [](const Perceived& p, std::size_t i) {
    return Vec3d(p.lab[0][i], p.lab[1][i], p.lab[2][i]);
  };
  Image map(size.width, size.height, 1);
  parallel_for(static_cast<std::size_t>(size.height), [&](std::size_t row) {
    const std::size_t first = row * static_cast<std::size_t>(size.width);
    for (std::size_t i = first; i < first + static_cast<std::size_t>(size.width); ++i) {
      const double color = remapped_color_difference(lab(a, i), lab(b, i));
      const double feature = std::max(std::abs(static_cast<double>(a.edge[i]) - b.edge[i]),
                                      std::abs(static_cast<double>(a.point[i]) - b.point[i]));
      map.data()[i] = static_cast<float>(std::pow(color, 1.0 - std::sqrt(feature / std::sqrt(2.0))));
    }
  });
  return map;
}

Image flip_map(const Image& reference, const Image& test, double pixels_per_degree) {
  assert(reference.width() == test.width() && reference.height() == test.height());
  return FlipReference(reference, pixels_per_degree).map(test);
}

double hdr_flip_tone(double x) {
  const double light = std::max(x, 0.0);
  const double below = (kTone.square_below * light + kTone.linear_below) * light + kTone.constant_below;
  // So bright that it overflows: the curve's end, clipped.
  if (!std::isfinite(below)) return 1.0;
  return std::min(1.0, (kTone.square * light + kTone.linear) * light / below);
}

ExposureRange hdr_flip_exposures(const Image& reference, const Image& mask, double least_light) {
  std::vector<double> luminances;
  for (int y = 0; y < reference.height(); ++y) {
    for (int x = 0; x < reference.width(); ++x) {
      if (mask.at(x, y, 0) != 0.0F) luminances.push_back(luminance(reference.rgb(x, y)));
    }
  }
  if (luminances.empty()) return {0.0, 0.0, 2};
  std::sort(luminances.begin(), luminances.end());
  if (!(luminances.back() > 0.0)) return {0.0, 0.0, 2};
  const std::size_t n = luminances.size();
  const double middle = 0.5 * (luminances[(n - 1) / 2] + luminances[n / 2]);
  const double least = static_cast<double>(std::numeric_limits<float>::epsilon()) * luminances.back();
  const double median = std::max({middle, least, std::min(least_light, luminances.back())});
  const double light = light_of_tone(kToneAtEnds);
  const double start = std::log2(light / luminances.back());
  const double stop = std::log2(light / median);
  return {start, stop, std::max(2, static_cast<int>(std::ceil(stop - start)))};
}

double FlipReference::kept_bytes(double pixels) {
  return pixels * 5.0 * sizeof(float);  // Perceived
}

int HdrFlipReference::kept_exposures(double pixels, int exposures, double most_bytes) {
  const double fitting = std::floor(most_bytes / std::max(FlipReference::kept_bytes(pixels), 1.0));
  return fitting >= exposures ? exposures : std::max(1, static_cast<int>(fitting));
}

double HdrFlipReference::kept_bytes(double pixels, int exposures) {
  const int kept = kept_exposures(pixels, exposures, kMostBytes);
  // With the reference itself, and one exposure at a time.
  const double others =
      kept < exposures ? pixels * 3.0 * sizeof(float) + FlipReference::kept_bytes(pixels) : 0.0;
  return kept * FlipReference::kept_bytes(pixels) + others;
}

HdrFlipReference::HdrFlipReference(const Image& reference, const Image& mask, double least_light,
                                   double pixels_per_degree, double most_bytes)
    : exposures_(hdr_flip_exposures(reference, mask, least_light)),
      reference_(reference),
      pixels_per_degree_(pixels_per_degree) {
  const int kept = kept_exposures(static_cast<double>(reference.pixel_count()), exposures_.count, most_bytes);
  for (int i = 0; i < kept; ++i) kept_.push_back(at_exposure(i));
  if (kept == exposures_.count) reference_ = Image();
}

FlipReference HdrFlipReference::at_exposure(int index) const {
  const double step = (exposures_.stop - exposures_.start) / (exposures_.count - 1);
  const double factor = std::exp2(exposures_.start + index * step);
  return FlipReference(reference_, pixels_per_degree_, [factor](const Vec3d& rgb) -> Vec3d {
    return (factor * rgb).unaryExpr(&hdr_flip_tone);
  });
}

Image HdrFlipReference::map(const Image& test) const {
  Image largest(test.width(), test.height(), 1);  // FLIP is at least 0
  for (int i = 0; i < exposures_.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Image map = at < kept_.size() ? kept_[at].map(test) : at_exposure(i).map(test);
    std::transform(map.data().begin(), map.data().end(), largest.data().begin(), largest.data().begin(),
                   [](float a, float b) { return std::max(a, b); });
  }
  return largest;
}

VisibleDifference visible_difference(const Image& flip_map, const Image& mask) {
  std::vector<double> values;
  for (std::size_t i = 0; i < mask.pixel_count(); ++i) {
    if (mask.data()[i] != 0.0F) values.push_back(flip_map.data()[i]);
  }
  if (values.empty()) return {kNan, kNan, kNan, kNan};
  std::sort(values.begin(), values.end());
  const auto share_above = [&](double limit) {
    const auto above = values.end() - std::upper_bound(values.begin(), values.end(), limit);
    return static_cast<double>(above) / static_cast<double>(values.size());
  };
  return {mean_inside(flip_map, mask), quantile(values, 0.95), share_above(0.05), share_above(0.1)};
}

double mean_inside(const Image& map, const Image& mask) {
  double sum = 0.0;
  std::size_t count = 0;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (mask.at(x, y, 0) == 0.0F) continue;
      sum += static_cast<double>(map.at(x, y, 0));
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace truescatter
