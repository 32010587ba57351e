#include "experiment/profile_truth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/image_io.h"
#include "experiment/plan.h"
#include "experiment/run_experiment.h"
#include "support/error_of.h"
#include "support/plane_experiment.h"
#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

using Json = nlohmann::json;

// d'Eon & Luebke's four Gaussians for marble's green, in all channels, against the dipole that they fit.
constexpr const char* kMarbleGreen = R"(
[[profile]]
name = "marble-green"
[[profile.gaussian]]
variance_mm2 = 0.036
weight = 0.07
[[profile.gaussian]]
variance_mm2 = 0.14
weight = 0.18
[[profile.gaussian]]
variance_mm2 = 0.91
weight = 0.21
[[profile.gaussian]]
variance_mm2 = 7.0
weight = 0.29
[profile.of]
model = "classical-dipole"
sigma_a = 0.0041
sigma_s_prime = 2.62
eta = 1.5
[[method]]
name = "none"
[[method]]
name = "pscbf"
[truth]
audit_points = 256
[timing]
warm_up = 0
repeats = 1
)";

// Two cards, one before the other, whose shadow falls on the other: silhouettes, borders and a shadow edge.
constexpr const char* kCards = R"(
[scene]
mesh = "builtin:cards"
[[light]]
direction = [0.7, 0.0, 1.0]
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 100.0]
fov_deg = 16.0
width_px = 32
height_px = 32
)";

class ProfileTruthTest : public testing::Test {
 protected:
  Json run(const std::string& experiment, TruthCache* cache = nullptr) const {
    run_experiment(read_experiment(folder_.write("e.toml", experiment)), out_.path(), cache);
    return Json::parse(read_text_file(out_.path() / "results.json"));
  }
  Image layer(const Json& file, const std::string& name) const {
    return read_exr_layer(out_.path() / file.get<std::string>(), name);
  }

  TempDir folder_;
  TempDir out_;
};

Json itself(const Json& results, bool normalised) {
  for (const Json& truth : results.at("truths"))
    if (truth.contains("of") && truth.at("normalised") == normalised) return truth;
  throw std::runtime_error("no truth of the profile itself");
}

// The dipole's total in closed form (Jensen et al. 2001): a'/2 (1 + exp(-4/3 A q)) exp(-q), q^2 = 3 (1 - a').
double dipole_albedo(double sigma_a, double sigma_s_prime, double eta) {
  const double a = sigma_s_prime / (sigma_s_prime + sigma_a);
  const double q = std::sqrt(3.0 * (1.0 - a));
  const double reflected = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
  const double boundary = (1.0 + reflected) / (1.0 - reflected);
  return 0.5 * a * (1.0 + std::exp(-4.0 / 3.0 * boundary * q)) * std::exp(-q);
}

// Under even light I the Gaussians' truth is .75 I, as their weights sum to that, and the dipole's is its
// albedo times I: .791 as published. Both are only good to their uncertainties.
TEST_F(ProfileTruthTest, OnAPlaneInEvenLightTheFitErrorIsTheAlbedos) {
  const double albedo = dipole_albedo(0.0041, 2.62, 1.5);
  ASSERT_NEAR(albedo, 0.791, 0.5e-3);
  const Json results = run(std::string(kPlane) + kMarbleGreen);
  const double light = results.at("scene").at("largest_irradiance");
  const Json& fit = results.at("fit_errors").at(0);
  EXPECT_EQ(fit.at("fit"), "front/marble-green/euclidean-normalised");
  EXPECT_EQ(fit.at("truth"), "front/marble-green/profile-itself-normalised");
  const double uncertainty = results.at("truths").at(0).at("uncertainty").get<double>() +
                             itself(results, true).at("uncertainty").get<double>();
  EXPECT_LT(uncertainty, 1e-3);
  for (const char* channel : {"r", "g", "b"}) {
    const Json& metrics = fit.at("metrics").at("channels").at(channel);
    EXPECT_NEAR(metrics.at("bias").get<double>(), (0.75 - albedo) * light, uncertainty * light);
    EXPECT_NEAR(metrics.at("max").get<double>(), (albedo - 0.75) * light, uncertainty * light);
  }
  EXPECT_EQ(fit.at("distinguishable"), true);
}

// On a plane far larger than the profile the raw truth sends back the albedo of even light too. Marble's
// green with 20 times the absorption: s_tr = 0.84 / mm, so less than 1e-9 lies beyond the 30 mm to the
// border.
TEST_F(ProfileTruthTest, OnALargePlaneTheRawTruthIsTheAlbedo) {
  std::string experiment = std::string(kPlane) + kMarbleGreen;
  experiment.replace(experiment.find("size_mm = 20.0"), 14, "size_mm = 80.0");
  experiment.replace(experiment.find("sigma_a = 0.0041"), 16, "sigma_a = 0.082");
  experiment.replace(experiment.find("[profile.of]"), 12, "[profile.of]\ntolerance = 1e-3");
  const ExperimentSpec spec = read_experiment(folder_.write("e.toml", experiment));
  const Plan plan = make_plan(spec);
  const PreparedScene scene = prepare_scene(spec);
  const gpu::Context context;
  const SurfaceBuffers buffers(context, scene.shading);
  const Frame frame = render_frame(context, buffers, scene.shading, camera_of(spec.views[0]));
  const FrameImages images = read_frame(context, frame);
  const SceneTruths truths(scene, spec.truth, false);
  ViewTruth view(scene, images);
  const ProfileModel& model = plan.models.at("marble-green");
  view.compute(
      {request_of(model)}, spec.truth,
      [&](LayerKind kind, const ViewPoints& points) { return truths.source(kind, points); }, nullptr);
  const ProfileTruth truth = profile_truth(model, view, &truths.surface());
  const double expected = dipole_albedo(0.082, 2.62, 1.5) * scene.largest_irradiance;
  const double allowed = truth.raw.certificate.uncertainty() * scene.largest_irradiance;
  EXPECT_GE(truth.raw.certificate.uncertainty(), model.error_bound.maxCoeff());
  for (const float value : truth.raw.rgb.data()) EXPECT_NEAR(value, expected, allowed);
  EXPECT_EQ(truth.check.points, 32U);
}

// method - profile = (method - fit) + (fit - profile). At every pixel: each of the three maps is a difference
// rounded to single precision, by 2^-24 of it at most. In the mean: of n pixels, each rounded by 2^-53 of
// terms of 1 at most and summed one by one, three times.
TEST_F(ProfileTruthTest, FitAndConvolutionErrorsAddUp) {
  const Json results = run(std::string(kCards) + kMarbleGreen);
  const Json& fit = results.at("fit_errors").at(0);
  const Image fit_error = layer(itself(results, true).at("files").at("exr"), "fit_error");
  const double pixels = fit.at("metrics").at("pixels");
  ASSERT_GT(pixels, 100.0);
  ASSERT_EQ(results.at("runs").size(), 2U);
  for (const Json& run : results.at("runs")) {
    const Json& profile_error = run.at("profile_error");
    const Image together = layer(run.at("files").at("exr"), "profile_error");
    const Image convolution = layer(run.at("files").at("exr"), "error");
    double largest = 0.0;
    for (std::size_t i = 0; i < together.data().size(); ++i) {
      const double a = together.data()[i];
      const double b = convolution.data()[i];
      const double c = fit_error.data()[i];
      EXPECT_LE(std::abs(a - (b + c)), 0x1p-24 * (std::abs(a) + std::abs(b) + std::abs(c)));
      largest = std::max(largest, std::abs(a));
    }
    EXPECT_GT(largest, 0.01);
    const auto bias = [&](const Json& metrics) { return metrics.at("bias").get<double>(); };
    const Json& apart = profile_error.at("convolution");
    EXPECT_EQ(profile_error.at("truth"), fit.at("truth"));
    EXPECT_EQ(apart.at("truth"), fit.at("fit"));
    EXPECT_EQ(apart.at("metrics").at("pixels"), pixels);
    EXPECT_EQ(profile_error.at("metrics").at("pixels"), pixels);
    EXPECT_NEAR(bias(profile_error.at("metrics")), bias(apart.at("metrics")) + bias(fit.at("metrics")),
                3.0 * pixels * 0x1p-53);
  }
}

TEST_F(ProfileTruthTest, IsDescribedInTheResults) {
  const Json results = run(std::string(kCards) + kMarbleGreen);
  for (const bool normalised : {true, false}) {
    const Json truth = itself(results, normalised);
    const Json& of = truth.at("of");
    EXPECT_EQ(of, results.at("profiles").at(0).at("of"));
    EXPECT_EQ(of.at("model"), "classical-dipole");
    EXPECT_EQ(of.at("material"), Json());
    EXPECT_EQ(of.at("sigma_a_per_mm"), Json({0.0041, 0.0041, 0.0041}));
    EXPECT_EQ(of.at("eta"), 1.5);
    EXPECT_GT(of.at("mixture").at("gaussians"), 4);
    const double bound = of.at("mixture").at("error_bound").at(0);
    EXPECT_GT(bound, 0.0);
    EXPECT_LE(bound, of.at("mixture").at("tolerance").get<double>());
    const Json& certificate = truth.at("certificate");
    // One mass for all: twice the bound over a surface at least.
    EXPECT_GE(certificate.at("approximation").get<double>(), (normalised ? 4.0 : 2.0) * bound);
    EXPECT_DOUBLE_EQ(truth.at("uncertainty").get<double>(),
                     certificate.at("weight").get<double>() * (certificate.at("max_error").get<double>() +
                                                               certificate.at("tail_bound").get<double>()) +
                         certificate.at("approximation").get<double>());
    EXPECT_EQ(truth.at("radial_check").at("points"), 32);
    EXPECT_LE(truth.at("radial_check").at("max_difference"), truth.at("radial_check").at("allowed"));
    EXPECT_GT(truth.at("radial_check").at("max_difference"), 0.0);
  }
}

TEST_F(ProfileTruthTest, AProfileThatApproximatesNothingIsMeasuredAsBefore) {
  std::string experiment = std::string(kPlane) + kMarbleGreen;
  const std::size_t of = experiment.find("[profile.of]");
  experiment.erase(of, experiment.find("[[method]]") - of);
  const Json results = run(experiment);
  EXPECT_EQ(results.at("fit_errors"), Json::array());
  EXPECT_EQ(results.at("truths").size(), 2U);
  for (const Json& run : results.at("runs")) EXPECT_FALSE(run.contains("profile_error"));
}

// Its layers are kept as any others are, and give the same again.
TEST_F(ProfileTruthTest, ComesFromTheCacheTheNextTime) {
  const TempDir folder;
  TruthCache cache(folder.path(), 1U << 24U);
  const Json first = run(std::string(kPlane) + kMarbleGreen, &cache);
  const Json second = run(std::string(kPlane) + kMarbleGreen, &cache);
  EXPECT_EQ(itself(first, true).at("cached"), false);
  EXPECT_EQ(itself(second, true).at("cached"), true);
  EXPECT_EQ(first.at("fit_errors"), second.at("fit_errors"));
}

}  // namespace
}  // namespace truescatter::test
