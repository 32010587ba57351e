#include "config/experiment_spec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <tuple>

#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

using test::error_of;
using test::TempDir;

// The least that an experiment can say.
const std::string kMinimal = R"([scene]
mesh = "builtin:plane"
[[light]]
direction = [0, 0, 1]
[[view]]
name = "front"
eye_mm = [0, 0, 100]
[[profile]]
name = "spike-and-base"
[[method]]
name = "none"
)";

// Every key there is.
const std::string kFull = R"(name = "full"
question = "What? \"Quoted\", with a \\ and a # in it"
expectation = """
Two
lines"""
source = "Someone 2020"

[scene]
mesh = "head.obj"
unit_mm = 10.0
normals = "angle-weighted"
loop_subdivisions = 2
skin_mask = "masks/skin.png"
transmitter_mask = "masks/ears.png"
albedo = "maps/albedo.png"
normal_map = "maps/normal.png"
normal_map_strength = 1.5
normal_map_green = "down"
obtain = "ask\nfor it"

[[light]]
type = "directional"
direction = [0.3, 0.4, 0.6]
color = [1.0, 0.5, 0.25]
shadows = false

[[light]]
type = "point"
position_mm = [1.0, -2.0, 300.0]
reference_mm = 250.0
color = 0.1

[[light]]
type = "environment"
map = "maps/sky.hdr"
rotation_deg = 30.0
occlusion_rays = 256
color = [1.0, 0.0, 0.0]

[shading]
tolerance = 0.05
floor_mm = 0.7
normal_map_edge_mm = 0.3

[[view]]
name = "left_1"
eye_mm = [-500.0, 0.1, 1e-3]
target_mm = [0.0, 10.0, 0.0]
up = [0.0, 0.0, 1.0]
fov_deg = 22.5
width_px = 320
height_px = 200

[[view]]
name = "front"
eye_mm = [0, 0, 600]

[[profile]]
name = "skin-six-gaussian"

[[profile]]
name = "own"
delta_weight = [0.1, 0.2, 0.3]
r_max_mm = 7.5
[[profile.gaussian]]
variance_mm2 = 4.0
weight = [0.5, 0.4, 0.3]
[[profile.gaussian]]
variance_mm2 = [1.0, 2.0, 0.1]
weight = 0.4
[profile.of]
model = "multipole"
sigma_a = [0.1, 0.2, 0.4]
sigma_s_prime = 2.0
eta = 1.4
thickness_mm = 3.5
tolerance = 1e-7

[[profile]]
name = "spike-and-base"
[profile.of]
model = "better-dipole"
material = "skin2"

[[method]]
name = "pscbf"

[[method]]
name = "pscbf"
label = "pscbf-7"
[method.settings]
taps = 7
placement = "centroid"

[truth]
tolerance = 1e-9
audit_points = 300
seed = 42
geodesic = "extra"
cache = false
visible_only = true
mask_truth = "all"
light_paths = 2000

[metrics]
seam = true
leak = true

[timing]
warm_up = 4
repeats = 9

[[threshold]]
method = "pscbf-7"
metric = "p99"
maximum = 0.125

[[threshold]]
method = "pscbf"
maximum = 1e-7
)";

class ExperimentSpecTest : public testing::Test {
 protected:
  ExperimentSpec read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    return read_experiment(folder_.write("e.toml", text), overrides);
  }
  TempDir folder_;
};

TEST_F(ExperimentSpecTest, ReadsEveryField) {
  const ExperimentSpec spec = read(kFull);
  EXPECT_EQ(spec.file, folder_.path() / "e.toml");
  EXPECT_EQ(spec.name, "full");
  EXPECT_EQ(spec.question, "What? \"Quoted\", with a \\ and a # in it");
  EXPECT_EQ(spec.expectation, "Two\nlines");
  EXPECT_EQ(spec.source, "Someone 2020");
  EXPECT_EQ(spec.scene.mesh, "head.obj");
  EXPECT_EQ(spec.scene.mesh_where.line, 9);
  EXPECT_EQ(spec.scene.unit_mm, 10.0);
  EXPECT_EQ(spec.scene.normals, "angle-weighted");
  EXPECT_EQ(spec.scene.loop_subdivisions, 2);
  EXPECT_EQ(spec.scene.skin_mask, "masks/skin.png");
  EXPECT_EQ(spec.scene.skin_mask_where.line, 13);
  EXPECT_EQ(spec.scene.transmitter_mask, "masks/ears.png");
  EXPECT_EQ(spec.scene.transmitter_mask_where.line, 14);
  EXPECT_EQ(spec.scene.normal_map, "maps/normal.png");
  EXPECT_EQ(spec.scene.normal_map_where.line, 16);
  EXPECT_EQ(spec.scene.albedo, "maps/albedo.png");
  EXPECT_EQ(spec.scene.albedo_where.line, 15);
  EXPECT_EQ(spec.scene.normal_map_strength, 1.5);
  EXPECT_EQ(spec.scene.normal_map_green, "down");
  EXPECT_EQ(spec.scene.obtain, "ask\nfor it");

  ASSERT_EQ(spec.lights.size(), 3U);
  EXPECT_EQ(spec.lights[0].type, "directional");
  EXPECT_EQ(spec.lights[0].direction, Vec3d(0.3, 0.4, 0.6).normalized());
  EXPECT_EQ(spec.lights[0].color, Vec3d(1.0, 0.5, 0.25));
  EXPECT_FALSE(spec.lights[0].shadows);
  EXPECT_EQ(spec.lights[1].type, "point");
  EXPECT_EQ(spec.lights[1].position_mm, Vec3d(1.0, -2.0, 300.0));
  EXPECT_EQ(spec.lights[1].reference_mm, 250.0);
  EXPECT_EQ(spec.lights[1].color, Vec3d(0.1, 0.1, 0.1));
  EXPECT_TRUE(spec.lights[1].shadows);
  EXPECT_EQ(spec.lights[2].type, "environment");
  EXPECT_EQ(spec.lights[2].map, "maps/sky.hdr");
  EXPECT_EQ(spec.lights[2].rotation_deg, 30.0);
  EXPECT_TRUE(spec.lights[2].occlusion);
  EXPECT_EQ(spec.lights[2].occlusion_rays, 256);
  EXPECT_EQ(spec.lights[2].color, Vec3d(1.0, 0.0, 0.0));

  EXPECT_EQ(spec.shading.tolerance, 0.05);
  EXPECT_EQ(spec.shading.floor_mm, 0.7);
  EXPECT_EQ(spec.shading.normal_map_edge_mm, 0.3);

  ASSERT_EQ(spec.views.size(), 2U);
  EXPECT_EQ(spec.views[0].name, "left_1");
  EXPECT_EQ(spec.views[0].eye_mm, Vec3d(-500.0, 0.1, 1e-3));
  EXPECT_EQ(spec.views[0].target_mm, Vec3d(0.0, 10.0, 0.0));
  EXPECT_EQ(spec.views[0].up, Vec3d(0.0, 0.0, 1.0));
  EXPECT_EQ(spec.views[0].fov_deg, 22.5);
  EXPECT_EQ(spec.views[0].width_px, 320);
  EXPECT_EQ(spec.views[0].height_px, 200);

  ASSERT_EQ(spec.profiles.size(), 3U);
  EXPECT_EQ(spec.profiles[0].name, "skin-six-gaussian");
  EXPECT_TRUE(spec.profiles[0].builtin);
  EXPECT_EQ(spec.profiles[0].where.line, 59);
  EXPECT_FALSE(spec.profiles[1].builtin);
  EXPECT_EQ(spec.profiles[1].delta_weight, Vec3d(0.1, 0.2, 0.3));
  EXPECT_EQ(spec.profiles[1].r_max_mm, 7.5);
  ASSERT_EQ(spec.profiles[1].gaussians.size(), 2U);  // ascending in the red variance
  EXPECT_EQ(spec.profiles[1].gaussians[0].variance_mm2, Vec3d(1.0, 2.0, 0.1));
  EXPECT_EQ(spec.profiles[1].gaussians[0].weight, Vec3d(0.4, 0.4, 0.4));
  EXPECT_EQ(spec.profiles[1].gaussians[1].variance_mm2, Vec3d(4.0, 4.0, 4.0));
  EXPECT_EQ(spec.profiles[1].gaussians[1].weight, Vec3d(0.5, 0.4, 0.3));

  EXPECT_FALSE(spec.profiles[0].of);
  const ProfileModelSpec& slab = spec.profiles[1].of.value();
  EXPECT_EQ(slab.model, "multipole");
  EXPECT_EQ(slab.where.line, 72);
  EXPECT_EQ(slab.material, "");
  EXPECT_EQ(slab.sigma_a_per_mm, Vec3d(0.1, 0.2, 0.4));
  EXPECT_EQ(slab.sigma_s_prime_per_mm, Vec3d(2.0, 2.0, 2.0));
  EXPECT_EQ(slab.eta, 1.4);
  EXPECT_EQ(slab.thickness_mm, 3.5);
  EXPECT_EQ(slab.tolerance, 1e-7);
  const ProfileModelSpec& skin = spec.profiles[2].of.value();
  EXPECT_TRUE(spec.profiles[2].builtin);
  EXPECT_EQ(skin.model, "better-dipole");
  EXPECT_EQ(skin.material, "skin2");
  EXPECT_EQ(skin.material_where.line, 83);
  EXPECT_EQ(skin.tolerance, 1e-5);

  ASSERT_EQ(spec.methods.size(), 2U);
  EXPECT_EQ(spec.methods[0].label, "pscbf");
  EXPECT_TRUE(spec.methods[0].settings.empty());
  EXPECT_EQ(spec.methods[1].name, "pscbf");
  EXPECT_EQ(spec.methods[1].label, "pscbf-7");
  EXPECT_EQ(std::get<double>(spec.methods[1].settings.at("taps")), 7.0);
  EXPECT_EQ(std::get<std::string>(spec.methods[1].settings.at("placement")), "centroid");
  EXPECT_EQ(spec.methods[1].settings_where.at("taps").line, 92);

  EXPECT_EQ(spec.truth.tolerance, 1e-9);
  EXPECT_EQ(spec.truth.audit_points, 300);
  EXPECT_EQ(spec.truth.seed, 42U);
  EXPECT_EQ(spec.truth.geodesic, "extra");
  EXPECT_FALSE(spec.truth.cache);
  EXPECT_TRUE(spec.truth.visible_only);
  EXPECT_EQ(spec.truth.mask_truth, "all");
  EXPECT_EQ(spec.truth.light_paths, 2000);
  EXPECT_TRUE(spec.metrics.seam);
  EXPECT_TRUE(spec.metrics.leak);
  EXPECT_EQ(spec.timing.warm_up, 4);
  EXPECT_EQ(spec.timing.repeats, 9);

  ASSERT_EQ(spec.thresholds.size(), 2U);
  EXPECT_EQ(spec.thresholds[0].method, "pscbf-7");
  EXPECT_EQ(spec.thresholds[0].metric, "p99");
  EXPECT_EQ(spec.thresholds[0].maximum, 0.125);
  EXPECT_EQ(spec.thresholds[1].metric, "rmse");
}

TEST_F(ExperimentSpecTest, HasTheDocumentedDefaults) {
  const ExperimentSpec spec = read(kMinimal);
  EXPECT_EQ(spec.name, "e");  // the file's
  EXPECT_EQ(spec.question, "");
  EXPECT_EQ(spec.scene.unit_mm, 1.0);
  EXPECT_EQ(spec.scene.normals, "automatic");
  EXPECT_EQ(spec.scene.loop_subdivisions, 0);
  EXPECT_TRUE(spec.scene.parameters.empty());
  EXPECT_EQ(spec.lights[0].type, "directional");
  EXPECT_EQ(spec.lights[0].color, Vec3d(1, 1, 1));
  EXPECT_TRUE(spec.lights[0].shadows);
  EXPECT_EQ(spec.shading.tolerance, 0.02);
  EXPECT_EQ(spec.shading.floor_mm, 0.4);
  EXPECT_EQ(spec.scene.normal_map, "");
  const ExperimentSpec mapped = read(kMinimal, {"scene.normal_map=n.png", "shading.floor_mm=0.7"});
  EXPECT_EQ(mapped.scene.normal_map_strength, 1.0);
  EXPECT_EQ(mapped.scene.normal_map_green, "up");
  EXPECT_EQ(mapped.shading.normal_map_edge_mm, 0.7);  // the floor
  EXPECT_EQ(spec.views[0].target_mm, Vec3d(0, 0, 0));
  EXPECT_EQ(spec.views[0].up, Vec3d(0, 1, 0));
  EXPECT_EQ(spec.views[0].fov_deg, 30.0);
  EXPECT_EQ(spec.views[0].width_px, 640);
  EXPECT_EQ(spec.views[0].height_px, 640);
  EXPECT_EQ(spec.methods[0].label, "none");
  EXPECT_EQ(spec.truth.tolerance, 1e-4);
  EXPECT_EQ(spec.truth.audit_points, 256);
  EXPECT_EQ(spec.truth.seed, 1U);
  EXPECT_EQ(spec.truth.geodesic, "own");
  EXPECT_TRUE(spec.truth.cache);
  EXPECT_FALSE(spec.truth.visible_only);
  EXPECT_EQ(spec.truth.mask_truth, "skin");
  EXPECT_EQ(spec.truth.light_paths, 0);
  EXPECT_FALSE(spec.metrics.seam);
  EXPECT_FALSE(spec.metrics.leak);
  EXPECT_EQ(spec.timing.warm_up, 1);
  EXPECT_EQ(spec.timing.repeats, 3);
  EXPECT_TRUE(spec.thresholds.empty());
}

// Without r_max_mm a profile ends at three standard deviations of its widest Gaussian: 3 sqrt(4).
TEST_F(ExperimentSpecTest, AProfilesRadiusIsThreeStandardDeviations) {
  const ExperimentSpec spec = read(kMinimal + R"([[profile]]
name = "own"
[[profile.gaussian]]
variance_mm2 = [1, 4, 2]
weight = 1
)");
  EXPECT_EQ(spec.profiles[1].r_max_mm, 6.0);
}

// Everything but where a value stood.
void expect_same(const ExperimentSpec& a, const ExperimentSpec& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.question, b.question);
  EXPECT_EQ(a.expectation, b.expectation);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.scene.parameters, b.scene.parameters);
  EXPECT_EQ(a.scene.unit_mm, b.scene.unit_mm);
  EXPECT_EQ(a.scene.normals, b.scene.normals);
  EXPECT_EQ(a.scene.loop_subdivisions, b.scene.loop_subdivisions);
  EXPECT_EQ(a.scene.obtain, b.scene.obtain);
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (std::size_t i = 0; i < a.lights.size(); ++i) {
    EXPECT_EQ(a.lights[i].type, b.lights[i].type);
    EXPECT_EQ(a.lights[i].direction, b.lights[i].direction);
    EXPECT_EQ(a.lights[i].position_mm, b.lights[i].position_mm);
    EXPECT_EQ(a.lights[i].reference_mm, b.lights[i].reference_mm);
    EXPECT_EQ(a.lights[i].color, b.lights[i].color);
    EXPECT_EQ(a.lights[i].shadows, b.lights[i].shadows);
    EXPECT_EQ(a.lights[i].rotation_deg, b.lights[i].rotation_deg);
    EXPECT_EQ(a.lights[i].occlusion, b.lights[i].occlusion);
    EXPECT_EQ(a.lights[i].occlusion_rays, b.lights[i].occlusion_rays);
  }
  EXPECT_EQ(a.shading.tolerance, b.shading.tolerance);
  EXPECT_EQ(a.shading.floor_mm, b.shading.floor_mm);
  EXPECT_EQ(a.scene.texturing, b.scene.texturing);
  EXPECT_EQ(a.scene.texturing_mix, b.scene.texturing_mix);
  EXPECT_EQ(a.shading.albedo_edge_mm, b.shading.albedo_edge_mm);
  EXPECT_EQ(a.scene.normal_map_strength, b.scene.normal_map_strength);
  EXPECT_EQ(a.scene.normal_map_green, b.scene.normal_map_green);
  EXPECT_EQ(a.shading.normal_map_edge_mm, b.shading.normal_map_edge_mm);
  ASSERT_EQ(a.views.size(), b.views.size());
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    EXPECT_EQ(a.views[i].name, b.views[i].name);
    EXPECT_EQ(a.views[i].eye_mm, b.views[i].eye_mm);
    EXPECT_EQ(a.views[i].target_mm, b.views[i].target_mm);
    EXPECT_EQ(a.views[i].up, b.views[i].up);
    EXPECT_EQ(a.views[i].fov_deg, b.views[i].fov_deg);
    EXPECT_EQ(a.views[i].width_px, b.views[i].width_px);
    EXPECT_EQ(a.views[i].height_px, b.views[i].height_px);
  }
  ASSERT_EQ(a.profiles.size(), b.profiles.size());
  for (std::size_t i = 0; i < a.profiles.size(); ++i) {
    EXPECT_EQ(a.profiles[i].name, b.profiles[i].name);
    EXPECT_EQ(a.profiles[i].builtin, b.profiles[i].builtin);
    EXPECT_EQ(a.profiles[i].delta_weight, b.profiles[i].delta_weight);
    EXPECT_EQ(a.profiles[i].r_max_mm, b.profiles[i].r_max_mm);
    ASSERT_EQ(a.profiles[i].gaussians.size(), b.profiles[i].gaussians.size());
    for (std::size_t g = 0; g < a.profiles[i].gaussians.size(); ++g) {
      EXPECT_EQ(a.profiles[i].gaussians[g].variance_mm2, b.profiles[i].gaussians[g].variance_mm2);
      EXPECT_EQ(a.profiles[i].gaussians[g].weight, b.profiles[i].gaussians[g].weight);
    }
    ASSERT_EQ(a.profiles[i].of.has_value(), b.profiles[i].of.has_value());
    ASSERT_EQ(a.profiles[i].fit.has_value(), b.profiles[i].fit.has_value());
    if (a.profiles[i].fit) {
      const FitSpec& fit = *a.profiles[i].fit;
      const FitSpec& other = *b.profiles[i].fit;
      EXPECT_EQ(std::tie(fit.gaussians, fit.tolerance, fit.norm, fit.nonnegative, fit.keep_albedo,
                         fit.shared_variances, fit.min_variance_mm2, fit.max_variance_mm2, fit.seed),
                std::tie(other.gaussians, other.tolerance, other.norm, other.nonnegative, other.keep_albedo,
                         other.shared_variances, other.min_variance_mm2, other.max_variance_mm2, other.seed));
    }
    if (!a.profiles[i].of) continue;
    EXPECT_EQ(a.profiles[i].of->truth, b.profiles[i].of->truth);
    EXPECT_EQ(a.profiles[i].of->scaling, b.profiles[i].of->scaling);
    EXPECT_EQ(a.profiles[i].of->model, b.profiles[i].of->model);
    EXPECT_EQ(a.profiles[i].of->material, b.profiles[i].of->material);
    EXPECT_EQ(a.profiles[i].of->sigma_a_per_mm, b.profiles[i].of->sigma_a_per_mm);
    EXPECT_EQ(a.profiles[i].of->sigma_s_prime_per_mm, b.profiles[i].of->sigma_s_prime_per_mm);
    EXPECT_EQ(a.profiles[i].of->eta, b.profiles[i].of->eta);
    EXPECT_EQ(a.profiles[i].of->thickness_mm, b.profiles[i].of->thickness_mm);
    EXPECT_EQ(a.profiles[i].of->tolerance, b.profiles[i].of->tolerance);
  }
  ASSERT_EQ(a.methods.size(), b.methods.size());
  for (std::size_t i = 0; i < a.methods.size(); ++i) {
    EXPECT_EQ(a.methods[i].name, b.methods[i].name);
    EXPECT_EQ(a.methods[i].label, b.methods[i].label);
    EXPECT_EQ(a.methods[i].settings, b.methods[i].settings);
  }
  EXPECT_EQ(a.truth.tolerance, b.truth.tolerance);
  EXPECT_EQ(a.truth.audit_points, b.truth.audit_points);
  EXPECT_EQ(a.truth.seed, b.truth.seed);
  EXPECT_EQ(a.truth.geodesic, b.truth.geodesic);
  EXPECT_EQ(a.truth.cache, b.truth.cache);
  EXPECT_EQ(a.truth.visible_only, b.truth.visible_only);
  EXPECT_EQ(a.truth.mask_truth, b.truth.mask_truth);
  EXPECT_EQ(a.truth.light_paths, b.truth.light_paths);
  EXPECT_EQ(a.metrics.seam, b.metrics.seam);
  EXPECT_EQ(a.metrics.leak, b.metrics.leak);
  EXPECT_EQ(a.timing.warm_up, b.timing.warm_up);
  EXPECT_EQ(a.timing.repeats, b.timing.repeats);
  ASSERT_EQ(a.thresholds.size(), b.thresholds.size());
  for (std::size_t i = 0; i < a.thresholds.size(); ++i) {
    EXPECT_EQ(a.thresholds[i].method, b.thresholds[i].method);
    EXPECT_EQ(a.thresholds[i].metric, b.thresholds[i].metric);
    EXPECT_EQ(a.thresholds[i].maximum, b.thresholds[i].maximum);
  }
}

// A resolved file lies in the results' folder, so the mesh's path becomes absolute; all else stays, to the
// bit.
TEST_F(ExperimentSpecTest, AResolvedFileGivesTheSameExperiment) {
  for (const std::string& text : {kMinimal, kFull}) {
    const ExperimentSpec spec = read(text);
    const ExperimentSpec again = read(to_toml(spec));
    expect_same(again, spec);
    EXPECT_EQ(to_toml(again), to_toml(spec));
  }
  const ExperimentSpec again = read(to_toml(read(kFull)));
  EXPECT_EQ(again.scene.mesh, (folder_.path() / "head.obj").string());
  EXPECT_EQ(again.scene.skin_mask, (folder_.path() / "masks/skin.png").string());
  EXPECT_EQ(again.scene.transmitter_mask, (folder_.path() / "masks/ears.png").string());
  EXPECT_EQ(again.scene.albedo, (folder_.path() / "maps/albedo.png").string());
  EXPECT_EQ(again.scene.normal_map, (folder_.path() / "maps/normal.png").string());
  EXPECT_EQ(again.lights[2].map, (folder_.path() / "maps/sky.hdr").string());
}

TEST_F(ExperimentSpecTest, ReadsWhereTheAlbedoEnters) {
  const ExperimentSpec after = read(kFull);
  EXPECT_EQ(after.scene.texturing, "after");
  EXPECT_EQ(after.scene.albedo_exponent_before(), 0.0);
  const auto textured = [&](const std::string& keys, const std::string& shading) {
    std::string text = kFull;
    const std::string albedo = "albedo = \"maps/albedo.png\"\n";
    text.replace(text.find(albedo), albedo.size(), albedo + keys);
    const std::string floor = "floor_mm = 0.7\n";
    text.replace(text.find(floor), floor.size(), floor + shading);
    return text;
  };
  const ExperimentSpec before = read(textured("texturing = \"before\"\n", ""));
  EXPECT_EQ(before.scene.albedo_exponent_before(), 1.0);
  EXPECT_EQ(before.shading.albedo_edge_mm, 0.7);  // the floor
  const ExperimentSpec mix =
      read(textured("texturing = \"mix\"\ntexturing_mix = 0.25\n", "albedo_edge_mm = 0.5\n"));
  EXPECT_EQ(mix.scene.albedo_exponent_before(), 0.25);
  EXPECT_EQ(mix.shading.albedo_edge_mm, 0.5);
  EXPECT_EQ(read(textured("texturing = \"mix\"\n", "")).scene.albedo_exponent_before(), 0.5);
  for (const ExperimentSpec& spec : {before, mix}) expect_same(read(to_toml(spec)), spec);
}

// Normalising a normalised vector moves its last bits for many directions: a resolved file must not.
TEST_F(ExperimentSpecTest, AResolvedDirectionKeepsItsBits) {
  for (int i = 1; i <= 50; ++i) {
    const std::string direction = fmt::format("light.0.direction=[{}, {}, {}]", 0.1 * i, 0.7, 1.0 / i);
    const ExperimentSpec spec = read(kMinimal, {direction});
    ASSERT_EQ(read(to_toml(spec)).lights[0].direction, spec.lights[0].direction) << direction;
  }
}

TEST_F(ExperimentSpecTest, ParametersAndVariablesSurviveResolving) {
  const ExperimentSpec spec = read(kMinimal, {"scene.parameters.size_mm=20.5"});
  EXPECT_EQ(read(to_toml(spec)).scene.parameters, (std::map<std::string, double>{{"size_mm", 20.5}}));
  const ExperimentSpec with_variable = read(kMinimal, {"scene.mesh=${TRUESCATTER_DATA}/a.obj"});
  EXPECT_EQ(read(to_toml(with_variable)).scene.mesh, "${TRUESCATTER_DATA}/a.obj");
}

TEST_F(ExperimentSpecTest, OverridesReplaceAndAddValues) {
  const ExperimentSpec spec =
      read(kFull, {"timing.repeats=5", "name=other", "view.1.fov_deg=12", "view.left_1.width_px=64",
                   "light.0.direction=[0, 0, 2]", "method.1.settings.placement=median",
                   "scene.mesh=\"b=c.obj\"", "question=", "source=two words", "threshold.0.maximum=0.5"});
  EXPECT_EQ(spec.timing.repeats, 5);
  EXPECT_EQ(spec.timing.warm_up, 4);  // its neighbour stays
  EXPECT_EQ(spec.name, "other");      // a bare word
  EXPECT_EQ(spec.views[1].fov_deg, 12.0);
  EXPECT_EQ(spec.views[0].width_px, 64);
  EXPECT_EQ(spec.lights[0].direction, Vec3d(0, 0, 1));
  EXPECT_EQ(std::get<std::string>(spec.methods[1].settings.at("placement")), "median");
  EXPECT_EQ(spec.scene.mesh, "b=c.obj");  // only the first '=' parts key and value
  EXPECT_EQ(spec.question, "");
  EXPECT_EQ(spec.source, "two words");
  EXPECT_EQ(spec.thresholds[0].maximum, 0.5);
  // A table that the file does not have, and the later of two overrides.
  EXPECT_EQ(read(kMinimal, {"truth.seed=7", "truth.seed=8"}).truth.seed, 8U);
}

struct BadOverride {
  std::string text;
  std::string message;  // all of it
};

TEST_F(ExperimentSpecTest, BadOverridesNameThemselves) {
  const std::vector<BadOverride> cases = {
      {"nonsense", "--set nonsense: must have the form key.key=value"},
      {"=1", "--set =1: must have the form key.key=value"},
      {"timing..repeats=1", "--set timing..repeats=1: must have the form key.key=value"},
      {"timing.=1", "--set timing.=1: must have the form key.key=value"},
      {".timing=1", "--set .timing=1: must have the form key.key=value"},
      {"view.7.fov_deg=1", "--set view.7.fov_deg=1: '7' names no entry of this array (2 entries)"},
      {"view.back.fov_deg=1", "--set view.back.fov_deg=1: 'back' names no entry of this array (2 entries)"},
      {"name.x=1", "--set name.x=1: 'x' is below a value that is not a table"},
      {"timing.repeats=two", "--set timing.repeats=two: 'timing.repeats' must be a number"},
      {"timing.repeats=5 6", "--set timing.repeats=5 6: 'timing.repeats' must be a number"},
      {"timing.repeats=5\nx=6", "--set timing.repeats=5\nx=6: 'timing.repeats' must be a number"},
      {"timing.repeats=0", "--set timing.repeats=0: 'timing.repeats' is 0; it must lie in [1, 10000]"},
      {"timing.pauses=1", "--set timing.pauses=1: unknown key 'timing.pauses'; known here: repeats, warm_up"},
      {"view=3", "--set view=3: 'view' must be an array of tables ([[view]])"},
      {"method=[]", "--set method=[]: 'method' is missing: an experiment needs at least one [[method]]"},
      {"truth.seed=nan", "--set truth.seed=nan: 'truth.seed' must be finite"}};
  for (const BadOverride& bad : cases) {
    const auto error = error_of([&] { read(kFull, {bad.text}); });
    ASSERT_TRUE(error.has_value()) << bad.text;
    EXPECT_EQ(error->kind(), ErrorKind::input);
    EXPECT_EQ(error->what(), bad.message);
  }
  const auto unknown = error_of([&] { read(kMinimal, {"nothing.here=1"}); });
  ASSERT_TRUE(unknown.has_value());
  EXPECT_EQ(std::string(unknown->what()).rfind("--set nothing.here=1: unknown key 'nothing'", 0), 0U)
      << unknown->what();
}

TEST_F(ExperimentSpecTest, PathsAreRelativeToTheExperiment) {
  const ExperimentSpec spec = read(kMinimal);
  folder_.write("a.obj", "");
  EXPECT_EQ(resolve_path(spec, "a.obj", {}), folder_.path() / "a.obj");
  EXPECT_EQ(resolve_path(spec, (folder_.path() / "a.obj").string(), {}), folder_.path() / "a.obj");
  setenv("TRUESCATTER_TEST_FOLDER", folder_.path().c_str(), 1);
  EXPECT_EQ(resolve_path(spec, "${TRUESCATTER_TEST_FOLDER}/a.obj", {}), folder_.path() / "a.obj");
}

TEST_F(ExperimentSpecTest, StabilitySurvivesResolving) {
  EXPECT_FALSE(read(kMinimal).stability);
  const std::string given =
      "[stability]\npoints = 12\nseed = 3\norbit = {degrees = 40.5, views = 7}\ndolly = {factors = [0.5, "
      "1.25]}\njitter = {views = 9}\n";
  for (const ExperimentSpec& spec : {read(kMinimal + given), read(to_toml(read(kMinimal + given)))}) {
    ASSERT_TRUE(spec.stability);
    EXPECT_EQ(spec.stability->view, "");
    EXPECT_EQ(spec.stability->points, 12);
    EXPECT_EQ(spec.stability->seed, 3U);
    EXPECT_EQ(spec.stability->orbit_deg, 40.5);
    EXPECT_EQ(spec.stability->orbit_views, 7);
    EXPECT_EQ(spec.stability->dolly_factors, (std::vector<double>{0.5, 1.25}));
    EXPECT_EQ(spec.stability->jitter_views, 9);
  }
  const ExperimentSpec jitter = read(to_toml(read(kMinimal + "[stability]\njitter = {}\n")));
  EXPECT_EQ(jitter.stability->jitter_views, 8);
  EXPECT_EQ(jitter.stability->orbit_views, 0);
  EXPECT_TRUE(jitter.stability->dolly_factors.empty());
}

TEST_F(ExperimentSpecTest, ASweepIsTheExperimentAtEachValue) {
  const std::string given =
      "[sweep]\nkey = [\"view.front.eye_mm\", \"truth.seed\"]\nvalues = [[[0, 0, 9.5], 4], [[1, 2, 3], 5]]\n"
      "axis_values = [-1, 2.5]\ntitle = \"where\"\ndifficulty = \"down\"\n";
  for (const ExperimentSpec& spec : {read(kMinimal + given), read(to_toml(read(kMinimal + given)))}) {
    ASSERT_TRUE(spec.sweep);
    EXPECT_EQ(spec.sweep->axis, (std::vector<double>{-1.0, 2.5}));
    EXPECT_EQ(spec.sweep->title, "where");
    EXPECT_EQ(spec.sweep->difficulty, "down");
    EXPECT_EQ(spec.sweep->scale, "linear");
    ASSERT_EQ(spec.sweep->point.size(), 2U);
    EXPECT_EQ(spec.sweep->point[0].views[0].eye_mm, Vec3d(0.0, 0.0, 9.5));
    EXPECT_EQ(spec.sweep->point[1].views[0].eye_mm, Vec3d(1.0, 2.0, 3.0));
    EXPECT_EQ(spec.sweep->point[1].truth.seed, 5U);
    EXPECT_FALSE(spec.sweep->point[1].sweep);
    EXPECT_EQ(spec.truth.seed, 1U);
  }
  // A value that the experiment refuses is named.
  const auto bad = error_of([&] { read(kMinimal + "[sweep]\nkey = \"truth.seed\"\nvalues = [1, 2.5]\n"); });
  ASSERT_TRUE(bad);
  EXPECT_NE(std::string(bad->what()).find("e.toml:13:7: 'sweep' at 2.5: --set truth.seed=2.5: "),
            std::string::npos)
      << bad->what();
}

TEST_F(ExperimentSpecTest, CharactersSurviveResolving) {
  EXPECT_TRUE(read(kMinimal).scene.characters.empty());
  const ExperimentSpec spec = read(kMinimal +
                                   "\n[[scene.character]]\nposition_mm = [1, 2, "
                                   "3]\n[[scene.character]]\nposition_mm = [1, 2, 3]\nrotation_deg = -0.1\n");
  const ExperimentSpec again = read(to_toml(spec));
  for (const ExperimentSpec& read : {spec, again}) {
    ASSERT_EQ(read.scene.characters.size(), 2U);
    EXPECT_EQ(read.scene.characters[0].position_mm, Vec3d(1.0, 2.0, 3.0));
    EXPECT_EQ(read.scene.characters[0].rotation_deg, 0.0);
    EXPECT_EQ(read.scene.characters[1].rotation_deg, -0.1);
  }
}

TEST_F(ExperimentSpecTest, ACrowdHasItsLimit) {
  const auto crowd = [&](int characters) {
    std::string text = kMinimal;
    for (int i = 0; i < characters; ++i)
      text += fmt::format("\n[[scene.character]]\nposition_mm = [{}, 0, 0]\n", i);
    return text;
  };
  EXPECT_EQ(read(crowd(64)).scene.characters.size(), 64U);
  const auto error = error_of([&] { read(crowd(65)); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind(), ErrorKind::input);
  EXPECT_NE(std::string(error->what()).find("'scene.character' has 65 entries: it must have 1 to 64"),
            std::string::npos)
      << error->what();
}

// Two settings of two values and one of a single value: four methods, the last setting by name changing
// fastest.
TEST_F(ExperimentSpecTest, AGridStandsForItsCombinations) {
  const ExperimentSpec spec =
      read(kMinimal +
           "[[method]]\nname = \"pscbf\"\nlabel = \"p\"\nsettings.sampling = \"taps\"\n[method.grid]\n"
           "taps = [7, 13]\nr_max_mm = [0.5, 1e20]\nplacement = [\"centroid\"]\n"
           "[[threshold]]\nmethod = \"p_r_max_mm-0p5_taps-13\"\nmaximum = 1.0\n");
  ASSERT_EQ(spec.methods.size(), 5U);
  const char* const labels[] = {"p_r_max_mm-0p5_taps-7", "p_r_max_mm-0p5_taps-13", "p_r_max_mm-1e20_taps-7",
                                "p_r_max_mm-1e20_taps-13"};
  for (std::size_t i = 0; i < 4; ++i) {
    const MethodSpec& method = spec.methods[1 + i];
    EXPECT_EQ(method.name, "pscbf");
    EXPECT_EQ(method.label, labels[i]);
    EXPECT_EQ(std::get<double>(method.settings.at("r_max_mm")), i < 2 ? 0.5 : 1e20);
    EXPECT_EQ(std::get<double>(method.settings.at("taps")), i % 2 == 0 ? 7.0 : 13.0);
    EXPECT_EQ(std::get<std::string>(method.settings.at("placement")), "centroid");
    EXPECT_EQ(std::get<std::string>(method.settings.at("sampling")), "taps");
    EXPECT_EQ(method.settings_where.at("taps").line, 17);
    EXPECT_EQ(method.settings_where.at("taps").column, i % 2 == 0 ? 9 : 12);
  }
  // Resolved, each is a method of its own.
  const ExperimentSpec again = read(to_toml(spec));
  expect_same(again, spec);
  EXPECT_EQ(to_toml(again).find("grid"), std::string::npos);
}

TEST_F(ExperimentSpecTest, AGridHasItsLimit) {
  const auto grid = [&](int taps) {
    std::string text = kMinimal + "[[method]]\nname = \"pscbf\"\n[method.grid]\n";
    for (const std::string key : {"r_max_mm", "taps"}) {
      text += key + " = [1";
      for (int i = 2; i <= (key == "taps" ? taps : 64); ++i) text += fmt::format(", {}", i);
      text += "]\n";
    }
    return text;
  };
  EXPECT_EQ(read(grid(64)).methods.size(), 4097U);
  const auto error = error_of([&] { read(grid(65)); });
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(std::string(error->what()).find("e.toml:16:8: 'method.grid' stands for more than 4096 methods"),
            std::string::npos)
      << error->what();
}

TEST_F(ExperimentSpecTest, AMissingFileTellsWhereToObtainIt) {
  ExperimentSpec spec = read(kMinimal);
  spec.scene.obtain = "Ask the librarian.";
  const auto missing = error_of([&] { resolve_path(spec, "none.obj", {"e.toml", 2, 8}); });
  ASSERT_TRUE(missing.has_value());
  EXPECT_EQ(missing->kind(), ErrorKind::input);
  EXPECT_EQ(missing->what(),
            "e.toml:2:8: no such file: " + (folder_.path() / "none.obj").string() + "\nAsk the librarian.");
  unsetenv("TRUESCATTER_TEST_UNSET");
  const auto unset = error_of([&] { resolve_path(spec, "${TRUESCATTER_TEST_UNSET}/a", {"e.toml", 2, 8}); });
  ASSERT_TRUE(unset.has_value());
  EXPECT_STREQ(unset->what(),
               "e.toml:2:8: '${TRUESCATTER_TEST_UNSET}/a': the environment variable TRUESCATTER_TEST_UNSET "
               "is not set\n"
               "Ask the librarian.");
}

TEST_F(ExperimentSpecTest, HasFittedProfiles) {
  const std::string profiles = R"(
[[profile]]
name = "few"
r_max_mm = 9
[profile.fit]
gaussians = "auto"
tolerance = 0.01
norm = "area"
weights = "free"
energy = "albedo"
variances = "per-channel"
min_variance_mm2 = 0.01
seed = 7
[profile.of]
model = "burley"
material = "skin1"
scaling = "diffuse"

[[profile]]
name = "from-file"
[profile.fit]
file = "/tmp/fit.json"

[[profile]]
name = "stack"
[profile.fit]
gaussians = 4
[profile.of]
model = "multipole"
material = "skin-three-layer"
)";
  const std::string text = kFull;
  const std::size_t at = text.find("[[method]]");
  const ExperimentSpec spec = read(text.substr(0, at) + profiles + text.substr(at));
  const std::size_t first = spec.profiles.size() - 3;
  const FitSpec& few = spec.profiles[first].fit.value();
  EXPECT_EQ(few.gaussians, 0);
  EXPECT_EQ(few.tolerance, 0.01);
  EXPECT_EQ(few.norm, "area");
  EXPECT_FALSE(few.nonnegative);
  EXPECT_TRUE(few.keep_albedo);
  EXPECT_FALSE(few.shared_variances);
  EXPECT_EQ(few.min_variance_mm2, 0.01);
  EXPECT_FALSE(few.max_variance_mm2);
  EXPECT_EQ(few.seed, 7);
  EXPECT_EQ(spec.profiles[first].r_max_mm, 9.0);
  EXPECT_EQ(spec.profiles[first].of->scaling, "diffuse");
  EXPECT_FALSE(spec.profiles[first].of->truth);
  EXPECT_EQ(spec.profiles[first + 1].fit->file, "/tmp/fit.json");
  EXPECT_FALSE(spec.profiles[first + 2].of->truth);
  EXPECT_EQ(spec.profiles[first + 2].fit->gaussians, 4);
  expect_same(read(to_toml(spec)), spec);
}

}  // namespace
}  // namespace truescatter
