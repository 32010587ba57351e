#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "experiment/scene_truths.h"
#include "experiment/view_truth.h"
#include "support/random.h"

namespace truescatter::test {

// A picture, one pixel high, of these points of the scene's mesh.
inline FrameImages images_of(const PreparedScene& scene, const std::vector<MeshPoint>& places) {
  FrameImages images;
  const auto width = static_cast<int>(places.size());
  images.mask = Image(width, 1, 1, 1.0F);
  images.face_normal = Image(width, 1, 3);
  for (int x = 0; x < width; ++x) {
    const MeshPoint& place = places[static_cast<std::size_t>(x)];
    images.face_normal.set_rgb(x, 0, triangle_normal(scene.mesh, place.triangle));
    PixelSurface seen;
    for (std::size_t t = 0; t < scene.shading.triangles.size(); ++t) {
      const ShadingTriangle& triangle = scene.shading.triangles[t];
      if (triangle.base != place.triangle) continue;
      Mat3d corners;
      for (int c = 0; c < 3; ++c) corners.col(c) = triangle.base_barycentric[static_cast<std::size_t>(c)];
      const Vec3d inside = corners.inverse() * place.barycentric;
      if (inside.minCoeff() >= 0.0) seen = {static_cast<int>(t), inside};
    }
    images.surface.push_back(seen);
  }
  return images;
}

inline std::vector<MeshPoint> random_places(const Mesh& mesh, std::size_t count) {
  std::mt19937_64 generator(11);
  std::vector<MeshPoint> places;
  for (std::size_t i = 0; i < count; ++i) {
    const double root = std::sqrt(uniform(generator));
    const double b = uniform(generator);
    places.push_back({generator() % mesh.triangle_count(), Vec3d(1.0 - root, root * (1.0 - b), root * b)});
  }
  return places;
}

inline Profile two_gaussians() {
  Profile profile;
  profile.name = "two";
  profile.delta_weight = Vec3d(0.1, 0.2, 0.0);
  profile.terms = {{Vec3d(0.5, 0.5, 0.5), Vec3d(0.4, 0.5, 0.7)},
                   {Vec3d(4.0, 4.0, 4.0), Vec3d(0.5, 0.3, 0.3)}};
  profile.r_max_mm = 6.0;
  return profile;
}

// One target's truth of a scene at some places, every one of them audited. `visible`: where the target is of
// the visible surface only.
inline TruthImage truth_of(const PreparedScene& scene, const std::vector<MeshPoint>& places,
                           const OwnTarget& target, const VisibleSurface* visible = nullptr) {
  TruthSpec spec;
  spec.audit_points = static_cast<int>(places.size());
  const SceneTruths truths(scene, spec, target.geodesic);
  EXPECT_EQ(truths.obstacle(target), "");
  const FrameImages images = images_of(scene, places);
  ViewTruth truth(scene, images);
  EXPECT_EQ(truth.points().size(), places.size());
  const Profile profile = two_gaussians();
  truth.compute(
      {{&profile, target}}, spec,
      [&](LayerKind kind, const ViewPoints& points) { return truths.source(kind, points, visible); },
      truths.geodesic());
  EXPECT_EQ(truth.audited().points.size(), places.size());
  return truth.image({&profile, target});
}

inline double largest_difference(const Image& a, const Image& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.data().size(); ++i)
    largest = std::max(largest, static_cast<double>(std::abs(a.data()[i] - b.data()[i])));
  return largest;
}

}  // namespace truescatter::test
