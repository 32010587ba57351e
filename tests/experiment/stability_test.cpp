#include "experiment/stability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "experiment/join_pieces.h"
#include "experiment/view_truth.h"
#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

using nlohmann::json;

// What measure_stability works on, of an experiment's text.
class StagedRun {
 public:
  StagedRun(const TempDir& folder, const std::string& text)
      : spec(read_experiment(folder.write("e.toml", text))),
        plan(make_plan(spec)),
        scene(prepare_scene(spec)),
        buffers(context_, scene.shading, scene.lights),
        truths(scene, spec.truth, false) {}

  // Its first view's runs, by their methods' labels.
  std::map<std::string, json> run() {
    const TempDir working;
    const PieceStore pieces(working.path());
    const ImageTexts origin;
    const Setup setup{spec, plan, scene, context_, buffers, truths, pieces, origin};
    for (const ViewSpec& view : spec.views) run_view(setup, view);
    const json results = join_pieces(record_of(spec, {{spec, plan}}), pieces);
    stability = results["stability"];
    std::map<std::string, json> runs;
    for (const json& run : results["runs"]) {
      if (run["view"] == spec.views.front().name) runs[run["label"]] = run;
    }
    return runs;
  }

  const gpu::Context& context() const { return context_; }
  FrameImages images(const Camera& camera) const {
    return read_frame(context_, render_frame(context_, buffers, scene.shading, camera));
  }

 private:
  gpu::Context context_;

 public:
  ExperimentSpec spec;
  Plan plan;
  PreparedScene scene;
  SurfaceBuffers buffers;
  SceneTruths truths;
  json stability;
};

// A square of 20 mm, lit by a lamp 20 mm above it, of which the view sees 8 mm.
const std::string kLitPlane = R"(
[scene]
mesh = "builtin:plane"
parameters.size_mm = 40.0
parameters.edge_mm = 1.0
[[light]]
type = "point"
position_mm = [3.0, 2.0, 20.0]
reference_mm = 20.0
shadows = false
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 200.0]
fov_deg = 2.3
width_px = 48
height_px = 48
[[profile]]
name = "one"
r_max_mm = 3.0
[[profile.gaussian]]
variance_mm2 = 1.0
weight = [0.9, 0.7, 0.5]
[[method]]
name = "none"
[[method]]
name = "blur2d"
[truth]
geodesic = "off"
[timing]
warm_up = 0
repeats = 1
)";

// A method that is evaluated from the truth: its exitance is the truth of its frame, as the run computes it.
Method truth_itself(const StagedRun& run) {
  Method method = find_method("none");
  method.prepare = [&run](const MethodInputs& inputs) {
    const auto output = std::make_shared<gpu::Texture>(inputs.context, inputs.frame.camera.width_px,
                                                       inputs.frame.camera.height_px, gpu::Format::rgba32f);
    const FrameImages images = read_frame(inputs.context, inputs.frame);
    ViewTruth truth(run.scene, images);
    truth.compute(
        {{&inputs.profile, OwnTarget{}}}, run.spec.truth,
        [&](LayerKind kind, const ViewPoints& points) { return run.truths.source(kind, points); }, nullptr);
    const Image rgb = truth.image({&inputs.profile, OwnTarget{}}).rgb;
    Image rgba(rgb.width(), rgb.height(), 4);
    for (int y = 0; y < rgb.height(); ++y) {
      for (int x = 0; x < rgb.width(); ++x) rgba.set_rgb(x, y, rgb.rgb(x, y));
    }
    output->upload(rgba);
    return PreparedMethod{[output](Passes&) {}, output.get()};
  };
  return method;
}

const std::string kAllKinds = R"(
[stability]
points = 0
orbit = {degrees = 100.0, views = 3}
dolly = {factors = [0.8, 1.3]}
jitter = {views = 3}
)";

// True convolution depends on the surface alone: a method that is evaluated from the truth has an error of 0
// in every view, and a spread of exactly 0. One of fixed size on screen has not; nor has the light itself,
// whose error is the same function of the surface in every view, but read at other points of the pixels.
TEST(Stability, OfAMethodEvaluatedFromTheTruthIsExactlyZero) {
  const TempDir folder;
  StagedRun staged(folder, kLitPlane + kAllKinds);
  const auto method = std::make_shared<const Method>(truth_itself(staged));
  staged.plan.methods.push_back({method, "itself", Settings(method->name, method->settings, {}), nullptr});
  const std::map<std::string, json> runs = staged.run();
  for (const char* kind : {"orbit", "dolly", "jitter"}) {
    const json itself = runs.at("itself")["metrics"]["stability"][kind];
    EXPECT_GT(itself["points"].get<std::size_t>(), 1000U) << kind;
    const json channels = runs.at("itself")["metrics"]["channels"];
    for (const json& spread : {itself, channels["r"]["stability"][kind], channels["b"]["stability"][kind]}) {
      for (const char* key : {"rms", "p95", "max", "rel_rms", "rel_p95", "rel_max"})
        EXPECT_EQ(spread[key].get<double>(), 0.0) << kind << " " << key;
    }
  }
  EXPECT_GT(runs.at("blur2d")["metrics"]["stability"]["orbit"]["rms"], 1e-3);
  EXPECT_GT(runs.at("none")["metrics"]["stability"]["jitter"]["rms"], 0.0);
}

// What an audit has let through is what was measured: each derived view has one.
TEST(Stability, AuditsTheTruthOfEveryView) {
  const TempDir folder;
  StagedRun staged(folder, kLitPlane + kAllKinds);
  staged.run();
  ASSERT_EQ(staged.stability.size(), 3U);
  for (const json& done : staged.stability) {
    EXPECT_EQ(done["seen"].size(), done["views"].get<std::size_t>());
    EXPECT_GE(done["audited"].get<std::size_t>(), 256 * done["views"].get<std::size_t>());
    EXPECT_LE(done["max_error"].get<double>(), done["tolerance"].get<double>());
  }
}

// Texture space diffuses before anybody looks: at a fixed (u, v) its levels are the same bits from every
// view.
TEST(Stability, OfTextureSpaceAtAFixedTexelIsBitwise) {
  const TempDir folder;
  StagedRun staged(folder, kLitPlane + kAllKinds);
  const Method& method = find_method("texture-space");
  const Settings settings(method.name, method.settings, {{"texture_size", 128.0}});
  const gpu::Context& context = staged.context();
  const SurfaceBuffers& buffers = staged.buffers;
  std::vector<std::map<std::string, Image>> seen;
  for (const DerivedViews& kind : derived_views(staged.spec.views.front(), *staged.spec.stability)) {
    for (const Camera& camera : kind.cameras) {
      const Frame frame = render_frame(context, buffers, staged.scene.shading, camera);
      const PreparedMethod prepared =
          method.prepare({context, frame, buffers, median_skin_depth_mm(read_frame(context, frame)),
                          staged.plan.profiles.front(), settings});
      Passes passes(context);
      seen.emplace_back();
      passes.record([&] { prepared.render(passes); },
                    [&](const NamedTexture& texture) { seen.back()[texture.name] = texture.image; });
    }
  }
  ASSERT_EQ(seen.size(), 8U);
  ASSERT_FALSE(seen.front().empty());
  for (const auto& textures : seen) {
    ASSERT_EQ(textures.size(), seen.front().size());
    for (const auto& [name, image] : textures)
      EXPECT_TRUE(std::ranges::equal(image.data(), seen.front().at(name).data())) << name;
  }
}

// Through pixels, each view reads the levels at other points of the surface. With e(x) the error of what is
// stored, a point's error is e within a pixel of it, so its spread is at most a pixel's diagonal times e's
// slope. In a chart without stretch e is the seven taps' variance (1.079 s^2), the texels', and that taps
// about 1 mm apart meet the kinks of light that is linear on triangles at other phases; edges of 0.5 mm
// rather than 1 mm make kinks a quarter as strong, and bring it below.
TEST(Stability, OfTextureSpaceThroughPixelsIsSmall) {
  const TempDir folder;
  std::string fine = kLitPlane;
  fine.replace(fine.find("edge_mm = 1.0"), 13, "edge_mm = 0.5");
  StagedRun staged(folder, fine + R"(
[[method]]
name = "texture-space"
settings.texture_size = 512
[[method]]
name = "texture-space"
label = "dense"
settings.texture_size = 512
settings.taps = "dense"
[stability]
points = 300
orbit = {degrees = 100.0, views = 2}
dolly = {factors = [0.8, 1.3]}
jitter = {views = 3}
)");
  const std::map<std::string, json> runs = staged.run();
  for (const char* kind : {"orbit", "dolly", "jitter"}) {
    for (const char* label : {"texture-space", "dense"})
      EXPECT_LE(runs.at(label)["metrics"]["stability"][kind]["max"].get<double>(), 1e-4) << label << kind;
    // A bound that can be exceeded.
    EXPECT_GT(runs.at("blur2d")["metrics"]["stability"][kind]["max"].get<double>(), 1e-4) << kind;
  }
}

TEST(DerivedViews, TurnMoveAndShiftOneView) {
  ViewSpec view;
  view.eye_mm = Vec3d(10.0, 0.0, 100.0);
  view.target_mm = Vec3d(10.0, 5.0, 0.0);
  StabilitySpec spec;
  spec.orbit_deg = 60.0;
  spec.orbit_views = 3;
  spec.dolly_factors = {0.5, 2.0};
  spec.jitter_views = 16;
  const std::vector<DerivedViews> all = derived_views(view, spec);
  ASSERT_EQ(all.size(), 3U);
  // (0, -5, 100) from the target, turned by -30, 0 and 30 degrees about y: x = 100 sin, z = 100 cos.
  const std::vector<Camera>& orbit = all[0].cameras;
  ASSERT_EQ(orbit.size(), 3U);
  const double half = std::sqrt(0.75);
  EXPECT_NEAR((orbit[0].eye_mm - Vec3d(10.0 - 50.0, 0.0, 100.0 * half)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((orbit[1].eye_mm - view.eye_mm).norm(), 0.0, 1e-12);
  EXPECT_NEAR((orbit[2].eye_mm - Vec3d(10.0 + 50.0, 0.0, 100.0 * half)).norm(), 0.0, 1e-12);
  ASSERT_EQ(all[1].cameras.size(), 2U);
  EXPECT_NEAR((all[1].cameras[0].eye_mm - Vec3d(10.0, 2.5, 50.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((all[1].cameras[1].eye_mm - Vec3d(10.0, -5.0, 200.0)).norm(), 0.0, 1e-12);
  ASSERT_EQ(all[2].cameras.size(), 16U);
  Vec2d mean = Vec2d::Zero();
  for (const Camera& camera : all[2].cameras) {
    EXPECT_LT(camera.shift_px.cwiseAbs().maxCoeff(), 0.5);
    mean += camera.shift_px / 16.0;
  }
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 1.0 / 16.0);  // Halton's points fill the pixel evenly
  // A full turn does not come back to where it began.
  spec.orbit_deg = 360.0;
  spec.orbit_views = 4;
  const std::vector<Camera> turn = derived_views(view, spec)[0].cameras;
  EXPECT_NEAR((turn[1].eye_mm - Vec3d(110.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((turn[3].eye_mm - Vec3d(-90.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
}

// The surface that a pixel of a shifted picture shows projects back to the pixel's centre, but for the
// rounding of positions to single precision: 1e-5 mm at a distance of 200 mm, by 50 pixels to the mm.
TEST(DerivedViews, ShiftTheRenderedPicture) {
  const TempDir folder;
  const StagedRun staged(folder, kLitPlane);
  Camera camera = camera_of(staged.spec.views.front());
  for (const Vec2d& shift : {Vec2d(0.0, 0.0), Vec2d(0.4, -0.3), Vec2d(-7.25, 3.5)}) {
    camera.shift_px = shift;
    const FrameImages images = staged.images(camera);
    for (int y = 1; y < 48; y += 5) {
      for (int x = 2; x < 48; x += 5) {
        ASSERT_GT(images.mask.at(x, y, 0), 0.0F);
        const Vec2d at = camera.image_point_px(images.position.rgb(x, y));
        EXPECT_NEAR(at.x(), x + 0.5, 1e-3);
        EXPECT_NEAR(at.y(), y + 0.5, 1e-3);
      }
    }
  }
}

// A card in front of the left half of another, 10 mm before it. From the eye, a point of the back is hidden
// where the straight line to the eye crosses the front's plane within the front card; to be sure of a pixel,
// only points that are so by more than a pixel's width (60 mm / 96) are judged.
TEST(SeenPoints, AreThoseThatNothingHides) {
  const TempDir folder;
  const StagedRun staged(folder, R"(
[scene]
mesh = "builtin:cards"
parameters.size_mm = 40.0
parameters.gap_mm = 10.0
parameters.edge_mm = 5.0
[[light]]
direction = [0.0, 0.0, 1.0]
shadows = false
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 300.0]
fov_deg = 11.4
width_px = 96
height_px = 96
[[profile]]
name = "spike-and-base"
[[method]]
name = "none"
)");
  constexpr double kPixelMm = 60.0 / 96.0;
  std::vector<FollowedPoint> points;
  for (double x = -18.5; x < 19.0; x += 0.7) {
    for (double y = -18.0; y < 19.0; y += 3.1) points.push_back({{x, y, -5.0}, Vec3d::UnitZ(), 0});
  }
  // The front card is the other component.
  const int front = staged.scene.shading.triangles.back().component;
  const int back = staged.scene.shading.triangles.front().component;
  ASSERT_NE(front, back);
  for (FollowedPoint& point : points) point.component = back;
  StabilitySpec spec;
  spec.orbit_deg = 80.0;
  spec.orbit_views = 5;
  const std::vector<DerivedViews> orbit = derived_views(staged.spec.views.front(), spec);
  for (const Camera& camera : orbit.front().cameras) {
    std::vector<bool> is_seen(points.size());
    for (const SeenPoint& seen : seen_points(points, staged.scene, staged.images(camera), camera))
      is_seen[seen.point] = true;
    std::size_t judged = 0;
    std::size_t hidden = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3d& at = points[i].position_mm;
      const double along = 10.0 / (camera.eye_mm.z() - at.z());
      const Vec3d crossing = at + along * (camera.eye_mm - at);
      const double inside = std::min({-crossing.x(), crossing.x() + 20.0, 20.0 - std::abs(crossing.y())});
      if (std::abs(inside) < 1.5 * kPixelMm) continue;
      ++judged;
      if (inside > 0.0) ++hidden;
      EXPECT_EQ(is_seen[i], inside < 0.0) << at.transpose();
    }
    EXPECT_GT(judged, points.size() / 2);
    EXPECT_GT(hidden, 100U);
  }
}

}  // namespace
}  // namespace truescatter::test
