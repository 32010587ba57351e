#include "metrics/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace truescatter {
namespace {

// LDR-FLIP written once more, plainly, from Andersson et al. 2020: two-dimensional kernels in double
// precision, no separation. The matrix of linear sRGB to XYZ is made from the primaries and the white of D65,
// (0.31271, 0.32902), for which the authors' program has its fractions.
struct Paper {
  using Picture = std::vector<Vec3d>;
  int width;
  int height;
  double pixels_per_degree;

  static Mat3d made_from_primaries() {
    const auto xyz = [](double x, double y) { return Vec3d(x / y, 1.0, (1.0 - x - y) / y); };
    Mat3d primaries;
    primaries << xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06);
    const Vec3d luminances = primaries.inverse() * xyz(0.31271, 0.32902);
    return primaries * luminances.asDiagonal();
  }
  static const Mat3d& xyz_of_rgb() {
    static const Mat3d m = made_from_primaries();
    return m;
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

Paper::Picture pixels(const Image& image) {
  Paper::Picture picture;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) picture.push_back(image.rgb(x, y));
  }
  return picture;
}

Image noise(unsigned seed) {
  Image image(20, 14, 3);
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  for (float& v : image.data()) v = uniform(generator);
  return image;
}

// Both compute in double precision and agree but for single precision where values are kept. L*, a* and b* of
// up to 100 to 4e-6 each, so HyAB, d, to 2e-5, and FLIP, 0.0575 d^0.7 in its steep part, to 0.7 * 0.0575 *
// 0.01^-0.3 * 2e-5 = 4e-6 for d >= 0.01. Edges and points of up to 1 to 6e-8 each: the feature's share in the
// exponent, sqrt(f / sqrt 2), to sqrt(1.2e-7 / 1.4) = 3e-4 where it is near 0, times max |c ln c| = 0.37.
constexpr double kRounding = 1.2e-4;

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
    for (const float v : map.data()) ASSERT_NEAR(v, Paper::color_difference(a, b), kRounding);
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
  for (const double pixels_per_degree : {20.0, 45.0}) {
    const std::vector<double> expected =
        Paper{a.width(), a.height(), pixels_per_degree}.flip(pixels(a), pixels(b));
    const Image map = flip_map(a, b, pixels_per_degree);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_NEAR(map.data()[i], expected[i], kRounding) << i << " at " << pixels_per_degree;
    }
  }
}

// What pictures of skin are made of: flat colour, straight and slanting edges, points as of a highlight;
// moved, tinted and left out in the other picture.
Image edges_points_and_flat_colour(bool other) {
  Image image(36, 28, 3);
  const Vec3d skin(0.55, 0.35, 0.28);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const bool right = x > (other ? 13 : 12);
      const bool below = y + x / 3 > (other ? 25 : 24);
      const Vec3d lit = right ? skin : Vec3d(0.1 * skin);
      image.set_rgb(x, y, below ? Vec3d(0.2, 0.5, other ? 0.55 : 0.5) : lit);
    }
  }
  image.set_rgb(20, 6, Vec3d::Ones());
  image.set_rgb(other ? 27 : 26, 9, Vec3d::Ones());
  if (!other) image.set_rgb(18, 12, Vec3d::Zero());
  return image;
}

TEST(Flip, OfEdgesPointsAndFlatColourAgreesWithThePlainVersion) {
  const Image a = edges_points_and_flat_colour(false);
  const Image b = edges_points_and_flat_colour(true);
  for (const double pixels_per_degree : {20.0, 67.0206}) {
    const std::vector<double> expected =
        Paper{a.width(), a.height(), pixels_per_degree}.flip(pixels(a), pixels(b));
    const Image map = flip_map(a, b, pixels_per_degree);
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_NEAR(map.data()[i], expected[i], kRounding) << i << " at " << pixels_per_degree;
    EXPECT_GT(*std::max_element(expected.begin(), expected.end()), 0.1);
  }
}

TEST(VisibleDifference, CountsThePixelsOfTheMask) {
  Image map(10, 10, 1);
  Image mask(10, 10, 1, 1.0F);
  for (std::size_t i = 0; i < 100; ++i) map.data()[i] = (static_cast<float>(i) + 0.25F) / 500.0F;
  for (std::size_t i = 0; i < 20; ++i) mask.data()[i] = 0.0F;
  const VisibleDifference difference = visible_difference(map, mask);
  EXPECT_NEAR(difference.mean, (59.5 + 0.25) / 500.0, 1e-7);
  EXPECT_NEAR(difference.p95, 95.25 / 500.0, 1e-7);       // the 76th of 80
  EXPECT_NEAR(difference.above_005, 75.0 / 80.0, 1e-12);  // 25 to 99
  EXPECT_NEAR(difference.above_01, 50.0 / 80.0, 1e-12);   // 50 to 99
  EXPECT_TRUE(std::isnan(visible_difference(map, Image(10, 10, 1)).mean));
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

// The tone curve as Narkowicz gives it, at 0.6 x.
double narkowicz(double x) {
  const double v = 0.6 * x;
  return std::min(1.0, v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14));
}

TEST(HdrFlip, HasTheTonesOfThePublishedCurve) {
  for (const double x : {0.0, 1e-3, 0.1, 0.85, 1.0, 4.0, 20.0})
    EXPECT_NEAR(hdr_flip_tone(x), narkowicz(x), 1e-15);
  EXPECT_EQ(hdr_flip_tone(-1.0), 0.0);
  EXPECT_EQ(hdr_flip_tone(1e200), 1.0);
}

// Over the mask: 1 1 1 8, outside 64. The largest is 8 times the median, so three stops in three exposures;
// at the first 8, at the last 1 is mapped to 0.85.
TEST(HdrFlip, SpansFromTheLargestToTheMedianOfTheMask) {
  Image reference(5, 1, 3, 1.0F);
  reference.set_rgb(3, 0, Vec3d::Constant(8.0));
  reference.set_rgb(4, 0, Vec3d::Constant(64.0));
  Image mask(5, 1, 1, 1.0F);
  mask.at(4, 0, 0) = 0.0F;
  const ExposureRange range = hdr_flip_exposures(reference, mask);
  EXPECT_NEAR(narkowicz(8.0 * std::exp2(range.start)), 0.85, 1e-12);
  EXPECT_NEAR(narkowicz(std::exp2(range.stop)), 0.85, 1e-12);
  EXPECT_NEAR(range.stop - range.start, 3.0, 1e-12);
  EXPECT_EQ(hdr_flip_exposures(reference, Image(5, 1, 1, 1.0F)).count, 6);
}

TEST(HdrFlip, LooksNoDeeperThanTheReferenceIsKnown) {
  Image reference(3, 1, 3, 0.0F);
  reference.set_rgb(0, 0, Vec3d::Constant(1.0));
  const Image mask(3, 1, 1, 1.0F);
  const ExposureRange range = hdr_flip_exposures(reference, mask, 1.0 / 1024.0);
  EXPECT_NEAR(range.stop - range.start, 10.0, 1e-12);
  const ExposureRange deepest = hdr_flip_exposures(reference, mask);  // epsilon = 2^-23
  EXPECT_NEAR(deepest.stop - deepest.start, 23.0, 1e-12);
  EXPECT_EQ(hdr_flip_exposures(Image(3, 1, 3), mask).count, 2);
  EXPECT_EQ(hdr_flip_exposures(reference, Image(3, 1, 1)).stop, 0.0);
}

// Light over eight stops; exposures by bisection of the curve, the median by counting.
TEST(HdrFlip, OfNoiseAgreesWithThePlainVersion) {
  const auto wide = [](unsigned seed) {
    Image image = noise(seed);
    for (float& v : image.data()) v = std::exp2(8.0F * v - 4.0F);
    return image;
  };
  const Image a = wide(6);
  const Image b = wide(7);
  const auto light_for = [](double tone) {
    double low = 0.0;
    double high = 10.0;
    for (int i = 0; i < 200; ++i) (narkowicz(0.5 * (low + high)) < tone ? low : high) = 0.5 * (low + high);
    return low;
  };
  std::vector<double> luminances;
  for (const Vec3d& v : pixels(a)) luminances.push_back(0.2126 * v.x() + 0.7152 * v.y() + 0.0722 * v.z());
  const auto below = [&](double limit) {
    return std::count_if(luminances.begin(), luminances.end(), [&](double v) { return v <= limit; });
  };
  // 280 pixels: the mean of the 140th and the 141st.
  double lower = 1e9;
  double upper = 1e9;
  for (const double v : luminances) {
    if (below(v) >= 140) lower = std::min(lower, v);
    if (below(v) >= 141) upper = std::min(upper, v);
  }
  const double largest = *std::max_element(luminances.begin(), luminances.end());
  const double start = std::log2(light_for(0.85) / largest);
  const double stop = std::log2(light_for(0.85) / (0.5 * (lower + upper)));
  const int count = std::max(2, static_cast<int>(std::ceil(stop - start)));
  ASSERT_GE(count, 3);  // else it says little
  constexpr double kPixelsPerDegree = 20.0;
  const Paper paper{a.width(), a.height(), kPixelsPerDegree};
  std::vector<double> expected(luminances.size(), 0.0);
  for (int i = 0; i < count; ++i) {
    const double factor = std::exp2(start + (stop - start) * i / (count - 1));
    const auto toned = [&](const Image& image) {
      Paper::Picture picture;
      for (const Vec3d& v : pixels(image))
        picture.push_back({narkowicz(factor * v.x()), narkowicz(factor * v.y()), narkowicz(factor * v.z())});
      return picture;
    };
    const std::vector<double> map = paper.flip(toned(a), toned(b));
    for (std::size_t p = 0; p < map.size(); ++p) expected[p] = std::max(expected[p], map[p]);
  }
  const Image map = HdrFlipReference(a, Image(20, 14, 1, 1.0F), 0.0, kPixelsPerDegree).map(b);
  for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_NEAR(map.data()[i], expected[i], kRounding) << i;
}

// A grey reference of any brightness is shown at 0.85: L* = 116 * 0.85^(1/3) - 16 = 93.88, against black d =
// 93.88^0.7 = 24.03 = 0.5823 cmax, and FLIP = 0.95 + 0.05 (0.5823 - 0.4)/0.6 = 0.9652.
TEST(HdrFlip, OfAConstantAndBlackByHand) {
  for (const double grey : {1e-3, 1.0, 300.0}) {
    const HdrFlipReference reference(constant(Vec3d::Constant(grey)), Image(12, 9, 1, 1.0F));
    EXPECT_EQ(reference.exposures().count, 2);
    EXPECT_NEAR(reference.map(constant(Vec3d::Zero())).at(4, 4, 0), 0.9652, 1e-4);
  }
}

// What is computed again is what was kept.
TEST(HdrFlip, IsTheSameWithoutRoomForItsReferences) {
  const Image mask(20, 14, 1, 1.0F);
  const HdrFlipReference kept(noise(3), mask, 1e-4);
  const HdrFlipReference again(noise(3), mask, 1e-4, 67.0206, 0.0);
  ASSERT_GE(kept.exposures().count, 2);
  const Image expected = kept.map(noise(4));
  const Image map = again.map(noise(4));
  EXPECT_TRUE(std::equal(map.data().begin(), map.data().end(), expected.data().begin()));
}

// 5 floats a pixel and exposure: all of them within 1 GiB; of 2^24 pixels three, the reference, and one more.
TEST(HdrFlip, KeepsNoMoreThanItMay) {
  EXPECT_EQ(HdrFlipReference::kept_bytes(1e6, 15), 15.0 * 20e6);
  const double pixels = 4096.0 * 4096.0;
  EXPECT_EQ(HdrFlipReference::kept_bytes(pixels, 15), (3.0 + 1.0) * 20.0 * pixels + 12.0 * pixels);
}

TEST(HdrFlip, OfAPictureWithItselfIsZero) {
  const HdrFlipReference reference(noise(3), Image(20, 14, 1, 1.0F));
  const Image map = reference.map(noise(3));
  for (const float v : map.data()) ASSERT_EQ(v, 0.0F);
}

// What LDR-FLIP clips away is seen at a shorter exposure.
TEST(HdrFlip, SeesWhatTheDisplayClips) {
  Image reference = constant(Vec3d::Constant(0.1));
  Image test = reference;
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 9; ++y) {
      reference.set_rgb(x, y, Vec3d::Constant(4.0));
      test.set_rgb(x, y, Vec3d::Constant(2.0));
    }
  }
  EXPECT_LT(flip_map(reference, test).at(1, 4, 0), 1e-6F);
  EXPECT_GT(HdrFlipReference(reference, Image(12, 9, 1, 1.0F)).map(test).at(1, 4, 0), 0.1F);
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
