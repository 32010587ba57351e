#include "experiment/pieces.h"

#include <gtest/gtest.h>

#include <set>

#include "core/file.h"
#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

using nlohmann::json;
using test::error_of;
using test::TempDir;

const Piece kRun{Piece::Kind::run, "front", "skin", "pscbf"};

TEST(Piece, HasANameThatSaysWhatItIs) {
  EXPECT_EQ(kRun.id(), "run.front.skin.pscbf");
  EXPECT_EQ(kRun.stem(), "front.skin.pscbf");
  EXPECT_EQ((Piece{Piece::Kind::view, "front"}.id()), "view.front");
  EXPECT_EQ((Piece{Piece::Kind::truth, "front", "skin"}.stem()), "front.skin.truth");
  EXPECT_EQ((Piece{Piece::Kind::ladder, "front", "skin", "filter"}.stem()), "front.skin.ladder-filter");
  EXPECT_EQ((Piece{Piece::Kind::stability, "front"}.id()), "stability.front");
}

// Two views, two profiles, two methods, one ladder, stability of one view: 2 (1 + 2 (1 + 2 + 1)) + 1 + 1.
TEST(Piece, AnExperimentHasEveryOneOnce) {
  const TempDir folder;
  const ExperimentSpec spec = read_experiment(folder.write("e.toml", R"(
[scene]
mesh = "builtin:plane"
[[light]]
direction = [0.0, 0.0, 1.0]
[[view]]
name = "a"
eye_mm = [0.0, 0.0, 100.0]
[[view]]
name = "b"
eye_mm = [0.0, 0.0, 200.0]
[[profile]]
name = "spike-and-base"
[[profile]]
name = "skin-six-gaussian"
[[method]]
name = "none"
[[method]]
name = "pscbf"
[[ladder]]
name = "filter"
[[ladder.rung]]
truth = "whole"
assumption = "none"
[[ladder.rung]]
method = "pscbf"
assumption = "the filter"
[stability]
view = "b"
jitter = {views = 2}
)"));
  const Plan plan = make_plan(spec);
  std::set<std::string> ids;
  for (const Piece& piece : pieces_of(spec, plan)) ids.insert(piece.id());
  EXPECT_EQ(ids.size(), 20U);
  EXPECT_EQ(pieces_of(spec, plan).size(), 20U);
  EXPECT_EQ(ids.count("stability.b"), 1U);
  EXPECT_EQ(ids.count("stability.a"), 0U);
  EXPECT_EQ(ids.count("widths.a"), 1U);
}

TEST(PieceStore, KeepsAPieceToTheLastDigit) {
  const TempDir folder;
  const PieceStore pieces(folder.path());
  EXPECT_FALSE(pieces.has(kRun));
  const json run = {
      {"rmse", 0.1 + 0.2}, {"tiny", 5e-324}, {"points", 18446744073709551615U}, {"none", nullptr}};
  pieces.keep(kRun, run);
  EXPECT_TRUE(pieces.has(kRun));
  EXPECT_EQ(pieces.read(kRun).dump(), run.dump());
}

TEST(PieceStore, NamesADamagedPiece) {
  const TempDir folder;
  const PieceStore pieces(folder.path());
  write_text_file(folder.path() / "pieces" / "run.front.skin.pscbf.json", "{\"rmse\": 0.1");
  const auto error = error_of([&] { pieces.read(kRun); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::run);
  EXPECT_NE(std::string(error->what()).find("run.front.skin.pscbf.json: "), std::string::npos);
}

TEST(PieceStore, BelongsToItsKeyUntilItIsRemoved) {
  const TempDir folder;
  const PieceStore pieces(folder.path());
  EXPECT_FALSE(pieces.key());
  EXPECT_FALSE(has_pieces(folder.path()));
  pieces.set_key({{"commit", "1"}});
  pieces.keep(kRun, {{"rmse", 1.0}});
  EXPECT_TRUE(has_pieces(folder.path()));
  EXPECT_EQ(PieceStore(folder.path()).key(), json({{"commit", "1"}}));
  pieces.clear();
  EXPECT_FALSE(pieces.has(kRun));
  EXPECT_FALSE(pieces.key());
  remove_pieces(folder.path());
  EXPECT_EQ(folder.names(), std::vector<std::string>{"maps"});
}

}  // namespace
}  // namespace truescatter
