#include <sstream>

#include "cli/cli_fixture.h"

namespace truescatter::test {
namespace {

using Json = nlohmann::json;

const std::string kGeodesic = with(kTiny, "[timing]", "[truth]\ngeodesic = \"extra\"\n[timing]");

class CliCache : public Cli {
 protected:
  // results.json of a run that must succeed, without what a clock says.
  Json results(const std::string& experiment, const std::vector<std::string>& arguments = {}) {
    const ProgramResult result = run(experiment, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    said_ = result.err;
    Json results = json("out/results.json");
    results.erase("provenance");
    for (Json& run : results.at("runs")) run.erase("cost");
    return results;
  }
  // Whether each truth was cached; takes it out of the results.
  static std::vector<bool> take_cached(Json& results) {
    std::vector<bool> cached;
    for (Json& truth : results.at("truths")) {
      cached.push_back(truth.at("cached").get<bool>());
      truth.erase("cached");
    }
    return cached;
  }

  std::string said_;  // on standard error
};

// The second run takes every layer from the cache: the same results to the last digit, down to the seconds
// that computing them took.
TEST_F(CliCache, ASecondRunGivesTheSameFromTheCache) {
  Json first = results(kGeodesic);
  EXPECT_EQ(take_cached(first), std::vector<bool>(3, false));
  // Three Gaussians, uncut and along the surface; two of them are cut at 4.5 mm, for the third that cut is
  // none.
  const std::size_t files = cache_.names().size();
  EXPECT_GE(files, 6U);
  Json second = results(kGeodesic);
  EXPECT_EQ(take_cached(second), std::vector<bool>(3, true));
  EXPECT_EQ(second.dump(1), first.dump(1));
  EXPECT_EQ(cache_.names().size(), files);
}

TEST_F(CliCache, IsLeftAloneWhereARunSaysSo) {
  Json first = results(kTiny, {"--no-cache"});
  EXPECT_EQ(take_cached(first), std::vector<bool>(2, false));
  EXPECT_TRUE(cache_.names().empty());
  results(kTiny, {"--set", "truth.cache=false"});
  EXPECT_TRUE(cache_.names().empty());
  results(kTiny);
  EXPECT_FALSE(cache_.names().empty());
  Json again = results(kTiny, {"--no-cache"});
  EXPECT_EQ(take_cached(again), std::vector<bool>(2, false));
}

TEST_F(CliCache, IsNotNeeded) {
  const EnvironmentVariable below_a_file("TRUESCATTER_CACHE", (folder_.write("file", "") / "cache").string());
  results(kTiny);
  EXPECT_TRUE(contains(said_, "/file/cache: truths cannot be cached here: ")) << said_;
}

// Cut off in the middle, as a full disk or a crash of the machine leaves it.
TEST_F(CliCache, ADamagedFileIsComputedAgain) {
  Json first = results(kTiny);
  for (const std::string& name : cache_.names()) {
    const std::string bytes = read_text_file(cache_.path() / name);
    cache_.write(name, bytes.substr(0, bytes.size() / 2));
  }
  Json second = results(kTiny);
  EXPECT_TRUE(contains(said_, "this cached truth is damaged; it is computed again")) << said_;
  EXPECT_EQ(take_cached(second), std::vector<bool>(2, false));
  Json third = results(kTiny);
  EXPECT_EQ(take_cached(third), std::vector<bool>(2, true));
}

TEST_F(CliCache, ServesTwoRunsAtOnce) {
  folder_.write("e.toml", kGeodesic);
  const ProgramResult both = run_program(
      "/bin/sh",
      {"-c", "\"$0\" run e.toml --out a & a=$!; \"$0\" run e.toml --out b; b=$?; wait $a && exit $b",
       TRUESCATTER_BINARY},
      folder_.path());
  ASSERT_EQ(both.exit_code, 0) << both.err;
  // One may have waited for the other; nothing else is to be noted.
  std::istringstream lines(both.err);
  for (std::string line; std::getline(lines, line);)
    EXPECT_EQ(contains(line, "note:"), contains(line, "another process computes this truth")) << both.err;
  EXPECT_EQ(json("a/results.json").at("runs").at(0).at("metrics"),
            json("b/results.json").at("runs").at(0).at("metrics"));
  Json third = results(kGeodesic);
  EXPECT_EQ(take_cached(third), std::vector<bool>(3, true));
}

}  // namespace
}  // namespace truescatter::test
