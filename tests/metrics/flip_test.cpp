#include "metrics/flip.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace truescatter {
namespace {

// LDR-FLIP written once more, plainly, from Andersson et al. 2020: two-dimensional kernels, no separation.
// The matrix of linear sRGB to XYZ is Lindbloom's, to seven digits.
struct Paper {
  using Picture = std::vector<Vec3d>;
  int width;
  int height;
  double pixels_per_degree;

  static Mat3d xyz_of_rgb() {
    return (Mat3d() << 0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339, 0.1191920,
            0.9503041)
        .finished();
  }
  static Vec3d relative_xyz(const Vec3d& rgb) {
    return (xyz_of_rgb() * rgb).cwiseQuotient(xyz_of_rgb() * Vec3d::Ones());
  }
  static Vec3d hunt_lab(const Vec3d& rgb) {
    const auto f = [](double t) {
      return t > 216.0 / 24389.0 ? std::cbrt(t) : 841.0 / 108.0 * t + 4.0 / 29.0;
    };
    const Vec3d t = relative_xyz(rgb);
    const double l = 116.0 * f(t.y()) - 16.0;
    return {l, 0.01 * l * 500.0 * (f(t.x()) - f(t.y())), 0.01 * l * 200.0 * (f(t.y()) - f(t.z()))};
  }
  static double hyab(const Vec3d& a, const Vec3d& b) {
    return std::abs(a.x() - b.x()) + std::sqrt(std::pow(a.y() - b.y(), 2) + std::pow(a.z() - b.z(), 2));
  }
  // qc = 0.7, pc = 0.4, pt = 0.95, cmax = HyAB(green, blue)^qc.
  static double color_difference(const Vec3d& rgb_a, const Vec3d& rgb_b) {
    const double cmax = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), 0.7);
    const double d = std::pow(hyab(hunt_lab(rgb_a), hunt_lab(rgb_b)), 0.7);
    if (d < 0.4 * cmax) return d * 0.95 / (0.4 * cmax);
    return 0.95 + 0.05 * (d - 0.4 * cmax) / (cmax - 0.4 * cmax);
  }

  template <typename Value, typename Weight>
  Value convolved(const std::vector<Value>& in, int x, int y, int radius, const Weight& weight,
                  Value sum) const {
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; ++dx) {
        const int sx = std::min(std::max(x + dx, 0), width - 1);
        const int sy = std::min(std::max(y + dy, 0), height - 1);
        sum += weight(dx, dy) * in[static_cast<std::size_t>(sy * width + sx)];
      }
    }
    return sum;
  }

  // The picture after the contrast sensitivity filters, back in linear RGB.
  Picture filtered(const Picture& rgb) const {
    Picture opponent;
    for (const Vec3d& v : rgb) {
      const Vec3d t = relative_xyz(v);
      opponent.push_back({116.0 * t.y() - 16.0, 500.0 * (t.x() - t.y()), 200.0 * (t.y() - t.z())});
    }
    const std::array<std::array<double, 4>, 3> ab = {
        {{1.0, 0.0047, 0.0, 1e-5}, {1.0, 0.0053, 0.0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};
    const int radius =
        static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * pixels_per_degree));
    Picture result;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        Vec3d v;
        for (std::size_t c = 0; c < 3; ++c) {
          const auto weight = [&](int dx, int dy) {
            const double z = (dx * dx + dy * dy) / (pixels_per_degree * pixels_per_degree);
            const auto& s = ab[c];
            return s[0] * std::sqrt(kPi / s[1]) * std::exp(-kPi * kPi * z / s[1]) +
                   s[2] * std::sqrt(kPi / s[3]) * std::exp(-kPi * kPi * z / s[3]);
          };
          std::vector<double> plane;
          for (const Vec3d& o : opponent) plane.push_back(o[static_cast<Eigen::Index>(c)]);
          const std::vector<double> ones(plane.size(), 1.0);
          v[static_cast<Eigen::Index>(c)] =
              convolved(plane, x, y, radius, weight, 0.0) / convolved(ones, x, y, radius, weight, 0.0);
        }
        const double yy = (v.x() + 16.0) / 116.0;
        const Vec3d t(yy + v.y() / 500.0, yy, yy - v.z() / 200.0);
        const Vec3d linear = xyz_of_rgb().inverse() * t.cwiseProduct(xyz_of_rgb() * Vec3d::Ones());
        result.push_back(linear.cwiseMax(0.0).cwiseMin(1.0));
      }
    }
    return result;
  }

  // |edge| and |point| response in luminance; each kernel's positive and negative weights sum to 1 and -1.
  std::array<std::vector<double>, 2> features(const Picture& rgb) const {
    std::vector<double> gray;
    for (const Vec3d& v : rgb) gray.push_back(relative_xyz(v).y());
    const double sd = 0.5 * 0.082 * pixels_per_degree;
    const int radius = static_cast<int>(std::ceil(3.0 * sd));
    std::array<std::vector<double>, 2> result;
    for (int kind = 0; kind < 2; ++kind) {
      const auto raw = [&](int along, int across) {
        const double g = std::exp(-(along * along + across * across) / (2.0 * sd * sd));
        return (kind == 0 ? -along : along * along / (sd * sd) - 1.0) * g;
      };
      double positive = 0.0;
      double negative = 0.0;
      for (int a = -radius; a <= radius; ++a) {
        for (int b = -radius; b <= radius; ++b)
          (raw(a, b) > 0.0 ? positive : negative) += std::abs(raw(a, b));
      }
      const auto weight = [&](int along, int across) {
        const double w = raw(along, across);
        return w / (w > 0.0 ? positive : negative);
      };
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const double gx = convolved(
              gray, x, y, radius, [&](int dx, int dy) { return weight(dx, dy); }, 0.0);
          const double gy = convolved(
              gray, x, y, radius, [&](int dx, int dy) { return weight(dy, dx); }, 0.0);
          result[static_cast<std::size_t>(kind)].push_back(std::hypot(gx, gy));
        }
      }
    }
    return result;
  }

  std::vector<double> flip(const Picture& a, const Picture& b) const {
    const Picture filtered_a = filtered(a);
    const Picture filtered_b = filtered(b);
    const auto features_a = features(a);
    const auto features_b = features(b);
    std::vector<double> map;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double feature = std::max(std::abs(features_a[0][i] - features_b[0][i]),
                                      std::abs(features_a[1][i] - features_b[1][i]));
      map.push_back(std::pow(color_difference(filtered_a[i], filtered_b[i]),
                             1.0 - std::sqrt(feature / std::sqrt(2.0))));
    }
    return map;
  }
};

Image constant(const Vec3d& rgb) {
  Image image(12, 9, 3);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 12; ++x) image.set_rgb(x, y, rgb);
  }
  return image;
}

Image noise(unsigned seed) {
  Image image(20, 14, 3);
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  for (float& v : image.data()) v = uniform(generator);
  return image;
}

// Published matrices of linear sRGB to XYZ differ in the fifth digit: after division by white, by up to 1e-4
// of a value, so f by 3.4e-5, a* and b* by up to 500 * 2 * 3.4e-5 = 0.034 each, and HyAB, about 100 to 300
// for colours that matter, by up to 5e-4 of itself in d and likewise in cmax. FLIP goes as d/cmax to the
// power 0.7 at most: 0.7 * (5e-4 + 5e-4) = 7e-4.
constexpr double kMatrixTolerance = 7e-4;

// On constant pictures no filter changes anything (outside values repeat the border) and no edge or point is
// there, so FLIP is the remapped HyAB of the two colours at every pixel.
TEST(Flip, OfConstantsIsTheRemappedColorDifference) {
  const std::vector<std::pair<Vec3d, Vec3d>> pairs = {{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}},
                                                      {{0.2, 0.2, 0.2}, {0.3, 0.3, 0.3}},
                                                      {{0.8, 0.3, 0.2}, {0.7, 0.35, 0.2}},
                                                      {{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}},
                                                      {{1.0, 0.0, 0.0}, {0.0, 0.5, 0.5}}};
  for (const auto& [a, b] : pairs) {
    const Image map = flip_map(constant(a), constant(b));
    for (const float v : map.data()) ASSERT_NEAR(v, Paper::color_difference(a, b), kMatrixTolerance);
  }
}

// Black to white: HyAB = 100. Green and blue, Hunt-adjusted, lie 203.1 apart, so cmax = 203.1^0.7 = 41.27, d
// = 100^0.7 = 25.12 = 0.6086 cmax, and FLIP = 0.95 + 0.05 (0.6086 - 0.4)/0.6 = 0.9674. Green to blue is the
// scale's end.
TEST(Flip, OfBlackAndWhiteAndOfGreenAndBlue) {
  EXPECT_NEAR(flip_map(constant({0, 0, 0}), constant({1, 1, 1})).at(4, 4, 0), 0.9674, 1e-4);
  EXPECT_NEAR(flip_map(constant({0, 1, 0}), constant({0, 0, 1})).at(4, 4, 0), 1.0,
              1e-6);  // a float's rounding
}

// Everything at once against the plain version: filters, features, remapping, borders.
TEST(Flip, OfNoiseAgreesWithThePlainVersion) {
  const Image a = noise(1);
  const Image b = noise(2);
  const auto pixels = [](const Image& image) {
    Paper::Picture picture;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) picture.push_back(image.rgb(x, y));
    }
    return picture;
  };
  for (const double pixels_per_degree : {20.0, 45.0}) {
    const std::vector<double> expected =
        Paper{a.width(), a.height(), pixels_per_degree}.flip(pixels(a), pixels(b));
    const Image map = flip_map(a, b, pixels_per_degree);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      // Colours come close together after filtering, HyAB then is about 10, and the matrices' 0.034 + 0.034
      // of a* and b* are up to 7e-3 of it, times 0.7 * 0.3.
      ASSERT_NEAR(map.data()[i], expected[i], 1.5e-3) << i << " at " << pixels_per_degree;
    }
  }
}

TEST(Flip, OfAPictureWithItselfIsZero) {
  const Image map = flip_map(noise(3), noise(3));
  for (const float v : map.data()) ASSERT_EQ(v, 0.0F);
}

TEST(Flip, IsSymmetricAndWithinTheUnitRange) {
  const Image there = flip_map(noise(4), noise(5));
  const Image back = flip_map(noise(5), noise(4));
  for (std::size_t i = 0; i < there.data().size(); ++i) {
    ASSERT_EQ(there.data()[i], back.data()[i]);
    ASSERT_GE(there.data()[i], 0.0F);
    ASSERT_LE(there.data()[i], 1.0F);
  }
}

TEST(Flip, ClipsToTheDisplay) {
  const Image map = flip_map(constant({1, 1, 1}), constant({5, 5, 5}));
  for (const float v : map.data()) ASSERT_EQ(v, 0.0F);
}

TEST(MeanInside, LeavesOutWhatTheMaskLeavesOut) {
  Image map(3, 1, 1);
  map.at(0, 0, 0) = 0.25F;
  map.at(1, 0, 0) = 0.75F;
  map.at(2, 0, 0) = 100.0F;
  Image mask(3, 1, 1, 1.0F);
  mask.at(2, 0, 0) = 0.0F;
  EXPECT_EQ(mean_inside(map, mask), 0.5);
  EXPECT_TRUE(std::isnan(mean_inside(map, Image(3, 1, 1))));
}

}  // namespace
}  // namespace truescatter
