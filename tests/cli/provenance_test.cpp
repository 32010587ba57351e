// Where what the program writes comes from, read back from each kind of output; and a run that its own
// resolved experiment repeats.
#include <map>

#include "cli/cli_fixture.h"
#include "core/content_hash.h"
#include "core/image_io.h"

namespace truescatter::test {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

class CliProvenance : public Cli {
 protected:
  std::string hash(const std::string& name) const { return hash_of_file(folder_.path() / name); }
};

void expect_program(const Json& provenance) {
  for (const char* key : {"version", "commit", "commit_dirty", "compiler", "build_type", "instruction_set"})
    EXPECT_TRUE(provenance.contains(key)) << key;
  EXPECT_EQ(provenance.at("program"), hash_of_file(TRUESCATTER_BINARY));
  EXPECT_EQ(provenance.at("image_library"),
            hash_of_file(fs::path(TRUESCATTER_BINARY).parent_path() / "libtruescatter_images.so"));
  EXPECT_TRUE(provenance.at("libraries").is_object());
  EXPECT_FALSE(provenance.at("libraries").empty());
}

void expect_files(const Json& provenance, const Json& inputs) {
  expect_program(provenance);
  EXPECT_GE(provenance.at("machine").at("cores"), 1);
  EXPECT_EQ(provenance.at("inputs"), inputs);
}

// "truescatter 1.2.3 (COMMIT)".
std::string software_of(const Json& provenance) {
  return "truescatter " + provenance.at("version").get<std::string>() + " (" +
         provenance.at("commit").get<std::string>() +
         (provenance.at("commit_dirty").get<bool>() ? " with changes)" : ")");
}

TEST_F(CliProvenance, IsInEveryPictureOfARun) {
  folder_.write("mine.frag",
                "SAMPLER(irradiance);\nvoid main() { result = read_texel(irradiance, "
                "ivec2(gl_FragCoord.xy)); }\n");
  const ProgramResult result =
      run(kTiny +
              "[[method]]\nname = \"mine\"\n[[method.pass]]\nshader = \"mine.frag\"\ninputs = "
              "[\"irradiance\"]\n[[method]]\nname = \"cbf\"\n"
              "[[ladder]]\nname = \"cut\"\n[[ladder.rung]]\ntruth = \"whole\"\nassumption = \"none\"\n"
              "[[ladder.rung]]\ntruth = \"cut\"\nassumption = \"the kernel ends at r_max\"\n",
          {"--export-inputs", "--export-passes"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json provenance = json("out/results.json").at("provenance");
  std::map<std::string, int> seen;
  for (const auto& entry : fs::recursive_directory_iterator(folder_.path() / "out")) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".exr" && extension != ".png") continue;
    const ImageTexts texts = read_image_texts(entry.path());
    ASSERT_TRUE(texts.contains("Software")) << entry.path();
    EXPECT_EQ(texts.at("Software"), software_of(provenance)) << entry.path();
    ASSERT_TRUE(texts.contains("truescatter:experiment")) << entry.path();
    EXPECT_EQ(texts.at("truescatter:experiment"), provenance.at("experiment")) << entry.path();
    EXPECT_FALSE(texts.contains("DateTime") && !texts.at("DateTime").empty()) << entry.path();
    ++seen[entry.path().parent_path().filename().string() + extension];
  }
  for (const char* kind : {"maps.exr", "maps.png", "inputs.exr", "passes.exr", "passes.png"})
    EXPECT_GT(seen[kind], 0) << kind;
  EXPECT_EQ(json("out/inputs/front.json").at("origin").at("Software"), software_of(provenance));
}

TEST_F(CliProvenance, IsInAFitAndItsSources) {
  folder_.write("t.csv", "r_mm,r,g,b\n0.1,1,1,1\n1,0.5,0.4,0.3\n2,0.1,0.05,0.02\n4,0.01,0.004,0.001\n");
  const std::vector<std::string> fit = {"fit", "--profile", "table", "--table", "t.csv"};
  const auto with_words = [&](std::vector<std::string> words) {
    words.insert(words.begin(), fit.begin(), fit.end());
    const ProgramResult result = truescatter(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  };
  with_words({"--gaussians", "2", "--out", "f.json", "--glsl", "f.glsl", "--cpp", "f.h"});
  const Json provenance = json("f.json").at("provenance");
  expect_files(provenance, {{"t.csv", hash("t.csv")}});
  for (const char* source : {"f.glsl", "f.h"})
    EXPECT_TRUE(contains(text(source), "; by " + software_of(provenance) + "\n")) << text(source);
  with_words({"--score", "f.json", "--out", "s.json"});
  expect_files(json("s.json").at("provenance"), {{"t.csv", hash("t.csv")}, {"f.json", hash("f.json")}});
}

TEST_F(CliProvenance, IsInWhatCompareAndAdviseSay) {
  const Image picture(16, 8, 3, 0.5F);
  for (const char* name : {"a.exr", "b.exr"}) write_exr(folder_.path() / name, {{"", &picture}});
  const Image mask(16, 8, 1, 1.0F);
  write_exr(folder_.path() / "m.exr", {{"", &mask}});
  const auto said = [&](const std::vector<std::string>& words) {
    const ProgramResult result = truescatter(words);
    EXPECT_LE(result.exit_code, 1) << result.err;
    return Json::parse(result.out);
  };
  expect_files(said({"compare", "a.exr", "b.exr", "--mask", "m.exr", "--json"}).at("provenance"),
               {{"a.exr", hash("a.exr")}, {"b.exr", hash("b.exr")}, {"m.exr", hash("m.exr")}});
  ASSERT_EQ(run(kTiny).exit_code, 0);
  const std::string results = hash("out/results.json");
  expect_files(said({"compare", "out", "out", "--json"}).at("compared_by"), {{"out/results.json", results}});
  const Json advice = said({"advise", "out", "--json"});
  EXPECT_EQ(advice.at("provenance"), json("out/results.json").at("provenance"));
  expect_program(advice.at("advised_by"));
}

// All that an experiment can name by a path, in a folder that is neither the working folder nor the results'.
class CliRepeat : public CliProvenance {
 protected:
  void write_inputs() const {
    fs::create_directories(folder_.path() / "in");
    folder_.write("in/m.obj",
                  "v -10 -10 0\nv 10 -10 0\nv 10 10 0\nv -10 10 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                  "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    Image albedo(4, 4, 3, 0.8F);
    albedo.set_rgb(1, 2, {0.2, 0.4, 0.6});
    write_png(folder_.path() / "in/albedo.png", albedo);
    Image normals(4, 4, 3);
    for (int i = 0; i < 16; ++i)
      normals.set_rgb(i % 4, i / 4, {0.5, i % 3 == 0 ? 0.75 : 0.5, i % 3 == 0 ? 0.933 : 1.0});
    write_exr(folder_.path() / "in/normals.exr", {{"", &normals}});
    const Image skin(4, 4, 1, 1.0F);
    write_png(folder_.path() / "in/skin.png", skin);
    folder_.write("in/half.glsl", "float half_of(float x) { return 0.5 * x; }\n");
    folder_.write("in/mine.frag",
                  "SAMPLER(irradiance);\nvoid main() {\n  vec4 light = read_texel(irradiance, "
                  "ivec2(gl_FragCoord.xy));\n  result = vec4(half_of(2.0) * light.rgb, light.a);\n}\n");
    const ProgramResult fitted = truescatter(
        {"fit", "--profile", "dipole", "--material", "skin1", "--gaussians", "2", "--out", "in/fit.json"});
    ASSERT_EQ(fitted.exit_code, 0) << fitted.err;
  }
  // Everything but time and the memory that was taken, and with paths as the experiment has them.
  Json content(const std::string& name) const {
    std::string bytes = text(name);
    const std::string absolute = fs::canonical(folder_.path() / "in").string() + "/";
    for (std::size_t at = bytes.find(absolute); at != std::string::npos; at = bytes.find(absolute))
      bytes.erase(at, absolute.size());
    Json parsed = Json::parse(bytes);
    parsed.at("provenance").at("memory").erase("peak_bytes");
    return timeless(parsed);
  }
  static Json timeless(const Json& value) {
    if (!value.is_structured()) return value;
    Json rest = value.is_array() ? Json::array() : Json::object();
    for (const auto& [key, inner] : value.items()) {
      if (value.is_array()) {
        rest.push_back(timeless(inner));
      } else if (key != "frame_ms" && key != "setup_ms" && key != "seconds" && key != "finished_utc") {
        rest[key] = timeless(inner);
      }
    }
    return rest;
  }
};

TEST_F(CliRepeat, TheResolvedExperimentRepeatsARunOfFilesByteForByte) {
  write_inputs();
  folder_.write("in/e.toml", R"(name = "files"
[scene]
mesh = "m.obj"
skin_mask = "skin.png"
albedo = "albedo.png"
texturing = "mix"
normal_map = "normals.exr"
[[light]]
direction = [0.0, 0.5, 1.0]
[shading]
floor_mm = 2.0
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 100.0]
fov_deg = 10.0
width_px = 32
height_px = 32
[[profile]]
name = "from-file"
fit.file = "fit.json"
[[profile]]
name = "fitted"
fit.gaussians = 1
fit.seed = 13
of = {model = "classical-dipole", material = "skin2", truth = false}
[[method]]
name = "pscbf"
[[method]]
name = "mine"
run = "once"
include = ["half.glsl"]
[[method.pass]]
shader = "mine.frag"
inputs = ["irradiance"]
[truth]
seed = 11
[stability]
jitter = {views = 2}
points = 50
seed = 12
[timing]
warm_up = 0
repeats = 1
)");
  const ProgramResult first = truescatter({"run", "in/e.toml", "--out", "out", "--no-cache"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const std::string resolved = text("out/experiment.resolved.toml");
  for (const char* seed : {"seed = 11\n", "seed = 12\n", "seed = 13\n"})
    EXPECT_TRUE(contains(resolved, seed)) << seed << "in\n" << resolved;
  const ProgramResult second =
      truescatter({"run", "out/experiment.resolved.toml", "--out", "deeper/again", "--no-cache"});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(text("deeper/again/experiment.resolved.toml"), resolved);
  EXPECT_EQ(content("deeper/again/results.json").dump(1), content("out/results.json").dump(1));
  std::size_t pictures = 0;
  for (const auto& entry : fs::directory_iterator(folder_.path() / "out/maps")) {
    const std::string name = "/maps/" + entry.path().filename().string();
    EXPECT_EQ(text("deeper/again" + name), text("out" + name)) << name;
    ++pictures;
  }
  EXPECT_GE(pictures, 8U);
}

// The program is two files: without the second, which knows pictures' formats, nothing is begun.
TEST_F(CliProvenance, APartOfTheProgramThatIsMissingIsNamed) {
  fs::copy_file(TRUESCATTER_BINARY, folder_.path() / "truescatter");
  folder_.write("e.toml", kTiny);
  const ProgramResult result =
      run_program(folder_.path() / "truescatter", {"run", "e.toml", "--out", "out"}, folder_.path());
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_TRUE(contains(result.err, "libtruescatter_images.so: this part of the program")) << result.err;
  EXPECT_FALSE(exists("out"));
}

}  // namespace
}  // namespace truescatter::test
