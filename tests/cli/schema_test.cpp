// That a results.json which is not laid out as it should be is found out: every other test of `run` relies on
// it.
#include "cli/cli_fixture.h"

namespace truescatter::test {
namespace {

TEST_F(Cli, AResultThatIsNotLaidOutAsTheSchemaSaysIsFoundOut) {
  ASSERT_EQ(run(kTiny).exit_code, 0);
  const nlohmann::json whole = json("out/results.json");
  ASSERT_EQ(schema_violations(whole), "");
  const auto violations = [&](const auto& change) {
    nlohmann::json changed = whole;
    change(changed);
    return schema_violations(changed);
  };
  EXPECT_TRUE(contains(violations([](auto& r) { r["runs"][0]["metrics"].erase("rmse"); }), "'rmse'"));
  EXPECT_TRUE(contains(violations([](auto& r) { r["runs"][1]["more"] = 1; }), "'more'"));
  EXPECT_NE(violations([](auto& r) { r["views"][0]["width_px"] = 48.5; }), "");
  EXPECT_NE(violations([](auto& r) { r["views"][0]["width_px"] = "48"; }), "");
  EXPECT_NE(violations([](auto& r) { r["views"][0]["skin_pixels"] = -1; }), "");
  EXPECT_NE(violations([](auto& r) { r["provenance"]["program"] = "abc"; }), "");
}

}  // namespace
}  // namespace truescatter::test
