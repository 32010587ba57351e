#include <unistd.h>

#include <cstdlib>
#include <limits>

#include "cli/cli_fixture.h"
#include "core/image_io.h"

namespace truescatter::test {
namespace {

const std::string kMeshFile = with(kTiny, R"(mesh = "builtin:plane"
[scene.parameters]
size_mm = 20.0
edge_mm = 5.0
)",
                                   R"(mesh = "a.obj"
obtain = "Ask the librarian."
)");

// A square of 20 mm without UVs.
const std::string kSquareObj = "v -10 -10 0\nv 10 -10 0\nv 10 10 0\nv -10 10 0\nf 1 2 3\nf 1 3 4\n";

TEST_F(CliErrors, NoSuchExperiment) {
  expect_refused(truescatter({"run", "none.toml", "--out", "out"}), {"truescatter: none.toml: no such file"});
}

TEST_F(CliErrors, AFolderForAnExperiment) {
  expect_refused(truescatter({"run", ".", "--out", "out"}), {"is a folder"});
}

TEST_F(CliErrors, WrongUsage) {
  expect_refused(run(kTiny, {"--frobnicate"}), {"--frobnicate"});
  expect_refused(run(kTiny, {"--jobs", "0"}), {"--jobs"});
  expect_refused(run(kTiny, {"--jobs", "two"}), {"--jobs"});
  const std::string known = "there are: run, truth, fit, compare, advise, merge, report, list (see --help)\n";
  expect_refused(truescatter({}), {"truescatter: a command is needed; " + known});
  expect_refused(truescatter({"frobnicate"}), {"truescatter: there is no command 'frobnicate'; " + known});
  expect_refused(truescatter({"rum", "e.toml"}), {"truescatter: there is no command 'rum'; " + known});
  expect_refused(truescatter({"--frobnicate"}),
                 {"truescatter: '--frobnicate' where a command is needed; " + known});
  expect_refused(truescatter({"run"}), {"experiment"});
}

TEST_F(CliErrorsBeforeComputing, UnknownKey) {
  expect_refused(run(with(kTiny, "repeats = 1", "repeat = 1")),
                 {"truescatter: e.toml:30:10: unknown key 'timing.repeat'"});
}

TEST_F(CliErrorsBeforeComputing, BadOverride) {
  expect_refused(run(kTiny, {"--set", "timing.repeats=0"}),
                 {"truescatter: --set timing.repeats=0: 'timing.repeats' is 0"});
}

TEST_F(CliErrorsBeforeComputing, NegativeUnit) {
  expect_refused(run(with(kMeshFile, "obtain", "unit_mm = -1.0\nobtain")),
                 {"truescatter: e.toml:5:11: 'scene.unit_mm' is -1"});
}

TEST_F(CliErrorsBeforeComputing, UnknownNames) {
  expect_refused(run(with(kTiny, "\"pscbf\"", "\"psc\"")),
                 {"truescatter: e.toml:26:8: there is no method 'psc'; there are: none, "});
  expect_refused(
      run(with(kTiny, "\"spike-and-base\"", "\"spike\"")),
      {"truescatter: e.toml:20:8: there is no built-in profile 'spike'; there are: spike-and-base, "});
  expect_refused(run(with(kTiny, "[[method]]",
                          "[profile.of]\nmodel = \"better-dipole\"\nmaterial = \"skin3\"\n[[method]]")),
                 {"truescatter: e.toml:24:12: there is no material 'skin3'; there are: marble, skin1, "});
  expect_refused(run(with(kTiny, "builtin:plane", "builtin:plain")),
                 {"truescatter: e.toml:4:8: ", "\"plain\" is not a built-in scene", "plane"});
  expect_refused(
      run(with(kTiny, "size_mm", "sise_mm")),
      {"truescatter: e.toml:6:11: ", "the scene \"plane\" has no parameter \"sise_mm\"", "size_mm"});
  expect_refused(run(with(kTiny, "20.0", "-20.0")), {"truescatter: e.toml:6:11: ", "size_mm = -20"});
  expect_refused(run(kTiny, {"--set", "scene.parameters.edge_mm=0"}),
                 {"truescatter: --set scene.parameters.edge_mm=0: ", "edge_mm = 0"});
  expect_refused(run(with(with(kTiny, "20.0", "1000.0"), "5.0", "0.06")),
                 {"truescatter: e.toml:7:11: ", "edge_mm = 0.06: about 5.6e+08 triangles"});
}

TEST_F(CliErrorsBeforeComputing, WrongSettings) {
  const auto with_setting = [](const std::string& line) {
    return with(kTiny, "[timing]", "[method.settings]\n" + line + "\n[timing]");
  };
  expect_refused(run(with_setting("tapes = 3")),
                 {"truescatter: e.toml:29:9: method 'pscbf' has no setting 'tapes'"});
  expect_refused(run(with_setting("taps = -3")),
                 {"truescatter: e.toml:29:8: method 'pscbf': 'taps' is -3; it must lie in "});
  expect_refused(run(with_setting("placement = \"middle\"")),
                 {"truescatter: e.toml:29:13: ", "it must be one of: "});
}

// Nothing of a run that memory does not suffice for is begun.
TEST_F(CliErrorsBeforeComputing, AFrameBeyondTheMemoryLimit) {
  const std::string large =
      with(with(kTiny, "width_px = 48", "width_px = 4096"), "height_px = 48", "height_px = 4096");
  expect_refused(run(large, {"--memory-limit", "0.5"}),
                 {"truescatter: e.toml: scene builtin:plane, view 'front': ", " needs about ",
                  " GiB of memory (", "--memory-limit is 512 MiB; fewer pixels (4096 x 4096) or Gaussians"});
}

TEST_F(CliErrorsBeforeComputing, AFrameBeyondAnyMemory) {
  expect_refused(run(with(kTiny, "width_px = 48", "width_px = 100000")),
                 {"truescatter: e.toml:16:12: 'view.width_px' is 100000; it must lie in [1, 16384]"});
}

// Of a built-in scene the triangles are known about before it is generated, and exactly after.
TEST_F(CliErrors, TrianglesBeyondTheMemoryLimit) {
  const std::string fine = with(kTiny, "edge_mm = 5.0", "edge_mm = 0.1");
  for (const bool dry : {true, false}) {
    std::vector<std::string> arguments = {"--memory-limit", "0.3"};
    if (dry) arguments.emplace_back("--dry-run");
    expect_refused(run(fine, arguments), {"truescatter: e.toml: scene builtin:plane, view 'front': ",
                                          "--memory-limit is 307 MiB", "fewer triangles ("});
  }
}

TEST_F(CliErrors, AdviceBeyondTheMemoryLimit) {
  folder_.write("e.toml", with(kTiny, "edge_mm = 5.0", "edge_mm = 0.1"));
  expect_refused(truescatter({"advise", "e.toml", "--memory-limit", "0.3"}), {"--memory-limit is 307 MiB"});
}

TEST_F(CliErrors, MemoryLimitsThatAreNone) {
  for (const char* limit : {"0", "-1", "all", "nan"})
    expect_refused(run(kTiny, {"--memory-limit", limit}), {"--memory-limit"});
}

TEST_F(CliErrorsBeforeComputing, NoSuchMesh) {
  expect_refused(run(kMeshFile), {"truescatter: e.toml:4:8: no such file: ", "a.obj\nAsk the librarian."});
}

TEST_F(CliErrorsBeforeComputing, UnsetVariable) {
  unsetenv("TRUESCATTER_DATA");
  expect_refused(run(with(kMeshFile, "a.obj", "${TRUESCATTER_DATA}/a.obj")),
                 {"truescatter: e.toml:4:8: ",
                  "the environment variable TRUESCATTER_DATA is not set\nAsk the librarian."});
}

TEST_F(CliErrorsBeforeComputing, NanVertex) {
  folder_.write("a.obj", with(kSquareObj, "10 10 0", "10 nan 0"));
  expect_refused(run(kMeshFile), {"a.obj:3"});
}

TEST_F(CliErrorsBeforeComputing, IndexOutOfRange) {
  folder_.write("a.obj", with(kSquareObj, "f 1 3 4", "f 1 3 5"));
  expect_refused(run(kMeshFile), {"a.obj:6"});
}

TEST_F(CliErrorsBeforeComputing, ATriangleTwice) {
  folder_.write("a.obj", kSquareObj + "f 3 1 2\n");
  expect_refused(run(kMeshFile), {"a.obj: faces 0 and 2 (from 0) are the same triangle"});
}

TEST_F(CliErrorsBeforeComputing, ATJunctionThatPartsTheSurface) {
  // Two triangles on one edge's halves, in whose middle nothing joins the square.
  folder_.write("a.obj", kSquareObj + "v 0 -10 0\nv 0 -20 0\nf 5 1 6\nf 2 5 6\n");
  expect_refused(run(kMeshFile), {"a.obj: the vertex (0, -10, 0) of face", "a T-junction"});
}

TEST_F(CliErrorsBeforeComputing, EmptyMesh) {
  folder_.write("a.obj", "v 0 0 0\n");
  expect_refused(run(kMeshFile), {"a.obj"});
  folder_.write("a.obj", "");
  expect_refused(run(kMeshFile), {"a.obj"});
}

TEST_F(CliErrorsBeforeComputing, UnknownMeshFormat) {
  folder_.write("a.txt", kSquareObj);
  expect_refused(run(with(kMeshFile, "a.obj", "a.txt")), {"a.txt"});
}

TEST_F(CliErrors, AViewThatSeesNoSkin) {
  expect_refused(run(kTiny, {"--set", "view.front.target_mm=[0,0,200]"}),
                 {"e.toml", "view 'front' sees no skin"});
}

// The square faces +z, the light stands behind it.
TEST_F(CliErrors, ALightThatReachesNothing) {
  expect_refused(run(with(kTiny, "[0.0, 0.5, 1.0]", "[0.0, 0.5, -1.0]")),
                 {"e.toml", "no light reaches the skin"});
  expect_refused(run(with(kTiny, "1.0]", "1.0]\ncolor = 0.0")), {"e.toml", "no light reaches the skin"});
}

TEST_F(CliErrors, APointLightOnTheMesh) {
  expect_refused(
      run(with(kTiny, "direction = [0.0, 0.5, 1.0]", "type = \"point\"\nposition_mm = [1.0, 2.0, 0.0]")),
      {"truescatter: e.toml: a point light lies on the mesh"});
}

TEST_F(CliErrorsBeforeComputing, ASkinMaskWithoutUvs) {
  folder_.write("a.obj", kSquareObj);
  write_png(folder_.path() / "mask.png", Image(4, 4, 1, 1.0F));
  expect_refused(run(with(kMeshFile, "obtain", "skin_mask = \"mask.png\"\nobtain")),
                 {"truescatter: e.toml:5:13: ", "'scene.skin_mask'", "has no UVs"});
}

TEST_F(CliErrorsBeforeComputing, ASkinMaskThatCannotBeRead) {
  const std::string masked =
      with(kTiny, "[scene.parameters]", "skin_mask = \"mask.png\"\n[scene.parameters]");
  expect_refused(run(masked), {"truescatter: e.toml:5:13: no such file: "});
  folder_.write("mask.png", "no picture");
  expect_refused(run(masked), {"mask.png: cannot read this image"});
}

TEST_F(CliErrors, ANormalMapWithoutUvs) {
  folder_.write("a.obj", kSquareObj);
  write_png(folder_.path() / "map.png", Image(4, 4, 3, 0.5F));
  expect_refused(run(with(kMeshFile, "obtain", "normal_map = \"map.png\"\nobtain")),
                 {"truescatter: e.toml:5:14: ", "'scene.normal_map'", "has no UVs"});
}

TEST_F(CliErrors, ANormalMapThatCannotBeUsed) {
  const std::string mapped =
      with(kTiny, "[scene.parameters]", "normal_map = \"map.png\"\n[scene.parameters]");
  expect_refused(run(mapped), {"truescatter: e.toml:5:14: no such file: ", "map.png"});
  folder_.write("map.png", "no picture");
  expect_refused(run(mapped), {"map.png: cannot read this image"});
  write_png(folder_.path() / "map.png", Image(4, 4, 1, 0.5F));
  expect_refused(run(mapped), {"truescatter: e.toml:5:14: 'scene.normal_map' needs red, green and blue, but ",
                               "map.png has 1 channel"});
}

TEST_F(CliErrors, AnAlbedoThatCannotBeUsed) {
  const std::string coloured = with(kTiny, "[scene.parameters]", "albedo = \"a.png\"\n[scene.parameters]");
  expect_refused(run(coloured), {"truescatter: e.toml:5:10: no such file: ", "a.png"});
  write_png(folder_.path() / "a.png", Image(4, 4, 1, 0.5F));
  expect_refused(run(coloured), {"truescatter: e.toml:5:10: 'scene.albedo' needs red, green and blue, but "});
  const std::string linear = with(kTiny, "[scene.parameters]", "albedo = \"a.exr\"\n[scene.parameters]");
  Image negative(4, 4, 3, 0.5F);
  negative.at(2, 1, 0) = -0.1F;
  write_exr(folder_.path() / "a.exr", {{"", &negative}});
  expect_refused(run(linear), {"truescatter: e.toml:5:10: 'scene.albedo' must not be negative, but a.exr "});
  folder_.write("a.obj", kSquareObj);
  expect_refused(run(with(kMeshFile, "obtain", "albedo = \"a.png\"\nobtain")),
                 {"truescatter: e.toml:5:10: ", "'scene.albedo' is a texture in UV, but a.obj has no UVs"});
}

TEST_F(CliErrorsBeforeComputing, ATextureThatIsNotFinite) {
  Image image(4, 4, 3, 0.5F);
  image.at(1, 2, 0) = std::numeric_limits<float>::quiet_NaN();
  write_exr(folder_.path() / "t.exr", {{"", &image}});
  for (const std::string key : {"skin_mask", "transmitter_mask", "normal_map", "albedo"}) {
    expect_refused(
        run(with(kTiny, "[scene.parameters]", key + " = \"t.exr\"\n[scene.parameters]")),
        {"truescatter: e.toml:5:", "'scene." + key + "' must be finite, but ", "t.exr holds a value"});
  }
}

TEST_F(CliErrorsBeforeComputing, AnEnvironmentThatIsNone) {
  const auto lit_by = [](const std::string& map) {
    return with(kTiny, "direction = [0.0, 0.5, 1.0]", "type = \"environment\"\nmap = \"" + map + "\"");
  };
  expect_refused(run(lit_by("builtin:studio")),
                 {"truescatter: e.toml:11:7: \"studio\" is not a built-in environment: uniform, "});
  expect_refused(run(lit_by("sky.exr")), {"truescatter: e.toml:11:7: no such file: ", "sky.exr"});
  Image square(4, 4, 3, 0.5F);
  write_exr(folder_.path() / "sky.exr", {{"", &square}});
  expect_refused(run(lit_by("sky.exr")),
                 {"truescatter: e.toml:11:7: 'light.map' must be twice as wide as high", "is 4 x 4 pixels"});
  Image negative(8, 4, 3, 0.5F);
  negative.at(3, 2, 1) = -1.0F;
  write_exr(folder_.path() / "sky.exr", {{"", &negative}});
  expect_refused(run(lit_by("sky.exr")),
                 {"truescatter: e.toml:11:7: 'light.map' must be finite and not negative, but ",
                  "sky.exr is not at column 3, row 2"});
}

TEST_F(CliErrors, AMaskThatLeavesNoSkin) {
  write_png(folder_.path() / "mask.png", Image(4, 4, 1, 0.0F));
  expect_refused(run(with(kTiny, "[scene.parameters]", "skin_mask = \"mask.png\"\n[scene.parameters]")),
                 {"truescatter: e.toml:5:13: the mask leaves no skin"});
}

// Everything below is refused before anything is computed: no stage has said that it began.
TEST_F(CliErrorsBeforeComputing, AnOutputFolderThatIsAFile) {
  folder_.write("out", "precious");
  const ProgramResult result = run(kTiny);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err, "truescatter: out: is a file; the results need a folder, which `run` makes\n");
  EXPECT_EQ(text("out"), "precious");
}

TEST_F(CliErrorsBeforeComputing, AnOutputFolderWithOtherFiles) {
  std::filesystem::create_directory(folder_.path() / "out");
  folder_.write("out/thesis.tex", "precious");
  const ProgramResult result = run(kTiny);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "truescatter: out: holds 'thesis.tex', which is no result of truescatter"))
      << result.err;
  EXPECT_FALSE(contains(result.err, "scene")) << result.err;
  EXPECT_EQ(text("out/thesis.tex"), "precious");
}

TEST_F(CliErrors, TheWorkingFolderForOutput) {
  folder_.write("e.toml", kTiny);
  const ProgramResult result = truescatter({"run", "e.toml", "--out", "."});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "truescatter: .: the program runs in this folder")) << result.err;
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"e.toml"});
}

// Not even root can make a folder there.
TEST_F(CliErrors, AnOutputFolderThatCannotBeMade) {
  folder_.write("e.toml", kTiny);
  const ProgramResult result = truescatter({"run", "e.toml", "--out", "/proc/truescatter-out"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_TRUE(contains(result.err, "truescatter: /proc/truescatter-out: cannot make a folder beside it"))
      << result.err;
  EXPECT_FALSE(contains(result.err, "scene")) << result.err;
}

TEST_F(CliErrors, AnOutputFolderBelowAFile) {
  folder_.write("e.toml", kTiny);
  folder_.write("file", "precious");
  const ProgramResult result = truescatter({"run", "e.toml", "--out", "file/out"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_TRUE(contains(result.err, "truescatter: file/out: cannot make a folder beside it")) << result.err;
  EXPECT_EQ(text("file"), "precious");
}

TEST_F(CliErrors, AParentThatIsReadOnly) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  folder_.write("e.toml", kTiny);
  const std::filesystem::path parent = folder_.path() / "parent";
  std::filesystem::create_directory(parent);
  std::filesystem::permissions(parent,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const ProgramResult result = truescatter({"run", "e.toml", "--out", "parent/out"});
  std::filesystem::permissions(parent, std::filesystem::perms::owner_all);
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_TRUE(contains(result.err, "parent/out: cannot make a folder beside it")) << result.err;
}

TEST_F(CliErrorsBeforeComputing, AThresholdOnNoMethod) {
  expect_refused(run(kTiny + "[[threshold]]\nmethod = \"blur2d\"\nmaximum = 1\n"),
                 {"truescatter: e.toml:32:10: 'threshold.method' is \"blur2d\""});
}

TEST_F(CliErrorsBeforeComputing, ABuiltinSceneOfTooManyTriangles) {
  expect_refused(run(with(with(kTiny, "20.0", "1000.0"), "5.0", "0.1")),
                 {"truescatter: e.toml:7:11: ", "edge_mm = 0.1: about 2e+08 triangles"});
}

}  // namespace
}  // namespace truescatter::test
