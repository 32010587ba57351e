#include <map>

#include "cli/cli_fixture.h"

namespace truescatter::test {
namespace {

using Json = nlohmann::json;

class CliAdvise : public Cli {};
class CliAdviseErrors : public CliErrors {};

std::map<std::string, Json> parts_of(const Json& advice) {
  std::map<std::string, Json> parts;
  for (const Json& part : advice.at("model").at("parts")) parts[part.at("part").get<std::string>()] = part;
  return parts;
}

// On a plane no surface is behind another, nothing shades anything, every distance is along the surface and
// there is no far side: exactly so but for the truths' tolerance, 1e-4, and in even light the baseline has no
// error to speak of. One more layer, and whatever comes through the body, is nothing at all.
TEST_F(CliAdvise, APlaneNeedsOneLayerAndNeitherGeodesicsNorTransmittance) {
  folder_.write("e.toml", kTiny);
  const ProgramResult result = truescatter({"advise", "e.toml", "--error", "2%", "--json", "--out", "kept"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json advice = Json::parse(result.out);
  EXPECT_EQ(advice.at("standard_methods"), false);
  EXPECT_EQ(advice.at("settings").size(), 2U);
  EXPECT_EQ(advice.at("chosen").at("label"), "none");
  EXPECT_TRUE(advice.at("next_cheaper").is_null());
  std::map<std::string, Json> parts = parts_of(advice);
  for (const std::string part : {"layers", "shadows", "geodesics", "transmittance"})
    EXPECT_EQ(parts.at(part).at("needed"), false) << part;
  EXPECT_EQ(parts.at("layers").at("difference"), 0.0);
  EXPECT_EQ(parts.at("shadows").at("difference"), 0.0);
  EXPECT_EQ(parts.at("transmittance").at("difference"), 0.0);
  EXPECT_LT(parts.at("geodesics").at("difference").get<double>(), 1e-3);

  // The kept result gives the same advice, from its files.
  const ProgramResult again = truescatter({"advise", "kept", "--json"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Json from_result = Json::parse(again.out);
  EXPECT_EQ(from_result.at("chosen"), advice.at("chosen"));
  EXPECT_EQ(from_result.at("model"), advice.at("model"));
  // Without its experiment, what was not measured is said to be so.
  std::filesystem::remove(folder_.path() / "kept/experiment.resolved.toml");
  const ProgramResult bare = truescatter({"advise", "kept", "--metric", "p99"});
  ASSERT_EQ(bare.exit_code, 0) << bare.err;
  EXPECT_TRUE(contains(bare.out, "not measured: there is no kept/experiment.resolved.toml")) << bare.out;
}

// A slab of 1 mm lit from behind, seen 2 mm about its middle, 20 mm from any edge: the front is dark, and
// within the reach of its Gaussians (the widest s is 1.5 mm, so that exp(-20^2 / 2 s^2) < 1e-38) nothing but
// the back gives light, which is farther along the surface than r_max. So all of the truth comes through the
// body: 1, but for the quadrature's error, which is stated.
TEST_F(CliAdvise, AThinSlabLitFromBehindNeedsTransmittance) {
  std::string text = with(kTiny, "builtin:plane", "builtin:slab");
  text = with(text, "size_mm = 20.0\nedge_mm = 5.0", "size_mm = 40.0\nedge_mm = 5.0\nthickness_mm = 1.0");
  text = with(text, "direction = [0.0, 0.5, 1.0]", "direction = [0.0, 0.0, -1.0]");
  text = with(text, "fov_deg = 10.0", "fov_deg = 2.0");
  folder_.write("e.toml",
                with(with(text, "width_px = 48", "width_px = 16"), "height_px = 48", "height_px = 16"));
  const ProgramResult result = truescatter({"advise", "e.toml", "--json"});
  EXPECT_EQ(result.exit_code, 1) << result.err;  // neither method sees the back
  std::map<std::string, Json> parts = parts_of(Json::parse(result.out));
  const Json& transmittance = parts.at("transmittance");
  EXPECT_EQ(transmittance.at("needed"), true);
  EXPECT_NEAR(transmittance.at("difference").get<double>(), 1.0, 1e-3);
  // Straight through, 1 mm, or around the edge, 40 mm: the two metrics agree in nothing.
  EXPECT_EQ(parts.at("geodesics").at("needed"), true);
}

// Light that a shadow's edge cuts in two: no baseline keeps to a thousandth of a per cent.
TEST_F(CliAdvise, ExitsWithOneWhereNoSettingMeetsTheError) {
  const std::string edge =
      with(kTiny, "direction = [0.0, 0.5, 1.0]", "type = \"point\"\nposition_mm = [0.0, 0.0, 1.0]");
  const ProgramResult result = [&] {
    folder_.write("e.toml", edge);
    return truescatter({"advise", "e.toml", "--error", "0.00001"});
  }();
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_TRUE(contains(result.out, "no setting meets 0.001 %; the most accurate:\n")) << result.out;
  EXPECT_FALSE(exists("runs"));
}

// A width below half a pixel shows nowhere: 20 mm over 48 pixels, some 0.36 mm each.
TEST_F(CliAdvise, AnExperimentWithoutMethodsGetsTheStandardOnes) {
  const std::string text =
      with(with(kTiny, "[[method]]\nname = \"none\"\n", ""), "[[method]]\nname = \"pscbf\"\n", "");
  const std::string narrow =
      with(with(text, "width_px = 48", "width_px = 16"), "height_px = 48", "height_px = 16");
  folder_.write("e.toml", with(narrow, "name = \"spike-and-base\"",
                               "name = \"narrow\"\n[[profile.gaussian]]\nvariance_mm2 = 0.01\nweight = 0.5\n"
                               "[[profile.gaussian]]\nvariance_mm2 = 4.0\nweight = 0.5"));
  const ProgramResult result = truescatter({"advise", "e.toml", "--budget", "100000fetches", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json advice = Json::parse(result.out);
  EXPECT_EQ(advice.at("standard_methods"), true);
  EXPECT_EQ(advice.at("cost"), "fetches");
  EXPECT_GE(advice.at("settings").size(), 12U);
  const Json gaussians = parts_of(advice).at("gaussians").at("views")[0];
  EXPECT_EQ(gaussians.at("gaussians"), 2);
  EXPECT_EQ(gaussians.at("below_pixel"), 1);
  EXPECT_FALSE(exists("runs"));
}

TEST_F(CliAdviseErrors, NameTheOption) {
  folder_.write("e.toml", kTiny);
  expect_refused(truescatter({"advise", "e.toml", "--error", "-1%"}), {"--error", "must be above 0"});
  expect_refused(truescatter({"advise", "e.toml", "--error", "2"}), {"--error", "\"2%\" is percent"});
  expect_refused(truescatter({"advise", "e.toml", "--metric", "mse"}),
                 {"--metric", "there are: rmse, halo-peak, p99"});
  expect_refused(truescatter({"advise", "e.toml", "--budget", "many"}), {"--budget", "many"});
  expect_refused(truescatter({"advise", "nothing.toml"}), {"nothing.toml"});
  folder_.write("s.toml", kTiny + "[sweep]\nkey = \"scene.parameters.edge_mm\"\nvalues = [5.0, 4.0]\n");
  expect_refused(truescatter({"advise", "s.toml"}), {"s.toml:", "'sweep'"});
}

}  // namespace
}  // namespace truescatter::test
