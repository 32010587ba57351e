#include "experiment/provenance.h"

#include <gtest/gtest.h>

#include "core/content_hash.h"
#include "experiment/input_files.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

using nlohmann::json;
using test::TempDir;

TEST(Provenance, DiffersByTheFirstEntryThatMatters) {
  const json one = {{"commit", "a"}, {"machine", {{"jobs", 1}, {"system", "Linux 6.1"}, {"cores", 2}}}};
  json other = one;
  other["machine"]["jobs"] = 8;
  other["machine"]["system"] = "Linux 6.2";
  EXPECT_EQ(provenance_difference(one, other), "");
  other["machine"]["cores"] = 4;
  EXPECT_EQ(provenance_difference(one, other), "machine/cores was 2 and is 4");
  other = one;
  other["inputs"] = {{"m.obj", "12"}};
  EXPECT_EQ(provenance_difference(one, other), "inputs/m.obj was null and is \"12\"");
  EXPECT_EQ(provenance_difference(other, one), "inputs/m.obj was \"12\" and is null");
}

// The digests of FIPS 180 for "abc" and for nothing.
TEST(HashOfFile, IsThatOfItsBytes) {
  const TempDir folder;
  EXPECT_EQ(hash_of_file(folder.write("abc", "abc")), "a9993e364706816aba3e25717850c26c9cd0d89d");
  EXPECT_EQ(hash_of_file(folder.write("empty", "")), "da39a3ee5e6b4b0d3255bfef95601890afd80709");
  // More than one block, by the hash of the same bytes in memory.
  const std::string large(3000001, 'x');
  ContentHash whole;
  whole.append(large.data(), large.size());
  EXPECT_EQ(hash_of_file(folder.write("large", large)), whole.hex());
}

TEST(InputHashes, HaveEveryFileThatAnExperimentNames) {
  const TempDir folder;
  for (const char* name : {"m.obj", "skin.png", "env.hdr", "t.csv", "f.frag"}) folder.write(name, name);
  folder.write("here.front.exr", "picture");
  const ExperimentSpec spec = read_experiment(folder.write("e.toml", R"(
[scene]
mesh = "m.obj"
skin_mask = "skin.png"
albedo = "skin.png"
[[light]]
type = "environment"
map = "env.hdr"
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 100.0]
[[profile]]
name = "measured"
fit.gaussians = 2
of = {model = "table", table = "t.csv"}
[[method]]
name = "mine"
run = "once"
[[method.pass]]
shader = "f.frag"
inputs = ["irradiance"]
[[method]]
name = "elsewhere"
image = "here.{view}.exr"
[[method]]
name = "not-yet"
image = "not.{view}.exr"
)"));
  const std::map<std::string, std::string> hashes = input_hashes(spec);
  std::vector<std::string> names;
  for (const auto& [name, hash] : hashes) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"env.hdr", "f.frag", "here.{view}.exr (front, measured)",
                                             "m.obj", "skin.png", "t.csv"}));
  EXPECT_EQ(hashes.at("m.obj"), hash_of_file(folder.path() / "m.obj"));
}

}  // namespace
}  // namespace truescatter
