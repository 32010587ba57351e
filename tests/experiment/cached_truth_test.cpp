#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "experiment/cached_source.h"
#include "experiment/scene_truths.h"
#include "scene/builtin.h"
#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

// Two points; a layer's values are its own, and told apart by the number of the computation.
class CountingSource : public LayerSource {
 public:
  CountingSource(int& computations, bool together) : computations_(computations), together_(together) {}

  std::vector<ComputedLayer> compute(std::span<const TruthLayer> layers,
                                     const std::function<void(std::size_t)>& advance) const override {
    std::vector<ComputedLayer> computed;
    for (const TruthLayer& layer : layers) {
      ++computations_;
      computed.push_back(
          {std::vector<Vec4d>(2, Vec4d::Constant(layer.std_dev_mm + 0.125 * computations_)), 0.5});
      advance(2);
    }
    return computed;
  }
  TruthValues audit_values(std::span<const std::uint32_t> chosen,
                           std::span<const TruthLayer> layers) const override {
    ++computations_;
    return TruthValues(layers.size(), std::vector<Vec4d>(chosen.size(), Vec4d::Constant(computations_)));
  }
  double tail_bound() const override { return 0.0; }
  double largest_irradiance() const override { return 1.0; }
  std::size_t point_count() const override { return 2; }
  bool computes_together() const override { return together_; }
  std::string content_key() const override { return "counting"; }

 private:
  int& computations_;
  bool together_;
};

class CachedSourceTest : public testing::Test {
 protected:
  // Layers from the cache or computed, and kept; how many were computed.
  int computed(const std::vector<TruthLayer>& layers, bool together = false) {
    const std::unique_ptr<LayerSource> source =
        cached_source(std::make_unique<CountingSource>(computations_, together), cache_);
    const int before = computations_;
    std::size_t steps = 0;
    last_ = source->compute(layers, [&](std::size_t n) { steps += n; });
    EXPECT_EQ(steps, 2 * layers.size());
    for (std::size_t l = 0; l < layers.size(); ++l) source->keep(layers, l, last_[l]);
    return computations_ - before;
  }

  TempDir folder_;
  TruthCache cache_{folder_.path(), 1 << 20};
  int computations_ = 0;
  std::vector<ComputedLayer> last_;
};

TEST_F(CachedSourceTest, ComputesEachLayerOnce) {
  EXPECT_EQ(computed({{1.0}, {2.0}}), 2);
  const std::vector<ComputedLayer> first = last_;
  EXPECT_EQ(computed({{2.0}, {3.0}, {1.0}}), 1);
  EXPECT_EQ(last_[0].values, first[1].values);
  EXPECT_EQ(last_[2].values, first[0].values);
  EXPECT_TRUE(last_[0].cached && !last_[1].cached && last_[2].cached);
  EXPECT_EQ(last_[0].seconds, 0.5);
  // Standard deviation and cut-off, to the last bit.
  EXPECT_EQ(computed({{std::nextafter(1.0, 2.0)}}), 1);
  EXPECT_EQ(computed({{1.0, 4.5}}), 1);
  EXPECT_EQ(computed({{1.0, std::nextafter(4.5, 5.0)}}), 1);
  EXPECT_EQ(computed({{1.0, 4.5}, {1.0}}), 0);
}

// Layers that share their computation are taken all or none: with others beside them they may differ in a
// bit.
TEST_F(CachedSourceTest, KeepsTogetherWhatIsComputedTogether) {
  EXPECT_EQ(computed({{1.0}, {2.0}}, true), 2);
  EXPECT_EQ(computed({{1.0}, {2.0}}, true), 0);
  EXPECT_EQ(computed({{1.0}}, true), 1);
  EXPECT_EQ(computed({{1.0}, {2.0}, {3.0}}, true), 3);
  // One of the six files is gone: everything that was computed with it is computed again, and nothing else.
  ASSERT_EQ(folder_.names().size(), 6U);
  std::filesystem::remove(folder_.path() / folder_.names().front());
  int again = 0;
  for (const std::vector<TruthLayer>& call :
       std::vector<std::vector<TruthLayer>>{{{1.0}}, {{1.0}, {2.0}}, {{1.0}, {2.0}, {3.0}}}) {
    const int now = computed(call, true);
    EXPECT_TRUE(now == 0 || now == static_cast<int>(call.size())) << now;
    again += now > 0 ? 1 : 0;
  }
  EXPECT_EQ(again, 1);
}

TEST_F(CachedSourceTest, ForgetsWhatItIsTold) {
  EXPECT_EQ(computed({{1.0}, {2.0}}), 2);
  const std::vector<TruthLayer> one = {{1.0}};
  cached_source(std::make_unique<CountingSource>(computations_, false), cache_)->forget(one);
  EXPECT_EQ(computed({{1.0}, {2.0}}), 1);
}

// What an audit compares with is computed in every run, and once by parts: for these points and layers.
TEST_F(CachedSourceTest, ComputesWhatAuditsCompareWithOnceForParts) {
  const auto audits = [&](const KeptValues& shared, const std::vector<std::uint32_t>& points,
                          const std::vector<TruthLayer>& layers) {
    const int before = computations_;
    const TruthValues exact =
        cached_source(std::make_unique<CountingSource>(computations_, false), cache_, shared)
            ->audit_values(points, layers);
    EXPECT_EQ(exact.size(), layers.size());
    for (const std::vector<Vec4d>& layer : exact) EXPECT_EQ(layer.size(), points.size());
    return computations_ - before;
  };
  const KeptValues parts(&cache_, "program");
  for (const int again : {1, 1}) EXPECT_EQ(audits({}, {0, 1}, {{1.0}}), again);
  for (const int again : {1, 0}) EXPECT_EQ(audits(parts, {0, 1}, {{1.0}}), again);
  for (const int again : {1, 0}) EXPECT_EQ(audits(parts, {1, 0}, {{1.0}}), again);
  for (const int again : {1, 0}) EXPECT_EQ(audits(parts, {0, 1}, {{1.0}, {2.0}}), again);
  for (const int again : {1, 0}) EXPECT_EQ(audits(parts, {0, 1}, {{1.0, 4.5}}), again);
}

// What goes into a truth of a plane at three points.
struct Ingredients {
  PreparedScene scene;
  FrameImages images;
  TruthSpec spec;
  LayerKind kind = LayerKind::euclidean;
};

Ingredients plane(LayerKind kind) {
  Ingredients in;
  in.kind = kind;
  in.scene.mesh = make_builtin("plane", {{"size_mm", 20.0}, {"edge_mm", 5.0}});
  const Lighting lighting(in.scene.mesh, {Light{}});
  in.scene.shading = make_shading_mesh(in.scene.mesh, lighting, SkinMask(), {0.02, 0.5});
  in.images.mask = Image(3, 1, 1, 1.0F);
  for (int i = 0; i < 3; ++i) in.images.surface.push_back({i, Vec3d(0.5, 0.25, 0.25)});
  return in;
}

std::string key_of(const Ingredients& in) {
  const ViewPoints points = view_points(in.scene, in.images);
  const SceneTruths truths(in.scene, in.spec, in.kind == LayerKind::geodesic);
  return truths.source(in.kind, points)->content_key();
}

// A change of one bit in any one thing that the values depend on gives another key; the same things give the
// same one.
TEST(ContentKey, DependsOnEveryIngredient) {
  const std::map<std::string, std::function<void(Ingredients&)>> changes = {
      {"nothing", [](Ingredients&) {}},
      {"a position",
       [](Ingredients& in) {
         // Vertex 0 of both meshes: the plane is not refined.
         in.scene.mesh.positions_mm[0].x() = std::nextafter(in.scene.mesh.positions_mm[0].x(), 0.0);
         in.scene.shading.positions_mm[0] = in.scene.mesh.positions_mm[0];
       }},
      {"an index",
       [](Ingredients& in) {
         // The same triangle, begun at another corner.
         auto& t = in.scene.shading.triangles.back();
         std::rotate(t.vertices.begin(), t.vertices.begin() + 1, t.vertices.end());
         std::rotate(t.base_barycentric.begin(), t.base_barycentric.begin() + 1, t.base_barycentric.end());
       }},
      {"an irradiance",
       [](Ingredients& in) { in.scene.shading.triangles.back().irradiance[2].z() *= 1.0 + 0x1p-52; }},
      {"a component", [](Ingredients& in) { in.scene.shading.triangles.back().component = 1; }},
      {"the mask", [](Ingredients& in) { in.scene.shading.triangles.back().scatters = false; }},
      {"a point", [](Ingredients& in) { in.images.surface[1].barycentric = Vec3d(0.5, 0.375, 0.125); }},
      {"a point's triangle", [](Ingredients& in) { in.images.surface[1].triangle = 5; }},
      {"the number of points", [](Ingredients& in) { in.images.mask.at(2, 0, 0) = 0.0F; }},
      {"the tolerance", [](Ingredients& in) { in.spec.tolerance = std::nextafter(1e-4, 1.0); }}};
  std::set<std::string> keys;
  for (const LayerKind kind : {LayerKind::euclidean, LayerKind::geodesic}) {
    for (const auto& [what, change] : changes) {
      Ingredients in = plane(kind);
      change(in);
      EXPECT_TRUE(keys.insert(key_of(in)).second) << what << " changes no key";
    }
    EXPECT_FALSE(keys.insert(key_of(plane(kind))).second);
  }
}

}  // namespace
}  // namespace truescatter::test
