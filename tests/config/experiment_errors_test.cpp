#include <gtest/gtest.h>

#include <string>

#include "config/experiment_spec.h"
#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

// Lines count from 1; every case below replaces one piece of this text.
const std::string kGood = R"(name = "good"

[scene]
mesh = "builtin:plane"

[[light]]
direction = [0.0, 0.0, 1.0]

[[view]]
name = "front"
eye_mm = [0.0, 0.0, 100.0]

[[profile]]
name = "spike-and-base"

[[method]]
name = "none"

[timing]
repeats = 1
)";

struct Broken {
  const char* what;     // the case's name
  const char* replace;  // a piece of the good text
  const char* with;
  const char* where;    // ":line" or ":line:column" behind the file's name
  const char* message;  // how the message begins
};

// What a failed test prints for its case.
void PrintTo(const Broken& broken, std::ostream* stream) { *stream << broken.what; }

class BrokenExperiment : public testing::TestWithParam<Broken> {};

TEST_P(BrokenExperiment, IsRefusedAtItsPlace) {
  const Broken& broken = GetParam();
  std::string text = kGood;
  const std::size_t at = text.find(broken.replace);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string(broken.replace).size(), broken.with);
  const test::TempDir folder;
  const std::filesystem::path file = folder.write("e.toml", text);
  const auto error = test::error_of([&] { read_experiment(file); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind(), ErrorKind::input);
  const std::string start = file.string() + broken.where + ": " + broken.message;
  EXPECT_EQ(std::string(error->what()).substr(0, start.size()), start) << error->what();
}

const char* const kView = "[[view]]\nname = \"front\"\neye_mm = [0.0, 0.0, 100.0]\n";
const char* const kEye = "eye_mm = [0.0, 0.0, 100.0]";
const char* const kMesh = "mesh = \"builtin:plane\"";
const char* const kDirection = "direction = [0.0, 0.0, 1.0]";
const char* const kProfile = "name = \"spike-and-base\"";
const char* const kMethod = "name = \"none\"";

const Broken kBroken[] = {
    // Syntax: toml11 knows the line.
    {"NoValue", "name = \"good\"", "name =", ":1",
     "not valid TOML: missing value after key-value separator '='"},
    {"OpenString", "repeats = 1", "repeats = \"1", ":20", "not valid TOML: "},
    {"OpenTable", "[timing]", "[timing", ":19", "not valid TOML: "},
    {"NoKey", "repeats = 1", "= 1", ":20", "not valid TOML: "},
    {"KeyTwice", "repeats = 1", "repeats = 1\nrepeats = 2", ":21",
     "not valid TOML: value (\"repeats\") already exists."},
    {"TableTwice", "[timing]", "[scene]\n[timing]", ":19", "not valid TOML: "},
    {"NoSuchDay", "name = \"good\"", "name = 2020-13-45", ":1", "not valid TOML: invalid date"},
    {"InvalidUtf8", "name = \"good\"", "name = \"\xff\"", ":1", "not valid TOML: "},
    // Unknown keys at every level: where the value stands.
    {"UnknownAtTop", "name = \"good\"", "nam = \"good\"", ":1:7", "unknown key 'nam'; known here: "},
    {"UnknownTable", "[timing]", "[time]", ":19:1", "unknown key 'time'; known here: "},
    {"UnknownInScene", kMesh, "mesh = \"builtin:plane\"\nunits = 1", ":5:9", "unknown key 'scene.units'"},
    {"UnknownInLight", kDirection, "direction = [0, 0, 1]\ncolour = 1", ":8:10",
     "unknown key 'light.colour'"},
    {"PositionOfADirection", kDirection, "direction = [0, 0, 1]\nposition_mm = [0, 0, 1]", ":8:15",
     "unknown key 'light.position_mm'"},
    {"ShadowsOfAnEnvironment", kDirection,
     "type = \"environment\"\nmap = \"builtin:uniform\"\nshadows = true", ":9:11",
     "unknown key 'light.shadows'"},
    {"UnknownInView", kEye, "eye_mm = [0, 0, 1]\nfov = 30", ":12:7", "unknown key 'view.fov'"},
    {"UnknownInProfile", kProfile, "name = \"spike-and-base\"\nr_max_mm = 3", ":15:12",
     "unknown key 'profile.r_max_mm'"},
    {"UnknownInGaussian", kProfile,
     "name = \"x\"\n[[profile.gaussian]]\nvariance_mm2 = 1\nweight = 1\nsigma = 1", ":18:9",
     "unknown key 'profile.gaussian.sigma'"},
    {"UnknownInProfileOf", kProfile,
     "name = \"spike-and-base\"\n[profile.of]\nmodel = \"multipole\"\nmaterial = \"skin1\"\nthickness_mm = "
     "3\ndepth_mm = 3",
     ":19:12", "unknown key 'profile.of.depth_mm'"},
    {"UnknownInMethod", kMethod, "name = \"none\"\ntaps = 3", ":18:8", "unknown key 'method.taps'"},
    {"UnknownInTiming", "repeats = 1", "repeat = 1", ":20:10",
     "unknown key 'timing.repeat'; known here: repeats, warm_up"},
    {"UnknownInMetrics", "[timing]", "[metrics]\nseams = true\n[timing]", ":20:9",
     "unknown key 'metrics.seams'"},
    {"UnknownInTruth", "[timing]", "[truth]\ntol = 1\n[timing]", ":20:7", "unknown key 'truth.tol'"},
    {"UnknownInShading", "[timing]", "[shading]\nfloor = 1\n[timing]", ":20:9",
     "unknown key 'shading.floor'"},
    {"UnknownInThreshold", "[timing]", "[[threshold]]\nmethod = \"none\"\nmaximum = 1\nmax = 1\n[timing]",
     ":22:7", "unknown key 'threshold.max'"},
    {"LadderWithoutRungs", "[timing]", "[[ladder]]\nname = \"a\"\nrungs = 1\n[timing]", ":19:1",
     "a ladder needs at least two [[ladder.rung]]"},
    {"UnknownTruthOfARung", "[timing]",
     "[[ladder]]\nname = \"a\"\n[[ladder.rung]]\ntruth = \"all\"\n[timing]", ":22:9",
     "'ladder.rung.truth' is \"all\""},
    {"RungTwice", "[timing]",
     "[[ladder]]\nname = \"a\"\n[[ladder.rung]]\ntruth = \"whole\"\nassumption = \"a\"\n[[ladder.rung]]\n"
     "truth = \"whole\"\nassumption = \"b\"\n[timing]",
     ":25:9", "two rungs are 'truth-whole'"},
    {"RungOfNoMethod", "[timing]", "[[ladder]]\nname = \"a\"\n[[ladder.rung]]\nmethod = \"all\"\n[timing]",
     ":22:10", "'ladder.rung.method' is \"all\", which is no method's label here"},
    // Types.
    {"TextForANumber", "repeats = 1", "repeats = \"1\"", ":20:11", "'timing.repeats' must be a number"},
    {"NumberForAText", "name = \"good\"", "name = 1", ":1:8", "'name' must be a string"},
    {"NumberForATable", "[timing]\nrepeats", "timing", ":19:10", "unknown key 'method.timing'"},
    {"TableForAnArray", "[[light]]", "[light]", ":6:1", "'light' must be an array of tables ([[light]])"},
    {"NumbersForTables", "name = \"good\"", "threshold = [1, 2]", ":1:14", "'threshold' must be a table"},
    {"NumberForAFlag", kDirection, "direction = [0, 0, 1]\nshadows = 1", ":8:11",
     "'light.shadows' must be true or false"},
    {"TwoNumbersForThree", kDirection, "direction = [0.0, 1.0]", ":7:13",
     "'light.direction' must be an array of three numbers"},
    {"TextInAVector", kDirection, "direction = [0.0, \"x\", 1.0]", ":7:19",
     "'light.direction' must be a number"},
    {"FlagForASetting", kMethod, "name = \"none\"\n[method.settings]\ntaps = true", ":19:8",
     "'method.settings.taps' must be a number"},
    // Not finite.
    {"NanDirection", kDirection, "direction = [0.0, nan, 1.0]", ":7:19", "'light.direction' must be finite"},
    {"InfiniteEye", kEye, "eye_mm = [inf, 0.0, 1.0]", ":11:11", "'view.eye_mm' must be finite"},
    {"NanParameter", kMesh, "mesh = \"builtin:plane\"\n[scene.parameters]\nsize_mm = nan", ":6:11",
     "'scene.parameters.size_mm' must be finite"},
    {"NegativeInfinity", "[timing]", "[truth]\ntolerance = -inf\n[timing]", ":20:13",
     "'truth.tolerance' must be finite"},
    // Out of range.
    {"NegativeUnit", kMesh, "mesh = \"a.obj\"\nunit_mm = -1.0", ":5:11",
     "'scene.unit_mm' is -1; it must lie in [1e-09, "},
    {"ZeroUnit", kMesh, "mesh = \"a.obj\"\nunit_mm = 0", ":5:11", "'scene.unit_mm' is 0; it must lie in "},
    {"NegativeStrength", kMesh, "mesh = \"a.obj\"\nnormal_map = \"n.png\"\nnormal_map_strength = -1", ":6:23",
     "'scene.normal_map_strength' is -1; it must lie in [0, 100]"},
    {"TooManySubdivisions", kMesh, "mesh = \"a.obj\"\nloop_subdivisions = 7", ":5:21",
     "'scene.loop_subdivisions' is 7; it must lie in [0, 6]"},
    {"NoCharacter", kMesh, "mesh = \"a.obj\"\ncharacter = []", ":5:13",
     "'scene.character' has 0 entries: it must have 1 to 64"},
    {"TwoCharactersInOnePlace", kMesh,
     "mesh = \"a.obj\"\ncharacter = [{position_mm = [1, 2, 3]}, {position_mm = [1, 2, 3], rotation_deg = 0}]",
     ":5:56", "two characters stand at one place"},
    {"ACharacterWithoutAPlace", kMesh, "mesh = \"a.obj\"\ncharacter = [{rotation_deg = 4}]", ":5:14",
     "'scene.character.position_mm' is missing"},
    {"ACharacterFarAway", kMesh, "mesh = \"a.obj\"\ncharacter = [{position_mm = [0, 0, 2e6]}]", ":5:29",
     "'scene.character.position_mm' must lie within 1e6 mm of the origin"},
    {"ACharacterTurnedTwice", kMesh,
     "mesh = \"a.obj\"\ncharacter = [{position_mm = [0, 0, 0], rotation_deg = 720}]", ":5:55",
     "'scene.character.rotation_deg' is 720; it must lie in [-360, 360]"},
    {"ACharacterWithMore", kMesh, "mesh = \"a.obj\"\ncharacter = [{position_mm = [0, 0, 0], size = 2}]",
     ":5:47", "unknown key 'scene.character.size'"},
    {"NoRepeats", "repeats = 1", "repeats = 0", ":20:11", "'timing.repeats' is 0; it must lie in [1, 10000]"},
    {"HalfAPixel", kEye, "eye_mm = [0, 0, 1]\nwidth_px = 48.5", ":12:12",
     "'view.width_px' is 48.5; it must be a whole number"},
    {"NoPixels", kEye, "eye_mm = [0, 0, 1]\nheight_px = 0", ":12:13",
     "'view.height_px' is 0; it must lie in [1, 16384]"},
    {"FovOf180", kEye, "eye_mm = [0, 0, 1]\nfov_deg = 180", ":12:11",
     "'view.fov_deg' is 180; it must lie in "},
    {"TooFewAudited", "[timing]", "[truth]\naudit_points = 255\n[timing]", ":20:16",
     "'truth.audit_points' is 255; it must lie in [256, "},
    {"TexturingWithoutAlbedo", kMesh, "mesh = \"builtin:plane\"\ntexturing = \"before\"", ":5:13",
     "'scene.texturing' needs a 'scene.albedo'"},
    {"MixWithoutMixing", kMesh,
     "mesh = \"builtin:plane\"\nalbedo = \"a.png\"\ntexturing = \"before\"\ntexturing_mix = 0.5", ":7:17",
     "'scene.texturing_mix' needs 'scene.texturing = \"mix\"'"},
    {"MixAboveOne", kMesh,
     "mesh = \"builtin:plane\"\nalbedo = \"a.png\"\ntexturing = \"mix\"\ntexturing_mix = 1.5", ":7:17",
     "'scene.texturing_mix' is 1.5; it must lie in [0, 1]"},
    {"UnknownTexturing", kMesh, "mesh = \"builtin:plane\"\nalbedo = \"a.png\"\ntexturing = \"split\"",
     ":6:13", "'scene.texturing' is \"split\"; it must be one of: after, before, mix"},
    {"AlbedoEdgeForNothing", "[timing]", "[shading]\nalbedo_edge_mm = 1\n[timing]", ":20:18",
     "'shading.albedo_edge_mm' needs a 'scene.albedo' with a part before the scattering"},
    {"RaysWithoutOcclusion", kDirection,
     "type = \"environment\"\nmap = \"builtin:uniform\"\nocclusion = false\nocclusion_rays = 64", ":10:18",
     "'light.occlusion_rays' needs 'light.occlusion'"},
    {"TooFewRays", kDirection, "type = \"environment\"\nmap = \"builtin:uniform\"\nocclusion_rays = 8",
     ":9:18", "'light.occlusion_rays' is 8; it must lie in [16, 65536]"},
    {"NegativeColor", kDirection, "direction = [0, 0, 1]\ncolor = [1, -1, 1]", ":8:9",
     "'light.color' must not be negative"},
    {"NegativeMaximum", "[timing]", "[[threshold]]\nmethod = \"none\"\nmaximum = -1\n[timing]", ":21:11",
     "'threshold.maximum' is -1; it must lie in [0, "},
    {"ZeroVariance", kProfile, "name = \"x\"\n[[profile.gaussian]]\nvariance_mm2 = [1, 0, 1]\nweight = 1",
     ":16:16", "'profile.gaussian.variance_mm2' must be positive"},
    {"NegativeAbsorption", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"classical-dipole\"\nsigma_a = -1\nsigma_s_prime = 1", ":17:11",
     "'profile.of.sigma_a' must not be negative"},
    {"NoAbsorption", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"better-dipole\"\nsigma_a = [1, 0, 1]\nsigma_s_prime = 1",
     ":17:11", "'profile.of.sigma_a' must be positive for the better-dipole"},
    {"NoScattering", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"classical-dipole\"\nsigma_a = 1\nsigma_s_prime = [1, 0, 1]",
     ":18:17", "'profile.of.sigma_s_prime' must be positive"},
    {"EtaOfOne", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"classical-dipole\"\nsigma_a = 1\nsigma_s_prime = 1\neta = 1.0",
     ":19:7", "'profile.of.eta' must be above 1"},
    {"EtaBelowOne", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"classical-dipole\"\nsigma_a = 1\nsigma_s_prime = 1\neta = 0.9",
     ":19:7", "'profile.of.eta' is 0.9; it must lie in [1, 10]"},
    {"MixtureTooCoarse", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"classical-dipole\"\nmaterial = \"skin1\"\ntolerance = 1",
     ":18:13", "'profile.of.tolerance' is 1; it must lie in [1e-12, 0.1]"},
    {"NoSlab", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"multipole\"\nmaterial = \"skin1\"\nthickness_mm = 0", ":18:16",
     "'profile.of.thickness_mm' is 0; it must lie in "},
    {"TruthOfBurley", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"burley\"\nmaterial = \"skin1\"\ntruth = true", ":18:9",
     "'profile.of.truth': a burley has no truth of its own here"},
    {"ModelForNothing", kProfile, "name = \"x\"\n[profile.of]\nmodel = \"burley\"\nmaterial = \"skin1\"",
     ":15:1", "'profile.of' is asked for nothing"},
    {"ThicknessOfATable", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"table\"\ntable = \"t.csv\"\nthickness_mm = 1", ":18:16",
     "'profile.of.thickness_mm' is for the multipole"},
    {"MaterialOfATable", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"table\"\ntable = \"t.csv\"\nmaterial = \"skin1\"", ":18:12",
     "'profile.of.material' is no table's"},
    {"FitOfNothing", kProfile, "name = \"x\"\n[profile.fit]\ngaussians = 3", ":15:1",
     "'profile.fit' needs [profile.of]"},
    {"FitAndGaussians", kProfile,
     "name = \"x\"\n[profile.fit]\nfile = \"f.json\"\n[[profile.gaussian]]\nvariance_mm2 = 1\nweight = 1",
     ":17:1", "a profile is fitted or has [[profile.gaussian]], not both"},
    {"FitOfFileWithNorm", kProfile, "name = \"x\"\n[profile.fit]\nfile = \"f.json\"\nnorm = \"r\"", ":17:8",
     "unknown key 'profile.fit.norm'"},
    {"TooManyGaussians", kProfile,
     "name = \"x\"\n[profile.fit]\ngaussians = 17\n[profile.of]\nmodel = \"classical-dipole\"\nmaterial = "
     "\"skin1\"",
     ":16:13", "'profile.fit.gaussians' is 17; it must lie in [1, 16]"},
    {"ToleranceOfACount", kProfile,
     "name = \"x\"\n[profile.fit]\ngaussians = 3\ntolerance = 0.1\n[profile.of]\nmodel = "
     "\"classical-dipole\"\n"
     "material = \"skin1\"",
     ":17:13", "'profile.fit.tolerance' goes with gaussians"},
    {"StabilityOfNothing", "[timing]", "[stability]\npoints = 5\n[timing]", ":19:1",
     "'stability' needs an 'orbit', a 'dolly' or a 'jitter'"},
    {"StabilityElsewhere", "[timing]", "[stability]\nview = \"back\"\njitter = {views = 2}\n[timing]",
     ":20:8", "'stability.view' is \"back\", which is no view's name"},
    {"JitterOfOne", "[timing]", "[stability]\njitter = {views = 1}\n[timing]", ":20:19",
     "'stability.jitter.views' is 1; it must lie in [2, 1000]"},
    {"DollyOfOne", "[timing]", "[stability]\ndolly = {factors = [0.5]}\n[timing]", ":20:20",
     "'stability.dolly.factors' needs at least two"},
    {"DollyBehindTheTarget", "[timing]", "[stability]\ndolly = {factors = [1.0, -1.0]}\n[timing]", ":20:26",
     "'stability.dolly.factors' has -1; its numbers must lie in "},
    {"OrbitWithoutDegrees", "[timing]", "[stability]\norbit = {views = 3}\n[timing]", ":20:9",
     "'stability.orbit.degrees' is missing"},
    {"SweepOfNothing", "[timing]", "[sweep]\nvalues = [1, 2]\n[timing]", ":19:1", "'sweep.key' is missing"},
    {"SweepWithoutValues", "[timing]", "[sweep]\nkey = \"truth.seed\"\n[timing]", ":19:1",
     "'sweep.values' must be an array"},
    {"SweepOfOne", "[timing]", "[sweep]\nkey = \"truth.seed\"\nvalues = [1]\n[timing]", ":21:10",
     "'sweep.values' needs at least two"},
    {"SweepThatTurns", "[timing]", "[sweep]\nkey = \"truth.seed\"\nvalues = [1, 3, 2]\n[timing]", ":21:10",
     "'sweep.values' must grow or fall from each to the next"},
    {"SweepOfWords", "[timing]", "[sweep]\nkey = \"truth.geodesic\"\nvalues = [\"own\", \"off\"]\n[timing]",
     ":21:11", "'sweep.values' must be numbers, or 'sweep.axis_values' must say what they amount to"},
    {"SweepOfZeroByLog", "[timing]",
     "[sweep]\nkey = \"truth.seed\"\nvalues = [0, 1]\nscale = \"log\"\n[timing]", ":21:10",
     "'sweep.values' must be positive on a logarithmic scale"},
    {"SweepOfTwoKeys", "[timing]",
     "[sweep]\nkey = [\"truth.seed\", \"timing.repeats\"]\nvalues = [1, 2]\n[timing]", ":21:11",
     "'sweep.values' must hold 2 values each, one for every key"},
    {"SweepWithFewerPlaces", "[timing]",
     "[sweep]\nkey = \"truth.seed\"\nvalues = [1, 2, 3]\naxis_values = [1.0, 2.0]\n[timing]", ":22:15",
     "'sweep.axis_values' has 2 entries for 3 values"},
    {"MethodOfNoFile", "name = \"none\"", "name = \"no.ne\"", ":17:8",
     "'method.name' names files: letters, digits, '-' and '_' only"},
    {"SweepOfNoEntry", "[timing]", "[sweep]\nkey = \"light.9.type\"\nvalues = [1, 2]\n[timing]", ":20:7",
     "'sweep' at 1: --set light.9.type=1: '9' names no entry of this array (1 entries)"},
    {"SweepOutOfRange", "[timing]", "[sweep]\nkey = \"timing.repeats\"\nvalues = [1, 0]\n[timing]", ":20:7",
     "'sweep' at 0: --set timing.repeats=0"},
    {"SweepOfSweeps", "[timing]", "[sweep]\nkey = \"sweep.title\"\nvalues = [1, 2]\n[timing]", ":20:7",
     "'sweep.key' must not be 'sweep.title'"},
    // Not one of the words.
    {"UnknownGeodesic", "[timing]", "[truth]\ngeodesic = \"on\"\n[timing]", ":20:12",
     "'truth.geodesic' is \"on\"; it must be one of: own, extra, off"},
    {"UnknownLightType", kDirection, "type = \"spot\"", ":7:8",
     "'light.type' is \"spot\"; it must be one of: directional, point, environment"},
    {"UnknownNormals", kMesh, "mesh = \"a.obj\"\nnormals = \"smooth\"", ":5:11",
     "'scene.normals' is \"smooth\"; it must be one of: "},
    {"UnknownGreen", kMesh, "mesh = \"a.obj\"\nnormal_map = \"n.png\"\nnormal_map_green = \"y\"", ":6:20",
     "'scene.normal_map_green' is \"y\"; it must be one of: up, down"},
    {"UnknownModel", kProfile, "name = \"spike-and-base\"\n[profile.of]\nmodel = \"dipole\"", ":16:9",
     "'profile.of.model' is \"dipole\"; it must be one of: classical-dipole, better-dipole, multipole"},
    {"UnknownMetric", "[timing]", "[[threshold]]\nmethod = \"none\"\nmetric = \"mse\"\nmaximum = 1\n[timing]",
     ":21:10", "'threshold.metric' is \"mse\"; it must be one of: bias, "},
    // Missing: at the table that lacks it.
    {"NoScene", "[scene]\nmesh = \"builtin:plane\"", "", ":1:1", "'scene' is missing"},
    {"NoMesh", kMesh, "", ":3:1", "'scene.mesh' is missing"},
    {"NoLight", "[[light]]\ndirection = [0.0, 0.0, 1.0]", "", ":1:1", "'light' is missing"},
    {"NoDirection", kDirection, "", ":6:1", "'light.direction' is missing"},
    {"NoPosition", kDirection, "type = \"point\"", ":6:1", "'light.position_mm' is missing"},
    {"NoMap", kDirection, "type = \"environment\"", ":6:1", "'light.map' is missing"},
    {"NoView", kView, "", ":1:1", "'view' is missing"},
    {"NoEye", kEye, "", ":9:1", "'view.eye_mm' is missing"},
    {"NoProfile", "[[profile]]\nname = \"spike-and-base\"", "", ":1:1", "'profile' is missing"},
    {"NoMethod", "[[method]]\nname = \"none\"", "", ":1:1", "'method' is missing"},
    {"ZeroWeights", kProfile, "name = \"x\"\n[[profile.gaussian]]\nvariance_mm2 = 1\nweight = 0", ":15:1",
     "a profile needs a [[profile.gaussian]] whose 'weight' is not 0"},
    {"NoVariance", kProfile, "name = \"x\"\n[[profile.gaussian]]\nweight = 1", ":15:1",
     "'profile.gaussian.variance_mm2' is missing"},
    {"NoWeight", kProfile, "name = \"x\"\n[[profile.gaussian]]\nvariance_mm2 = 1", ":15:1",
     "'profile.gaussian.weight' is missing"},
    {"NoGaussian", kProfile, "name = \"x\"\ngaussian = []", ":15:12",
     "a profile needs at least one [[profile.gaussian]]"},
    {"NoModel", kProfile, "name = \"x\"\n[profile.of]\nmaterial = \"skin1\"", ":15:1",
     "'profile.of.model' is missing"},
    {"NoMaterial", kProfile, "name = \"x\"\n[profile.of]\nmodel = \"multipole\"", ":15:1",
     "'profile.of.sigma_a' is missing"},
    {"NoThickness", kProfile, "name = \"x\"\n[profile.of]\nmodel = \"multipole\"\nmaterial = \"skin1\"",
     ":15:1", "'profile.of.thickness_mm' is missing"},
    {"NoMaximum", "[timing]", "[[threshold]]\nmethod = \"none\"\n[timing]", ":19:1",
     "'threshold.maximum' is missing"},
    // What does not go together.
    {"TwoViews", "[timing]", "[[view]]\nname = \"front\"\neye_mm = [0, 0, 1]\n[timing]", ":20:8",
     "two views are named 'front'"},
    {"TwoProfiles", "[timing]", "[[profile]]\nname = \"spike-and-base\"\n[timing]", ":20:8",
     "two profiles are named 'spike-and-base'"},
    {"TwoMethods", "[timing]", "[[method]]\nname = \"none\"\n[timing]", ":20:8",
     "two methods have the label 'none'"},
    {"TwoLabels", "[timing]", "[[method]]\nname = \"pscbf\"\nlabel = \"none\"\n[timing]", ":21:9",
     "two methods have the label 'none'"},
    {"NoSuchMethod", "[timing]", "[[threshold]]\nmaximum = 1\nmethod = \"pscbf\"\n[timing]", ":21:10",
     "'threshold.method' is \"pscbf\", which is no method's label here"},
    {"ZeroDirection", kDirection, "direction = [0.0, 0.0, 0.0]", ":7:13",
     "'light.direction' must not be zero"},
    {"EyeIsTarget", kEye, "eye_mm = [1, 2, 3]\ntarget_mm = [1, 2, 3]", ":11:10",
     "'view.eye_mm' and 'view.target_mm' are the same point"},
    {"UpIsForward", kEye, "eye_mm = [0, 0, 100]\nup = [0, 0, -3]", ":12:6",
     "'view.up' is parallel to the viewing direction"},
    {"UpIsForwardByDefault", kEye, "eye_mm = [0, 100, 0]", ":11:10",
     "'view.up' is parallel to the viewing direction"},
    {"UpIsZero", kEye, "eye_mm = [0, 0, 100]\nup = [0, 0, 0]", ":12:6",
     "'view.up' is parallel to the viewing direction"},
    {"SlashInAView", "name = \"front\"", "name = \"a/b\"", ":10:8", "'view.name' names files: "},
    {"EmptyView", "name = \"front\"", "name = \"\"", ":10:8", "'view.name' names files: "},
    {"SlashInALabel", kMethod, "name = \"none\"\nlabel = \"a/b\"", ":18:9", "'method.label' names files: "},
    {"SlashInAProfile", kProfile, "name = \"../x\"", ":14:8", "'profile.name' names files: "},
    {"LabelOfTheTruth", kMethod, "name = \"none\"\nlabel = \"truth\"", ":18:9",
     "'method.label' is \"truth\"; \"truth\", \"mask\" and what starts with"},
    {"LabelOfALadder", kMethod, "name = \"none\"\nlabel = \"ladder-x\"", ":18:9",
     "'method.label' is \"ladder-x\""},
    {"LabelOfATruthOfALadder", kMethod, "name = \"none\"\nlabel = \"truth-cut\"", ":18:9",
     "'method.label' is \"truth-cut\""},
    {"LabelOfTheMask", kMethod, "name = \"none\"\nlabel = \"mask\"", ":18:9", "'method.label' is \"mask\""},
    {"NameOutside", "name = \"good\"", "name = \"../good\"", ":1:8",
     "'name' names the folder of the results"},
    {"UnitOfABuiltin", kMesh, "mesh = \"builtin:plane\"\nunit_mm = 2.0", ":5:11",
     "'scene.unit_mm' is for mesh files"},
    {"StrengthOfNoMap", kMesh, "mesh = \"a.obj\"\nnormal_map_strength = 2.0", ":5:23",
     "'scene.normal_map_strength' needs a 'scene.normal_map'"},
    {"GreenOfNoMap", kMesh, "mesh = \"a.obj\"\nnormal_map_green = \"up\"", ":5:20",
     "'scene.normal_map_green' needs a 'scene.normal_map'"},
    {"EdgeOfNoMap", "[timing]", "[shading]\nnormal_map_edge_mm = 0.2\n[timing]", ":20:22",
     "'shading.normal_map_edge_mm' needs a 'scene.normal_map'"},
    {"MaterialAndCoefficients", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"multipole\"\nmaterial = \"skin1\"\nsigma_a = 1", ":18:11",
     "'profile.of.sigma_a' is the material's: give one or the other"},
    {"EmptyMaterial", kProfile, "name = \"x\"\n[profile.of]\nmodel = \"multipole\"\nmaterial = \"\"",
     ":17:12", "'profile.of.material' must not be empty"},
    {"ThicknessOfADipole", kProfile,
     "name = \"x\"\n[profile.of]\nmodel = \"better-dipole\"\nmaterial = \"skin1\"\nthickness_mm = 1",
     ":18:16", "'profile.of.thickness_mm' is for the multipole"},
    {"NumberForAGrid", kMethod, "name = \"pscbf\"\ngrid.taps = 7", ":18:13",
     "'method.grid.taps' must be an array of at least one number or string"},
    {"EmptyGrid", kMethod, "name = \"pscbf\"\ngrid.taps = []", ":18:13",
     "'method.grid.taps' must be an array of at least one number or string"},
    {"FlagInAGrid", kMethod, "name = \"pscbf\"\n[method.grid]\ntaps = [7, true]", ":19:12",
     "'method.grid.taps' must hold numbers or strings"},
    {"NanInAGrid", kMethod, "name = \"pscbf\"\ngrid.taps = [7.0, nan]", ":18:19",
     "'method.grid.taps' must hold finite numbers"},
    {"TwiceInAGrid", kMethod, "name = \"pscbf\"\ngrid.taps = [7, 7.0]", ":18:17",
     "'method.grid.taps' holds this value twice"},
    {"GridOfASetting", kMethod, "name = \"pscbf\"\nsettings.taps = 5\ngrid.taps = [7]", ":19:13",
     "'method.grid.taps' is in 'method.settings' too"},
    {"GridOfAPicture", kMethod, "name = \"mine\"\nimage = \"a.exr\"\n[method.grid]\ntaps = [7]", ":19:1",
     "'method.grid' is for GLSL and built-in methods"},
    {"GridWithALabelOfAnother", kMethod,
     "name = \"pscbf\"\nlabel = \"a_taps-3\"\n[[method]]\nname = \"pscbf\"\nlabel = \"a\"\ngrid.taps = [3, "
     "5]",
     ":21:9", "two methods have the label 'a_taps-3'"},
    {"ParametersOfAFile", kMesh, "mesh = \"a.obj\"\n[scene.parameters]\nsize_mm = 1.0", ":5:1",
     "'scene.parameters' is for built-in scenes"},
};

INSTANTIATE_TEST_SUITE_P(Table, BrokenExperiment, testing::ValuesIn(kBroken),
                         [](const auto& one) { return std::string(one.param.what); });

// The cases break a text that is good.
TEST(BrokenExperiments, BeginWithAGoodOne) {
  const test::TempDir folder;
  EXPECT_EQ(read_experiment(folder.write("e.toml", kGood)).name, "good");
}

TEST(BrokenExperiments, UnderlineTheValue) {
  const test::TempDir folder;
  std::string text = kGood;
  text.replace(text.find("100.0"), 5, "\"far\"");
  const std::filesystem::path file = folder.write("e.toml", text);
  const auto error = test::error_of([&] { read_experiment(file); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->what(), file.string() +
                               ":11:21: 'view.eye_mm' must be a number\n"
                               " 11 | eye_mm = [0.0, 0.0, \"far\"]\n"
                               "    |                     ^~~~~");
}

TEST(BrokenExperiments, EmptyOrAbsent) {
  const test::TempDir folder;
  const std::filesystem::path empty = folder.write("empty.toml", "");
  const auto nothing = test::error_of([&] { read_experiment(empty); });
  ASSERT_TRUE(nothing.has_value());
  EXPECT_EQ(std::string(nothing->what()).rfind(empty.string() + ":1:1: 'scene' is missing", 0), 0U)
      << nothing->what();
  const std::filesystem::path none = folder.path() / "none.toml";
  const auto absent = test::error_of([&] { read_experiment(none); });
  ASSERT_TRUE(absent.has_value());
  EXPECT_EQ(absent->what(), none.string() + ": no such file");
}

}  // namespace
}  // namespace truescatter
