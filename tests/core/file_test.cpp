#include "core/file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using test::TempDir;

TEST(WriteTextFile, WritesEveryByteAndLeavesNothingElse) {
  const TempDir folder;
  const std::string text("a\r\n\0b\xff\n", 7);
  write_text_file(folder.path() / "a.txt", text);
  EXPECT_EQ(read_text_file(folder.path() / "a.txt"), text);
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.txt"});
}

// Whoever holds the old file open still reads all of the old text: the new one is a new file under its name.
TEST(WriteTextFile, ReplacesByARename) {
  const TempDir folder;
  const fs::path path = folder.write("a.txt", "old text");
  std::ifstream reader(path, std::ios::binary);
  write_text_file(path, "new");
  std::ostringstream held;
  held << reader.rdbuf();
  EXPECT_EQ(held.str(), "old text");
  EXPECT_EQ(read_text_file(path), "new");
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.txt"});
}

TEST(WriteTextFile, FailsInAFolderThatIsNotThere) {
  const TempDir folder;
  const fs::path path = folder.path() / "none" / "a.txt";
  const auto error = error_of([&] { write_text_file(path, "x"); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind(), ErrorKind::run);
  EXPECT_NE(std::string(error->what()).find(path.string()), std::string::npos) << error->what();
  EXPECT_TRUE(folder.names().empty());
}

// The rename fails where a folder has the name; the temporary must not stay behind.
TEST(WriteTextFile, FailsOverAFolderAndLeavesNoTemporary) {
  const TempDir folder;
  const fs::path path = folder.path() / "taken";
  fs::create_directories(path / "inside");
  const auto error = error_of([&] { write_text_file(path, "x"); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind(), ErrorKind::run);
  EXPECT_NE(std::string(error->what()).find(path.string()), std::string::npos) << error->what();
  EXPECT_EQ(folder.names(), std::vector<std::string>{"taken"});
}

TEST(TemporarySibling, LiesBesideItsFileAndKeepsTheExtension) {
  const fs::path temporary = temporary_sibling("folder/a.exr");
  EXPECT_EQ(temporary.parent_path(), "folder");
  EXPECT_EQ(temporary.extension(), ".exr");  // writers choose the format by it
  EXPECT_NE(temporary.filename(), "a.exr");
}

TEST(TemporarySibling, IsKnownByItsName) {
  for (const char* name : {"a.exr", "results.json", "front.skin.truth.exr", "noextension"}) {
    EXPECT_TRUE(is_temporary_name(temporary_sibling(name).string())) << temporary_sibling(name);
    EXPECT_FALSE(is_temporary_name(name));
  }
  for (const char* name : {".part", ".parts", ".a.part", ".12.part", ".a12.part", "a.12.part"})
    EXPECT_FALSE(is_temporary_name(name)) << name;
}

using Exchange = void (*)(const fs::path&, const fs::path&, const fs::path&);

class ExchangeNames : public testing::TestWithParam<Exchange> {};

INSTANTIATE_TEST_SUITE_P(BothWays, ExchangeNames, testing::Values(&exchange_names, &exchange_names_in_steps));

TEST_P(ExchangeNames, SwapsFoldersThatHoldFiles) {
  const TempDir folder;
  fs::create_directory(folder.path() / "a");
  fs::create_directory(folder.path() / "b");
  folder.write("a/file", "of a");
  folder.write("b/file", "of b");
  GetParam()(folder.path() / "a", folder.path() / "b", folder.path() / "spare");
  EXPECT_EQ(read_text_file(folder.path() / "a/file"), "of b");
  EXPECT_EQ(read_text_file(folder.path() / "b/file"), "of a");
  EXPECT_EQ(folder.names().size(), 2U);
}

// `a` is not there: `b` has its name again.
TEST_P(ExchangeNames, AFailureChangesNothing) {
  const TempDir folder;
  fs::create_directory(folder.path() / "b");
  folder.write("b/file", "of b");
  const auto error =
      error_of([&] { GetParam()(folder.path() / "a", folder.path() / "b", folder.path() / "spare"); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind(), ErrorKind::run);
  EXPECT_NE(std::string(error->what()).find((folder.path() / "b").string()), std::string::npos);
  EXPECT_EQ(folder.names(), std::vector<std::string>{"b"});
  EXPECT_EQ(read_text_file(folder.path() / "b/file"), "of b");
}

TEST(ReadTextFile, SaysWhichFileAndWhy) {
  const TempDir folder;
  const auto missing = error_of([&] { read_text_file(folder.path() / "none.txt"); });
  ASSERT_TRUE(missing.has_value());
  EXPECT_EQ(missing->kind(), ErrorKind::input);
  EXPECT_EQ(missing->what(), (folder.path() / "none.txt").string() + ": no such file");
  const auto a_folder = error_of([&] { read_text_file(folder.path()); });
  ASSERT_TRUE(a_folder.has_value());
  EXPECT_EQ(a_folder->what(), folder.path().string() + ": is a folder; a file is needed");
}

TEST(ExpandEnvironment, ReplacesEveryVariable) {
  setenv("TRUESCATTER_TEST_A", "one", 1);
  setenv("TRUESCATTER_TEST_B", "${TRUESCATTER_TEST_A}", 1);
  setenv("TRUESCATTER_TEST_EMPTY", "", 1);
  EXPECT_EQ(expand_environment("no variable: $A {B} }"), "no variable: $A {B} }");
  EXPECT_EQ(expand_environment(""), "");
  EXPECT_EQ(expand_environment("${TRUESCATTER_TEST_A}"), "one");
  EXPECT_EQ(expand_environment("<${TRUESCATTER_TEST_A}/${TRUESCATTER_TEST_A}>"), "<one/one>");
  EXPECT_EQ(expand_environment("a${TRUESCATTER_TEST_EMPTY}b"), "ab");
  // A value is not expanded again.
  EXPECT_EQ(expand_environment("${TRUESCATTER_TEST_B}"), "${TRUESCATTER_TEST_A}");
}

TEST(ExpandEnvironment, RefusesWhatItCannotExpand) {
  unsetenv("TRUESCATTER_TEST_UNSET");
  const auto unset = error_of([] { expand_environment("a/${TRUESCATTER_TEST_UNSET}/b"); });
  ASSERT_TRUE(unset.has_value());
  EXPECT_EQ(unset->kind(), ErrorKind::input);
  EXPECT_STREQ(unset->what(),
               "'a/${TRUESCATTER_TEST_UNSET}/b': the environment variable TRUESCATTER_TEST_UNSET is not set");
  const auto open = error_of([] { expand_environment("a/${NAME"); });
  ASSERT_TRUE(open.has_value());
  EXPECT_STREQ(open->what(), "'a/${NAME': '${' without a closing '}'");
}

}  // namespace
}  // namespace truescatter
