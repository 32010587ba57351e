#include "experiment/audit_sample.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "experiment/points_fixture.h"
#include "scene/builtin.h"

namespace truescatter::test {
namespace {

// A built-in scene of 20 mm with edges of 5 mm, and 400 of its points; masses are 1 but at point 17.
class AuditSampleOf {
 public:
  explicit AuditSampleOf(const std::string& name) {
    scene_.mesh = make_builtin(name, {{"size_mm", 20.0}, {"edge_mm", 5.0}});
    scene_.shading = make_shading_mesh(scene_.mesh, Lighting(scene_.mesh, {Light{}}), SkinMask(), {1.0, 5.0});
    images_ = images_of(scene_, random_places(scene_.mesh, 400));
    points_ = view_points(scene_, images_);
    masses_[17][3] = 1.5;
  }

  AuditSample draw(std::size_t wanted, bool geodesic) {
    const SceneTruths truths(scene_, TruthSpec{}, geodesic);
    return draw_audit_sample({scene_.shading, images_, points_, masses_, truths.geodesic()}, wanted, 1);
  }
  // The points of a class, in the order in which they were chosen.
  static std::vector<std::uint32_t> of_class(const AuditSample& sample, const std::string& wanted) {
    std::size_t first = 0;
    for (const auto& [name, count] : sample.classes) {
      if (name == wanted) {
        const auto begin = sample.points.begin() + static_cast<std::ptrdiff_t>(first);
        return {begin, begin + static_cast<std::ptrdiff_t>(count)};
      }
      first += name == "random" ? sample.random_count : count;
    }
    return {};
  }
  Vec3d position(std::uint32_t point) const { return points_.on_surface[point].position_mm; }
  const ViewPoints& points() const { return points_; }

  // Distinct points, as many as the classes say.
  static void expect_consistent(const AuditSample& sample, std::size_t wanted) {
    EXPECT_EQ(std::set<std::uint32_t>(sample.points.begin(), sample.points.end()).size(), wanted);
    EXPECT_EQ(sample.points.size(), wanted);
    EXPECT_EQ(sample.random_count, (wanted + 1) / 2);
    std::size_t sum = 0;
    for (const auto& [name, count] : sample.classes) sum += count;
    EXPECT_EQ(sum, wanted);
  }

 private:
  PreparedScene scene_;
  FrameImages images_;
  ViewPoints points_;
  std::vector<Vec4d> masses_ = std::vector<Vec4d>(400, Vec4d(0.0, 0.0, 0.0, 1.0));
};

// Half of 96 at random, and a quarter of the rest of each class: 12 points. Of the 32 triangles of an open
// square 24 touch its border, so no two of a class need be on one.
TEST(AuditSample, LooksAtTheEdgesOfAnOpenSurface) {
  AuditSampleOf plane("plane");
  const AuditSample sample = plane.draw(96, false);
  AuditSampleOf::expect_consistent(sample, 96);
  EXPECT_EQ(sample.random_count, 48U);
  const std::vector<std::uint32_t> edge = AuditSampleOf::of_class(sample, "mask_edge");
  ASSERT_EQ(edge.size(), 12U);
  std::set<int> triangles;
  double last_mm = 0.0;
  for (const std::uint32_t point : edge) {
    const double distance_mm = 10.0 - plane.position(point).cwiseAbs().maxCoeff();
    EXPECT_LE(distance_mm, 5.0);
    EXPECT_GE(distance_mm, last_mm) << "not the nearest first";
    last_mm = distance_mm;
    triangles.insert(plane.points().triangles[point]);
  }
  EXPECT_EQ(triangles.size(), edge.size());
  EXPECT_TRUE(AuditSampleOf::of_class(sample, "cut_locus").empty());
}

// A box has no edge of the skin; its eight corners, which a quarter of a turn is missing from, start its cut
// loci.
TEST(AuditSample, LooksAtTheCornersOfABoxForGeodesics) {
  AuditSampleOf slab("slab");
  const AuditSample sample = slab.draw(96, true);
  AuditSampleOf::expect_consistent(sample, 96);
  EXPECT_TRUE(AuditSampleOf::of_class(sample, "mask_edge").empty());
  for (const char* name : {"shadow_edge", "crease", "smallest_s", "cut_locus"})
    EXPECT_EQ(AuditSampleOf::of_class(sample, name).size(), 12U) << name;
  for (const std::uint32_t point : AuditSampleOf::of_class(sample, "cut_locus")) {
    // In a triangle that touches a corner, so within one edge of 5 mm of it along x and y.
    EXPECT_GE(std::abs(slab.position(point).x()), 5.0 - 1e-9);
    EXPECT_GE(std::abs(slab.position(point).y()), 5.0 - 1e-9);
  }
}

// The one point whose narrowest mass is not 1 is in, whatever was drawn; and the draw is the seed's.
TEST(AuditSample, LooksWhereTheNarrowestMassIsOff) {
  AuditSampleOf slab("slab");
  const AuditSample sample = slab.draw(96, false);
  EXPECT_TRUE(std::find(sample.points.begin(), sample.points.end(), 17U) != sample.points.end());
  EXPECT_EQ(slab.draw(96, false).points, sample.points);
}

TEST(AuditSample, TakesAllWhereThereAreFew) {
  AuditSampleOf slab("slab");
  AuditSampleOf::expect_consistent(slab.draw(1000, true), 400);
}

}  // namespace
}  // namespace truescatter::test
