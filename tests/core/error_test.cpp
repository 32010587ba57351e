#include "core/error.h"

#include <gtest/gtest.h>

#include "support/error_of.h"

namespace truescatter {
namespace {

TEST(SourceLocation, LeavesOutWhatIsNotKnown) {
  EXPECT_EQ((SourceLocation{"a.toml", 3, 7}.str()), "a.toml:3:7");
  EXPECT_EQ((SourceLocation{"a.toml", 3, 0}.str()), "a.toml:3");
  EXPECT_EQ((SourceLocation{"a.toml", 0, 0}.str()), "a.toml");
  // A column without its line says nothing.
  EXPECT_EQ((SourceLocation{"a.toml", 0, 7}.str()), "a.toml");
}

TEST(Error, NamesItsPlaceBeforeTheMessage) {
  const Error error(ErrorKind::input, {"a.toml", 3, 7}, "is bad");
  EXPECT_STREQ(error.what(), "a.toml:3:7: is bad");
  EXPECT_EQ(error.where().file, "a.toml");
  EXPECT_EQ(error.where().line, 3);
  EXPECT_EQ(error.where().column, 7);
}

TEST(Error, HasNoPrefixWithoutAFile) { EXPECT_STREQ(Error(ErrorKind::input, {}, "is bad").what(), "is bad"); }

// README, Commands: 2 is wrong usage or input, 3 a failed run.
TEST(Error, KindGivesTheExitCode) {
  const auto input = test::error_of([] { throw_input_error({"f"}, "{} is not {}", 1, 2); });
  ASSERT_TRUE(input.has_value());
  EXPECT_EQ(input->exit_code(), 2);
  EXPECT_STREQ(input->what(), "f: 1 is not 2");
  const auto run = test::error_of([] { throw_run_error("{} failed", "audit"); });
  ASSERT_TRUE(run.has_value());
  EXPECT_EQ(run->exit_code(), 3);
  EXPECT_STREQ(run->what(), "audit failed");
}

}  // namespace
}  // namespace truescatter
