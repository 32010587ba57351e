#include "irradiance/normal_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>

#include "core/image_io.h"
#include "irradiance/shading_mesh.h"
#include "scene/builtin.h"
#include "scene/load_mesh.h"
#include "support/lamp.h"

namespace truescatter {
namespace {

using test::lamp;

constexpr double kDegree = kPi / 180.0;

// A lamp `degrees` from +z towards +x.
Light lamp_towards_x(double degrees) {
  return lamp({std::sin(degrees * kDegree), 0.0, std::cos(degrees * kDegree)});
}

Vec3d texel_of(const Vec3d& normal) { return 0.5 * (normal + Vec3d::Ones()); }

// A map that leans everywhere by `degrees` along u (or along v).
Image tilted(double degrees, bool along_v = false) {
  const double sine = std::sin(degrees * kDegree);
  Image image(4, 4, 3);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      image.set_rgb(x, y,
                    texel_of({along_v ? 0.0 : sine, along_v ? sine : 0.0, std::cos(degrees * kDegree)}));
    }
  }
  return image;
}

Image noise(int size, unsigned seed) {
  std::mt19937 generator(seed);
  Image image(size, size, 3);
  for (float& v : image.data()) v = 0.3F + 0.4F * static_cast<float>(generator() >> 8U) / 16777216.0F;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) image.at(x, y, 2) += 0.3F;
  }
  return image;
}

ShadingMesh shade(const Mesh& mesh, const Light& light, const Image& map,
                  const NormalMapSettings& settings = {}, const RefinementSettings& refinement = {}) {
  return make_shading_mesh(mesh, Lighting(mesh, {light}, NormalMap(mesh, map, settings)), {}, refinement);
}

// The plane's values are stored in single precision: 2^-24 of 1 in each texel, doubled by 2c - 1, times the
// lamp's two components; 3e-7 in all.
constexpr double kSingle = 3e-7;

TEST(NormalMap, AUniformTiltTurnsThePlanesNormal) {
  // On the plane u runs along x and v along y. Leaning 30 degrees towards a lamp at 20 degrees leaves 10.
  const Mesh plane = make_builtin("plane");
  const ShadingMesh shading = shade(plane, lamp_towards_x(20.0), tilted(30.0));
  EXPECT_EQ(shading.triangles.size(), plane.triangle_count());
  for (const ShadingTriangle& t : shading.triangles) {
    for (const Vec3d& value : t.irradiance) EXPECT_NEAR(value.x(), std::cos(10.0 * kDegree), kSingle);
    // The map enters through I alone.
    for (const Vec3d& normal : t.normals) EXPECT_EQ(normal, Vec3d::UnitZ());
  }
}

TEST(NormalMap, GreenIsAlongVUnlessItIsSaidToBeDown) {
  const Mesh plane = make_builtin("plane");
  const Light above = lamp({0.0, std::sin(20.0 * kDegree), std::cos(20.0 * kDegree)});
  const auto value = [&](const NormalMapSettings& settings) {
    return shade(plane, above, tilted(30.0, true), settings).triangles[3].irradiance[0].x();
  };
  EXPECT_NEAR(value({1.0, false}), std::cos(10.0 * kDegree), kSingle);
  EXPECT_NEAR(value({1.0, true}), std::cos(50.0 * kDegree), kSingle);
}

TEST(NormalMap, StrengthMultipliesTheSlope) {
  // tan 20 degrees times `strength`, against a lamp at 20 degrees.
  const Mesh plane = make_builtin("plane");
  for (const double strength : {0.0, 0.5, 1.0, 3.0}) {
    const double lean = std::atan(strength * std::tan(20.0 * kDegree));
    const ShadingMesh shading = shade(plane, lamp_towards_x(20.0), tilted(20.0), {strength, false});
    EXPECT_NEAR(shading.triangles[0].irradiance[1].x(), std::cos(lean - 20.0 * kDegree), 3.0 * kSingle);
  }
}

TEST(NormalMap, ATexelBelowTheSurfaceIsLaidIntoIt) {
  const Mesh plane = make_builtin("plane");
  // 120 degrees from the plane's normal become 90.
  const ShadingMesh below = shade(plane, lamp_towards_x(20.0), tilted(120.0));
  EXPECT_NEAR(below.triangles[0].irradiance[0].x(), std::cos(70.0 * kDegree), kSingle);
  // Grey has no direction at all: the interpolated normal.
  const ShadingMesh grey = shade(plane, lamp_towards_x(20.0), Image(4, 4, 3, 0.5F));
  EXPECT_NEAR(grey.triangles[0].irradiance[0].x(), std::cos(20.0 * kDegree), 1e-12);
}

TEST(NormalMap, ABumpIsBrightTowardsTheLamp) {
  // h = 2 exp(-r^2 / (2 8^2)) mm on a plane of 60 mm, in a map of 256 texels; n is along (-dh/dx, -dh/dy, 1).
  // Between texels (0.234 mm) the normal's components are off by at most 0.234^2 / 8 times their second
  // derivatives along u and along v, each at most max |h'''| = 1.38 * 2 / 8^3 = 0.0054 for slopes below 0.16:
  // 7e-5 in a component, 1e-4 in n.l with the lamp's two.
  constexpr double kHeight = 2.0;
  constexpr double kWidth = 8.0;
  const auto normal_at = [](double x, double y) {
    const double h = kHeight * std::exp(-(x * x + y * y) / (2.0 * kWidth * kWidth));
    return Vec3d(h * x / (kWidth * kWidth), h * y / (kWidth * kWidth), 1.0).normalized();
  };
  Image map(256, 256, 3);
  for (int row = 0; row < 256; ++row) {
    for (int column = 0; column < 256; ++column) {
      const double x = 60.0 * ((column + 0.5) / 256.0 - 0.5);
      const double y = 60.0 * (0.5 - (row + 0.5) / 256.0);
      map.set_rgb(column, row, texel_of(normal_at(x, y)));
    }
  }
  const Mesh plane = make_builtin("plane");
  const Light light = lamp({2.0, 1.0, 1.0});
  const ShadingMesh shading = shade(plane, light, map);
  double brightest = 0.0;
  Vec3d brightest_at = Vec3d::Zero();
  for (const ShadingTriangle& t : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d& p = shading.corner(t, c);
      // The map repeats: the outermost half texel mixes with the other side.
      if (p.head<2>().cwiseAbs().maxCoeff() > 29.8) continue;
      EXPECT_NEAR(t.irradiance[c].x(), normal_at(p.x(), p.y()).dot(light.direction), 1e-4) << p.transpose();
      if (t.irradiance[c].x() > brightest) {
        brightest = t.irradiance[c].x();
        brightest_at = p;
      }
    }
  }
  // The steepest slope towards the lamp is one width from the top in its direction; vertices are 2 mm apart.
  EXPECT_LT((brightest_at - kWidth * Vec3d(2.0, 1.0, 0.0).normalized()).norm(), 2.0);
}

TEST(NormalMap, AFlatMapOfEightBitsLeansByItsRoundingOnly) {
  // 128 of 255 stands for 1/255, along both axes: atan(sqrt 2 / 255) off the normal, and n.l changes by no
  // more than the angle.
  const Mesh sphere = make_builtin("sphere", {{"edge_mm", 4.0}});
  const Light light = lamp({0.3, 0.5, 1.0});
  Image flat(8, 8, 3);
  for (int i = 0; i < 64; ++i) flat.set_rgb(i % 8, i / 8, Vec3d(128.0, 128.0, 255.0) / 255.0);
  const ShadingMesh plain = make_shading_mesh(sphere, Lighting(sphere, {light}), {}, {});
  const ShadingMesh mapped = shade(sphere, light, flat);
  const ShadingMesh without_slope = shade(sphere, light, noise(32, 1), {0.0, false});
  // Splits follow the smooth lighting, so the three have the same triangles.
  ASSERT_EQ(mapped.triangles.size(), plain.triangles.size());
  ASSERT_EQ(without_slope.triangles.size(), plain.triangles.size());
  double largest = 0.0;
  for (std::size_t t = 0; t < plain.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d& expected = plain.triangles[t].irradiance[c];
      largest = std::max(largest, (mapped.triangles[t].irradiance[c] - expected).norm() / std::sqrt(3.0));
      EXPECT_LT((without_slope.triangles[t].irradiance[c] - expected).norm(), 1e-12);
    }
  }
  EXPECT_LE(largest, std::atan(std::sqrt(2.0) / 255.0) + kSingle);
  EXPECT_GT(largest, 0.5 / 255.0);
}

// A strip of 20 x 10 mm in z = 0. Its left half is mirrored in UV: u = |x| / 10 on both sides, v = y / 10.
Mesh mirrored_strip() {
  Mesh mesh;
  mesh.corner_uvs.emplace();
  mesh.positions_mm = {{-10.0, 0.0, 0.0},  {0.0, 0.0, 0.0},  {10.0, 0.0, 0.0},
                       {-10.0, 10.0, 0.0}, {0.0, 10.0, 0.0}, {10.0, 10.0, 0.0}};
  mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec2d, 3> uvs;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d& p = mesh.positions_mm[static_cast<std::size_t>(triangle[c])];
      uvs[c] = Vec2d(0.1 * std::abs(p.x()), 0.1 * p.y());
    }
    mesh.corner_uvs->push_back(uvs);
  }
  set_angle_weighted_normals(mesh);
  return mesh;
}

TEST(NormalMap, AMirroredChartHasMirroredRelief) {
  // Leaning 30 degrees along u is away from the middle on both sides; on the middle line the two normals
  // differ, and their mean is the plane's own.
  const Mesh strip = mirrored_strip();
  const ShadingMesh shading = shade(strip, lamp_towards_x(20.0), tilted(30.0));
  for (const ShadingTriangle& t : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double x = shading.corner(t, c).x();
      const double angle = x > 0.0 ? 10.0 : x < 0.0 ? 50.0 : 20.0;
      EXPECT_NEAR(t.irradiance[c].x(), std::cos(angle * kDegree), kSingle) << x;
    }
  }
  // Along v nothing is mirrored: 30 degrees from a lamp at 20 the other way.
  const Light above = lamp({0.0, std::sin(20.0 * kDegree), std::cos(20.0 * kDegree)});
  for (const ShadingTriangle& t : shade(strip, above, tilted(30.0, true)).triangles) {
    for (const Vec3d& value : t.irradiance) EXPECT_NEAR(value.x(), std::cos(10.0 * kDegree), kSingle);
  }
}

TEST(NormalMap, AVertexHasOneIrradianceForAllItsCharts) {
  // Six charts under noise: along their borders the map has two normals or three for one place.
  const Mesh sphere = make_builtin("sphere", {{"edge_mm", 4.0}});
  const NormalMap map(sphere, noise(64, 2), {});
  std::map<int, Vec3d> mapped;
  double largest_step = 0.0;
  for (std::size_t t = 0; t < sphere.triangle_count(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const Vec3d normal = map.normal(sphere, {t, Vec3d::Unit(c)});
      const auto [entry, fresh] =
          mapped.try_emplace(sphere.triangles[t][static_cast<std::size_t>(c)], normal);
      if (!fresh) largest_step = std::max(largest_step, (entry->second - normal).norm());
    }
  }
  EXPECT_GT(largest_step, 0.1);

  RefinementSettings refinement;
  refinement.views = {Camera()};
  refinement.visible_edge_mm = 2.5;
  const ShadingMesh shading = shade(sphere, lamp({0.3, 0.5, 1.0}), noise(64, 2), {}, refinement);
  EXPECT_GT(shading.triangles.size(), sphere.triangle_count());
  std::map<int, Vec3d> irradiance;
  for (const ShadingTriangle& t : shading.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [entry, fresh] = irradiance.try_emplace(t.vertices[c], t.irradiance[c]);
      if (!fresh) {
        EXPECT_EQ(entry->second, t.irradiance[c]);
      }
    }
  }
}

TEST(NormalMap, IsContinuousInsideAChart) {
  // Across an edge inside a chart the tangents are shared: the mapped normals on both sides of its midpoint
  // differ by rounding only, though the facets' own tangents differ by their dihedral angle.
  const Mesh sphere = make_builtin("sphere", {{"edge_mm", 8.0}});
  const NormalMap map(sphere, noise(16, 3), {});
  std::map<std::uint64_t, std::vector<MeshPoint>> sides;
  for (std::size_t t = 0; t < sphere.triangle_count(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      MeshPoint middle{t, Vec3d::Zero()};
      middle.barycentric[static_cast<Eigen::Index>(c)] = 0.5;
      middle.barycentric[static_cast<Eigen::Index>((c + 1) % 3)] = 0.5;
      sides[edge_key(sphere.triangles[t][c], sphere.triangles[t][(c + 1) % 3])].push_back(middle);
    }
  }
  const auto uv = [&](const MeshPoint& point) {
    Vec2d sum = Vec2d::Zero();
    for (int c = 0; c < 3; ++c)
      sum += point.barycentric[c] * (*sphere.corner_uvs)[point.triangle][static_cast<std::size_t>(c)];
    return sum;
  };
  int inside = 0;
  for (const auto& [edge, points] : sides) {
    ASSERT_EQ(points.size(), 2U);
    if ((uv(points[0]) - uv(points[1])).norm() > 1e-9) continue;  // a chart's border
    ++inside;
    EXPECT_LT((map.normal(sphere, points[0]) - map.normal(sphere, points[1])).norm(), 1e-6);
  }
  EXPECT_GT(inside, 100);
}

TEST(Refinement, VisibleSkinHasNoLongerEdgeThanIsStated) {
  // A camera that sees a part of the sphere's front; all of its edges are about 4 mm long beforehand.
  constexpr double kEdge = 1.0;
  const Mesh sphere = make_builtin("sphere", {{"edge_mm", 4.0}});
  Camera camera;
  camera.eye_mm = Vec3d(0.0, 0.0, 200.0);
  camera.target_mm = Vec3d(4.0, 3.0, 0.0);
  camera.fov_y_deg = 6.0;
  camera.width_px = 120;
  camera.height_px = 100;
  // Skin from the middle of the front's chart to the right.
  Image right(64, 64, 1);
  for (int y = 0; y < 64; ++y) {
    for (int x = 11; x < 64; ++x) right.at(x, y, 0) = 1.0F;
  }
  RefinementSettings settings{1.0, 100.0};  // lighting asks for nothing
  settings.views = {camera};
  settings.visible_edge_mm = kEdge;
  const Lighting lighting(sphere, {lamp({0.0, 0.0, 1.0})});
  for (const SkinMask& mask : {SkinMask(), SkinMask(right)}) {
    const ShadingMesh shading = make_shading_mesh(sphere, lighting, mask, settings);
    // By another route: what the projection puts inside the picture.
    const Mat4d to_clip = camera.projection_matrix(10.0, 1000.0) * camera.view_matrix();
    int seen = 0;
    int coarse = 0;
    int coarse_in_picture = 0;
    for (const ShadingTriangle& t : shading.triangles) {
      double longest = 0.0;
      bool in_picture = false;
      double nearest_to_picture = 1e9;
      for (std::size_t c = 0; c < 3; ++c) {
        longest = std::max(longest, (shading.corner(t, (c + 1) % 3) - shading.corner(t, c)).norm());
        const Vec4d clip = to_clip * shading.corner(t, c).homogeneous();
        const double out = std::max(std::abs(clip.x()), std::abs(clip.y())) / clip.w();
        in_picture = in_picture || out < 1.0;
        nearest_to_picture = std::min(nearest_to_picture, out);
      }
      const Vec3d a = shading.corner(t, 0);
      const Vec3d normal = (shading.corner(t, 1) - a).cross(shading.corner(t, 2) - a);
      const bool faces = normal.dot(camera.eye_mm - a) > 0.0;
      if (faces && in_picture && t.skin) {
        ++seen;
        EXPECT_LE(longest, kEdge);
      }
      if (faces && in_picture && !t.skin && longest > 2.0) ++coarse_in_picture;
      // Far from what is seen, beyond the closure's reach, nothing is refined.
      if (!faces || nearest_to_picture > 2.0) {
        if (longest > 2.0) ++coarse;
        if (a.z() < -10.0) {
          EXPECT_GT(longest, 2.0);
        }
      }
    }
    EXPECT_GT(seen, 100);
    EXPECT_GT(coarse, 100);
    EXPECT_EQ(coarse_in_picture > 0, !mask.everywhere());
  }
}

TEST(NormalMap, OfTheScannedHead) {
  const char* const data = std::getenv("TRUESCATTER_DATA");
  const std::filesystem::path folder =
      (data != nullptr ? std::filesystem::path(data)
                       : std::filesystem::path(TRUESCATTER_SOURCE_DIR) / "../shared/data") /
      "lps";
  if (!std::filesystem::exists(folder / "lps_head.obj"))
    GTEST_SKIP() << "no lps/lps_head.obj under TRUESCATTER_DATA or beside the checkout";
  LoadOptions options;
  options.unit_mm = 1000.0;
  const Mesh head = load_mesh(folder / "lps_head.obj", options);
  const NormalMap map(head, read_image(folder / "normal_tangent_1024.jpg"), {});
  // Relief about the surface that the mesh has already: on average it leans nowhere (by less than a degree,
  // area by area), and typically by more than the storage does.
  double area = 0.0;
  double lean = 0.0;
  Vec3d drift = Vec3d::Zero();
  for (std::size_t t = 0; t < head.triangle_count(); ++t) {
    const MeshPoint middle{t, Vec3d::Constant(1.0 / 3.0)};
    const Vec3d mapped = map.normal(head, middle);
    ASSERT_NEAR(mapped.norm(), 1.0, 1e-12);
    const Vec3d change = mapped - interpolated_normal(head, middle);
    const double weight = triangle_area_mm2(head, t);
    area += weight;
    lean += weight * change.norm();
    drift += weight * change;
  }
  EXPECT_LT(drift.norm() / area, kDegree);
  EXPECT_GT(lean / area, 2.0 * std::sqrt(2.0) / 255.0);
  EXPECT_LT(lean / area, 15.0 * kDegree);
}

}  // namespace
}  // namespace truescatter
