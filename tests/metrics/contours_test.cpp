#include "metrics/contours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace truescatter {
namespace {

constexpr double kFocal_px = 1000.0;

// A picture whose pixels are set by depth and facet normal; at first, nothing is seen.
struct Picture {
  Image mask;
  Image position;
  Image face_normal;

  Picture(int width, int height)
      : mask(width, height, 1), position(width, height, 3), face_normal(width, height, 3) {}

  Vec3d ray(int x, int y) const {
    return {(x + 0.5 - 0.5 * mask.width()) / kFocal_px, (0.5 * mask.height() - (y + 0.5)) / kFocal_px, -1.0};
  }
  void set(int x, int y, double depth_mm, const Vec3d& normal = Vec3d::UnitZ(), bool skin = true) {
    position.set_rgb(x, y, depth_mm * ray(x, y));
    face_normal.set_rgb(x, y, normal);
    mask.at(x, y, 0) = skin ? 1.0F : 0.0F;
  }
  ContourMap contours() const { return find_contours({mask, position, face_normal, kFocal_px}); }
};

constexpr std::array<std::pair<int, int>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};

TEST(Contours, OfADiscAreExactlyItsBoundaryPixels) {
  constexpr int kSize = 40;
  const auto inside = [](int x, int y) { return std::hypot(x - 18.3, y - 21.7) < 12.0; };
  Picture picture(kSize, kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      if (inside(x, y)) picture.set(x, y, 500.0);
    }
  }
  const ContourMap map = picture.contours();
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const bool boundary =
          inside(x, y) && std::any_of(kNeighbours.begin(), kNeighbours.end(), [&](const auto& step) {
            return !inside(x + step.first, y + step.second);
          });
      ASSERT_EQ(map.contour[map.index(x, y)], boundary ? ContourClass::outer : ContourClass::none)
          << x << " " << y;
      ASSERT_EQ(map.nearest[map.index(x, y)], inside(x, y) ? ContourClass::outer : ContourClass::none);
      ASSERT_EQ(map.mask_edge[map.index(x, y)], 0);
    }
  }
}

// Two plateaus that face the viewer: a facet predicts no step, so any gap above 0.5 mm separates.
ContourMap two_plateaus(double left_mm, double right_mm) {
  Picture picture(8, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 8; ++x) picture.set(x, y, x < 4 ? left_mm : right_mm);
  }
  return picture.contours();
}

TEST(Contours, KeepTheNearAndTheFarSideApart) {
  for (const bool left_is_near : {true, false}) {
    const ContourMap map = left_is_near ? two_plateaus(500.0, 510.0) : two_plateaus(510.0, 500.0);
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 8; ++x) {
        const bool near_side = (x < 4) == left_is_near;
        const ContourClass side = near_side ? ContourClass::inner_near : ContourClass::inner_far;
        const bool beside = x == 3 || x == 4;
        ASSERT_EQ(map.contour[map.index(x, y)], beside ? side : ContourClass::none) << x << " " << y;
        // Each pixel is nearest to the contour pixel of its own plateau.
        ASSERT_EQ(map.nearest[map.index(x, y)], side);
      }
    }
  }
}

// Depths are floats: near 500 their spacing is 3e-5 mm, far below the 0.01 mm beside the bound.
TEST(Contours, NeedAGapOfHalfAMillimetre) {
  EXPECT_EQ(two_plateaus(500.0, 500.49).contour[3], ContourClass::none);
  EXPECT_EQ(two_plateaus(500.0, 500.51).contour[3], ContourClass::inner_near);
}

// The depth at which a pixel's ray meets the plane through (0, 0, -distance) whose normal is tilted by the
// angle about y: with t its tangent and u = x/-z of the ray, distance / (1 - u t).
double tilted_depth_mm(const Picture& picture, int x, int y, double distance_mm, double tangent) {
  return distance_mm / (1.0 - picture.ray(x, y).x() * tangent);
}

Vec3d tilted_normal(double tangent) { return Vec3d(tangent, 0.0, 1.0).normalized(); }

// At 85 degrees a pixel's step in depth is 4 to 14 mm, but it is the step that the facets predict. The same
// depths with facets that face the viewer, which predict no step, are separated everywhere.
TEST(Contours, ASteepPlaneIsNotSeparated) {
  const double tangent = std::tan(85.0 * kPi / 180.0);
  Picture steep(64, 4);
  Picture steps(64, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 64; ++x) {
      const double depth = tilted_depth_mm(steep, x, y, 500.0, tangent);
      steep.set(x, y, depth, tilted_normal(tangent));
      steps.set(x, y, depth);
    }
  }
  const ContourMap of_plane = steep.contours();
  const ContourMap of_steps = steps.contours();
  for (std::size_t i = 0; i < of_plane.contour.size(); ++i) {
    ASSERT_EQ(of_plane.contour[i], ContourClass::none) << i;
    ASSERT_EQ(of_plane.delta_mm[i], std::numeric_limits<double>::infinity());
    ASSERT_NE(of_steps.contour[i], ContourClass::none) << i;
  }
}

// Two parallel tilted planes meet between columns 31 and 32, the right one farther by g along the axis. With
// p the step that the left facet predicts, g = (k - 1) p (1 - u t) makes the gap k p. The right facet
// predicts p (1 + g/500): p is 5.7 mm, so for k = 4 that is 1.034 p. So k = 3.9 lies below 4 times the larger
// prediction, and k = 4.3 > 4 * (1 + 3.3 * 5.8/500) = 4.15 above it.
ContourClass class_at_parallel_gap(double k) {
  const double tangent = std::tan(85.0 * kPi / 180.0);
  Picture picture(64, 1);
  const double left = tilted_depth_mm(picture, 31, 0, 500.0, tangent);
  const double predicted = tilted_depth_mm(picture, 32, 0, 500.0, tangent) - left;
  const double g = (k - 1.0) * predicted * (1.0 - picture.ray(32, 0).x() * tangent);
  for (int x = 0; x < 64; ++x) {
    picture.set(x, 0, tilted_depth_mm(picture, x, 0, x < 32 ? 500.0 : 500.0 + g, tangent),
                tilted_normal(tangent));
  }
  return picture.contours().contour[31];
}

TEST(Contours, NeedFourTimesThePredictedStep) {
  EXPECT_EQ(class_at_parallel_gap(3.9), ContourClass::none);
  EXPECT_EQ(class_at_parallel_gap(4.3), ContourClass::inner_near);
}

TEST(Contours, AMaskEdgeIsNoSilhouette) {
  Picture picture(8, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 8; ++x) picture.set(x, y, 500.0, Vec3d::UnitZ(), x < 4);
  }
  const ContourMap map = picture.contours();
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 8; ++x) {
      ASSERT_EQ(map.contour[map.index(x, y)], ContourClass::none);
      ASSERT_EQ(map.mask_edge[map.index(x, y)], x == 3 ? 1 : 0) << x << " " << y;
      ASSERT_EQ(map.nearest[map.index(x, y)], ContourClass::none);
    }
  }
}

// Cloth behind or before skin occludes like any surface; and what is no skin is never a contour itself.
TEST(Contours, SkinBesideSeparatedClothIsASilhouette) {
  Picture picture(4, 1);
  for (int x = 0; x < 4; ++x) picture.set(x, 0, x < 2 ? 500.0 : 520.0, Vec3d::UnitZ(), x < 2);
  const ContourMap map = picture.contours();
  EXPECT_EQ(map.contour, (std::vector<ContourClass>{ContourClass::none, ContourClass::inner_near,
                                                    ContourClass::none, ContourClass::none}));
  EXPECT_EQ(map.mask_edge, (std::vector<char>{0, 0, 0, 0}));
}

// A pixel beside the background and beside a nearer surface is an outer contour: outer over near over far.
TEST(Contours, OuterOutranksNearOutranksFar) {
  Picture picture(3, 1);
  picture.set(1, 0, 510.0);
  picture.set(2, 0, 500.0);
  EXPECT_EQ(picture.contours().contour[1], ContourClass::outer);
  picture.set(0, 0, 520.0);
  EXPECT_EQ(picture.contours().contour[1], ContourClass::inner_near);
}

TEST(Contours, TheFramesBorderIsNone) {
  Picture picture(6, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 6; ++x) picture.set(x, y, 500.0);
  }
  const ContourMap map = picture.contours();
  for (std::size_t i = 0; i < map.contour.size(); ++i) {
    ASSERT_EQ(map.contour[i], ContourClass::none);
    ASSERT_EQ(map.nearest[i], ContourClass::none);
    ASSERT_EQ(map.delta_mm[i], std::numeric_limits<double>::infinity());
  }
}

// 3 pixels to the right and 4 down of the only contour pixel: 5 px * 500 mm / 1000 px = 2.5 mm.
TEST(Contours, DeltaIsPixelsTimesDepthOverFocalLength) {
  Picture picture(12, 12);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 12; ++x) picture.set(x, y, 500.0);
  }
  picture.position.set_rgb(0, 0,
                           Vec3d::Zero());  // background in the corner: (1, 0) and (0, 1) become contours
  picture.mask.at(0, 0, 0) = 0.0F;
  const ContourMap map = picture.contours();
  EXPECT_EQ(map.delta_mm[map.index(1, 0)], 0.0);
  EXPECT_DOUBLE_EQ(map.delta_mm[map.index(4, 0)], 1.5);  // 3 px from (1, 0)
  EXPECT_DOUBLE_EQ(map.delta_mm[map.index(4, 4)], 2.5);  // (3, 4) from (1, 0), (4, 3) from (0, 1)
  EXPECT_EQ(map.delta_mm[map.index(0, 0)], std::numeric_limits<double>::infinity());  // no skin
}

struct Case {
  int width;
  int height;
  double holes;
};

class DistanceTransform : public testing::TestWithParam<Case> {};

// Random holes and random plateaus give contours of every class; each pixel's distance is held against the
// smallest over all contour pixels. Squared distances are whole numbers, so what is left is the rounding of
// one root, one product and one quotient, which EXPECT_DOUBLE_EQ's 4 ulp cover.
TEST_P(DistanceTransform, AgreesWithBruteForce) {
  const auto [width, height, holes] = GetParam();
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int round = 0; round < 20; ++round) {
    Picture picture(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (uniform(generator) >= holes) picture.set(x, y, uniform(generator) < holes ? 520.0 : 500.0);
      }
    }
    const ContourMap map = picture.contours();
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (picture.mask.at(x, y, 0) == 0.0F) continue;
        double nearest_px = std::numeric_limits<double>::infinity();
        for (int cy = 0; cy < height; ++cy) {
          for (int cx = 0; cx < width; ++cx) {
            if (map.contour[map.index(cx, cy)] == ContourClass::none) continue;
            nearest_px = std::min(nearest_px, std::sqrt((cx - x) * (cx - x) + (cy - y) * (cy - y)));
          }
        }
        bool class_is_of_a_nearest =
            !std::isfinite(nearest_px) && map.nearest[map.index(x, y)] == ContourClass::none;
        for (int cy = 0; cy < height; ++cy) {
          for (int cx = 0; cx < width; ++cx) {
            const ContourClass found = map.contour[map.index(cx, cy)];
            if (found == ContourClass::none || found != map.nearest[map.index(x, y)]) continue;
            if (std::sqrt((cx - x) * (cx - x) + (cy - y) * (cy - y)) == nearest_px)
              class_is_of_a_nearest = true;
          }
        }
        const double depth_mm = -static_cast<double>(picture.position.at(x, y, 2));
        ASSERT_DOUBLE_EQ(map.delta_mm[map.index(x, y)], nearest_px * depth_mm / kFocal_px) << x << " " << y;
        ASSERT_TRUE(class_is_of_a_nearest) << x << " " << y;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, DistanceTransform,
                         testing::Values(Case{23, 17, 0.01}, Case{17, 23, 0.002}, Case{16, 16, 0.3},
                                         Case{31, 1, 0.05}, Case{1, 31, 0.05}, Case{1, 1, 0.0},
                                         Case{20, 20, 0.0}));

}  // namespace
}  // namespace truescatter
