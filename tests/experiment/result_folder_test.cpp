#include "experiment/result_folder.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <optional>

#include "core/file.h"
#include "experiment/pieces.h"
#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using test::TempDir;

constexpr const char* kResults = "{\"schema\": \"truescatter-results-1\"}";
// Of a process that cannot be: above Linux' largest process id.
constexpr const char* kLeft = ".out.4194305.part";

class ResultFolderTest : public testing::Test {
 protected:
  fs::path out() const { return folder_.path() / "out"; }
  // A folder with what a run writes.
  void write_result(const std::string& name, const std::string& results = kResults) const {
    fs::create_directories(folder_.path() / name / "maps");
    folder_.write(name + "/results.json", results);
    folder_.write(name + "/results.csv", "view\n");
    folder_.write(name + "/experiment.resolved.toml", "");
    folder_.write(name + "/report.html", name);
    folder_.write(name + "/maps/front.skin.truth.exr", "old");
  }
  std::string text(const std::string& name) const { return read_text_file(folder_.path() / name); }
  std::string refusal() const {
    const auto error = error_of([&] { const ResultFolder refused(out()); });
    if (!error) return "accepted";
    EXPECT_EQ(error->kind(), ErrorKind::input);
    return error->what();
  }

  TempDir folder_;
};

TEST_F(ResultFolderTest, AppearsOnlyWhenPublished) {
  {
    ResultFolder results(out());
    write_text_file(results.working() / "results.json", kResults);
    EXPECT_FALSE(fs::exists(out()));
    EXPECT_EQ(results.working().parent_path(), folder_.path());
    results.publish();
    EXPECT_TRUE(fs::exists(out()));
  }
  EXPECT_EQ(text("out/results.json"), kResults);
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"out"});
}

TEST_F(ResultFolderTest, WithoutPublishingTheEarlierResultStays) {
  write_result("out");
  {
    const ResultFolder results(out());
    write_text_file(results.working() / "report.html", "new");
  }
  EXPECT_EQ(text("out/report.html"), "out");
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"out"});
}

TEST_F(ResultFolderTest, MakesParentsAndTakesThemBack) {
  {
    const ResultFolder results(folder_.path() / "a/b/out");
    EXPECT_TRUE(fs::exists(folder_.path() / "a/b"));
  }
  EXPECT_TRUE(folder_.names().empty());
  ResultFolder results(folder_.path() / "a/b/out");
  results.publish();
  EXPECT_TRUE(fs::exists(folder_.path() / "a/b/out"));
}

TEST_F(ResultFolderTest, ReplacesAnEmptyFolderAndAnEarlierResultOfAnyVersion) {
  fs::create_directory(out());
  ResultFolder(out()).publish();
  fs::remove(out());
  write_result("out", "{\"schema\": \"truescatter-results-99\"}");
  ResultFolder(out()).publish();
  EXPECT_TRUE(fs::is_empty(out()));
}

// The folder stays in its place behind the link.
TEST_F(ResultFolderTest, FollowsALink) {
  fs::create_directory(folder_.path() / "elsewhere");
  write_result("elsewhere/real");
  fs::create_directory_symlink("elsewhere/real", out());
  ResultFolder results(out());
  write_text_file(results.working() / "report.html", "new");
  results.publish();
  EXPECT_TRUE(fs::is_symlink(out()));
  EXPECT_EQ(text("elsewhere/real/report.html"), "new");
}

TEST_F(ResultFolderTest, ASlashAtTheEndIsNoOtherFolder) {
  write_result("out");
  ResultFolder results(fs::path(out().string() + "/"));
  results.publish();
  EXPECT_TRUE(fs::is_empty(out()));
}

TEST_F(ResultFolderTest, RefusesWhatItMayNotReplace) {
  const auto with_entry = [&](const std::string& name) {
    write_result("out");
    folder_.write("out/" + name, "precious");
    const std::string refused = refusal();
    EXPECT_EQ(text("out/" + name), "precious");
    fs::remove_all(out());
    return refused;
  };
  EXPECT_NE(with_entry("notes.txt").find("holds 'notes.txt'"), std::string::npos);
  EXPECT_NE(with_entry(".hidden").find("holds '.hidden'"), std::string::npos);
  EXPECT_NE(with_entry("maps/notes.txt").find("holds 'maps/notes.txt'"), std::string::npos);
  EXPECT_EQ(with_entry(".results.12.part.json"), "accepted");  // what a killed `report` leaves

  write_result("out");
  fs::create_directory(out() / "mine");
  EXPECT_NE(refusal().find("holds 'mine'"), std::string::npos);
  fs::remove(out() / "mine");
  fs::create_directory_symlink("/", out() / "maps" / "a.png");
  EXPECT_NE(refusal().find("holds 'maps/a.png'"), std::string::npos);
  fs::remove_all(out());

  // Right names, but nothing says that they are ours.
  for (const char* text : {"", "[1]", "{\"schema\": 1}", "{\"schema\": \"other-1\"}"}) {
    write_result("out", text);
    EXPECT_NE(refusal().find("no results.json says that truescatter has written it"), std::string::npos)
        << text;
  }
  fs::remove_all(out());

  fs::create_directory_symlink("nowhere", out());
  EXPECT_NE(refusal().find("is a link that leads nowhere"), std::string::npos);
}

TEST_F(ResultFolderTest, LeftoversOfKilledRunsAreRemoved) {
  write_result("out");
  write_result(kLeft);
  { const ResultFolder results(out()); }
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"out"});
}

// A run that was killed between the renames: the earlier result is the only one.
TEST_F(ResultFolderTest, ACompleteLeftoverIsPutInItsPlace) {
  write_result(".out.4194305.old");
  { const ResultFolder results(out()); }
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"out"});
  EXPECT_EQ(text("out/report.html"), ".out.4194305.old");
}

TEST_F(ResultFolderTest, LeftoversThatAreNotOursStay) {
  fs::create_directory(folder_.path() / kLeft);
  folder_.write(std::string(kLeft) + "/notes.txt", "precious");
  for (const char* name : {".out.x.part", ".out.4194305.party", ".outer.4194305.part", "out.4194305.part"}) {
    fs::create_directory(folder_.path() / name);
  }
  { const ResultFolder results(out()); }
  EXPECT_EQ(folder_.names().size(), 5U);
}

// A lock belongs to an open file, so another one of this process stands for another process.
TEST_F(ResultFolderTest, ARunThatIsGoingOnIsLeftAlone) {
  write_result("out");
  fs::create_directory(folder_.path() / kLeft);
  const int held = open((folder_.path() / kLeft / ".lock").c_str(), O_RDWR | O_CREAT, 0666);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  { const ResultFolder results(out()); }
  EXPECT_TRUE(fs::exists(folder_.path() / kLeft));
  close(held);
  { const ResultFolder results(out()); }
  EXPECT_FALSE(fs::exists(folder_.path() / kLeft));
}

TEST_F(ResultFolderTest, LocksItsOwnFolder) {
  ResultFolder results(out());
  const int other = open((results.working() / ".lock").c_str(), O_RDWR);
  ASSERT_GE(other, 0);
  EXPECT_NE(flock(other, LOCK_EX | LOCK_NB), 0);
  close(other);
  results.publish();
  EXPECT_FALSE(fs::exists(folder_.path() / "out/.lock"));
}

// Somebody saved a file there while the run went on.
TEST_F(ResultFolderTest, KeepsWhatWasPutThereDuringTheRun) {
  write_result("out");
  {
    ResultFolder results(out());
    write_text_file(results.working() / "report.html", "new");
    folder_.write("out/notes.txt", "precious");
    results.publish();
  }
  EXPECT_EQ(text("out/report.html"), "new");
  EXPECT_EQ(text("out.kept." + std::to_string(getpid()) + "/notes.txt"), "precious");
}

// The parent went away: the results have nowhere to go.
TEST_F(ResultFolderTest, AFailureToPublishIsARunError) {
  const fs::path parent = folder_.path() / "parent";
  fs::create_directory(parent);
  std::optional<ResultFolder> results;
  results.emplace(parent / "out");
  fs::rename(parent, folder_.path() / "moved");
  const auto error = error_of([&] { results->publish(); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind(), ErrorKind::run);
}

// What --resume goes on from: the folder whose pieces are the latest.
class ResumedFolderTest : public ResultFolderTest {
 protected:
  void write_left(const std::string& name, const std::string& piece) const {
    fs::create_directories(folder_.path() / name / "maps");
    const PieceStore pieces(folder_.path() / name);
    pieces.set_key({{"commit", "1"}});
    pieces.keep({Piece::Kind::view, piece}, {{"name", piece}});
  }
};

TEST_F(ResumedFolderTest, TakesOverWhatIsLeftAndPublishesIt) {
  write_left(kLeft, "front");
  folder_.write(std::string(kLeft) + "/maps/.a.4194305.part.exr", "half a picture");
  {
    ResultFolder results(out(), true);
    EXPECT_TRUE(PieceStore(results.working()).has({Piece::Kind::view, "front"}));
    EXPECT_TRUE(fs::is_empty(results.working() / "maps"));
    results.publish();
  }
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"out"});
  EXPECT_FALSE(fs::exists(out() / "pieces"));
}

// The parent was away when the results were to go there, and is back: nothing is lost.
TEST_F(ResumedFolderTest, GoesOnFromWhatCouldNotBePublished) {
  const fs::path parent = folder_.path() / "parent";
  const fs::path away = folder_.path() / "away";
  write_left(fs::path("parent") / kLeft, "front");
  {
    ResultFolder results(parent / "out", true);
    folder_.write(results.working().lexically_relative(folder_.path()) / "results.json", kResults);
    fs::rename(parent, away);
    EXPECT_TRUE(error_of([&] { results.publish(); }).has_value());
  }
  fs::rename(away, parent);
  ResultFolder again(parent / "out", true);
  EXPECT_TRUE(PieceStore(again.working()).has({Piece::Kind::view, "front"}));
  again.publish();
  EXPECT_EQ(text("parent/out/results.json"), kResults);
  EXPECT_FALSE(fs::exists(parent / "out/pieces"));
}

TEST_F(ResumedFolderTest, WithoutPublishingItStays) {
  write_left(kLeft, "front");
  { const ResultFolder results(out(), true); }
  ASSERT_EQ(folder_.names().size(), 1U);
  EXPECT_TRUE(has_pieces(folder_.path() / folder_.names().front()));
}

TEST_F(ResumedFolderTest, WithoutResumeItStaysUntilAnotherIsPublished) {
  write_left(kLeft, "front");
  {
    const ResultFolder results(out());
    EXPECT_FALSE(has_pieces(results.working()));
  }
  EXPECT_EQ(folder_.names(), std::vector<std::string>{kLeft});
  ResultFolder results(out());
  results.publish();
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"out"});
}

TEST_F(ResumedFolderTest, OfSeveralTheLatest) {
  write_left(kLeft, "older");
  fs::last_write_time(folder_.path() / kLeft / "pieces",
                      fs::file_time_type::clock::now() - std::chrono::hours(1));
  write_left(".out.4194306.part", "newer");
  ResultFolder results(out(), true);
  EXPECT_TRUE(PieceStore(results.working()).has({Piece::Kind::view, "newer"}));
  results.publish();
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"out"});
}

TEST_F(ResumedFolderTest, NotWhatAnotherProcessWorksIn) {
  write_left(kLeft, "front");
  const int held = open((folder_.path() / kLeft / ".lock").c_str(), O_RDWR | O_CREAT, 0666);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  {
    ResultFolder results(out(), true);
    EXPECT_FALSE(has_pieces(results.working()));
    results.publish();
  }
  EXPECT_TRUE(has_pieces(folder_.path() / kLeft));
  close(held);
}

}  // namespace
}  // namespace truescatter
