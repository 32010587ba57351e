#include "metrics/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/parallel.h"

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

// Convolution of a plane with kernel_x along rows and kernel_y along columns; borders repeat.
Plane convolve_separable(const Plane& in, const Size& size, const std::vector<double>& kernel_x,
                         const std::vector<double>& kernel_y) {
  const auto along = [&](const Plane& from, const std::vector<double>& kernel, bool rows) {
    Plane to(from.size());
    const int radius = static_cast<int>(kernel.size() / 2);
    parallel_for(static_cast<std::size_t>(size.height), [&](std::size_t row) {
      const int y = static_cast<int>(row);
      for (int x = 0; x < size.width; ++x) {
        double sum = 0.0;
        for (int k = -radius; k <= radius; ++k) {
          const int sx = rows ? std::clamp(x + k, 0, size.width - 1) : x;
          const int sy = rows ? y : std::clamp(y + k, 0, size.height - 1);
          sum += kernel[static_cast<std::size_t>(k + radius)] *
                 from[static_cast<std::size_t>(sy) * static_cast<std::size_t>(size.width) +
                      static_cast<std::size_t>(sx)];
        }
        to[row * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)] = sum;
      }
    });
    return to;
  };
  return along(along(in, kernel_x, true), kernel_y, false);
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
    const Plane part = convolve_separable(plane, size, kernel, kernel);
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

struct Perceived {
  std::array<Plane, 3> ycxcz;
  Plane edge;   // magnitude of the first derivative of luminance
  Plane point;  // and of the second
};

Plane magnitude(const Plane& a, const Plane& b) {
  Plane m(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) m[i] = std::hypot(a[i], b[i]);
  return m;
}

Perceived perceive(const Image& image, const Size& size, double ppd) {
  Perceived result;
  for (Plane& plane : result.ycxcz) plane.resize(size.count());
  Plane gray(size.count());
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x);
      const Vec3d v = ycxcz_from_rgb(clipped(image.rgb(x, y)));
      for (std::size_t c = 0; c < 3; ++c) result.ycxcz[c][i] = v[static_cast<Eigen::Index>(c)];
      gray[i] = (v.x() + 16.0) / 116.0;
    }
  }
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
  result.edge =
      magnitude(convolve_separable(gray, size, first, smooth), convolve_separable(gray, size, smooth, first));
  result.point = magnitude(convolve_separable(gray, size, second, smooth),
                           convolve_separable(gray, size, smooth, second));

  // One radius for all channels: that of the widest filter.
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * ppd));
  for (std::size_t c = 0; c < 3; ++c) {
    result.ycxcz[c] = filter_sensitivity(result.ycxcz[c], size, kSensitivity[c], radius, ppd);
  }
  return result;
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
  Perceived perceived;
};

FlipReference::FlipReference(const Image& reference, double pixels_per_degree) {
  const Size size{reference.width(), reference.height()};
  perception_ = std::make_unique<Perception>(
      Perception{size, pixels_per_degree, perceive(reference, size, pixels_per_degree)});
}

FlipReference::~FlipReference() = default;
FlipReference::FlipReference(FlipReference&&) noexcept = default;
FlipReference& FlipReference::operator=(FlipReference&&) noexcept = default;

Image FlipReference::map(const Image& test) const {
  const Size& size = perception_->size;
  assert(test.width() == size.width && test.height() == size.height);
  const Perceived& a = perception_->perceived;
  const Perceived b = perceive(test, size, perception_->pixels_per_degree);
  const auto lab = [](const Perceived& p, std::size_t i) {
    return hunt_lab_from_rgb(clipped(rgb_from_ycxcz({p.ycxcz[0][i], p.ycxcz[1][i], p.ycxcz[2][i]})));
  };
  Image map(size.width, size.height, 1);
  parallel_for(static_cast<std::size_t>(size.height), [&](std::size_t row) {
    const std::size_t first = row * static_cast<std::size_t>(size.width);
    for (std::size_t i = first; i < first + static_cast<std::size_t>(size.width); ++i) {
      const double color = remapped_color_difference(lab(a, i), lab(b, i));
      const double feature = std::max(std::abs(a.edge[i] - b.edge[i]), std::abs(a.point[i] - b.point[i]));
      map.data()[i] = static_cast<float>(std::pow(color, 1.0 - std::sqrt(feature / std::sqrt(2.0))));
    }
  });
  return map;
}

Image flip_map(const Image& reference, const Image& test, double pixels_per_degree) {
  assert(reference.width() == test.width() && reference.height() == test.height());
  return FlipReference(reference, pixels_per_degree).map(test);
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
