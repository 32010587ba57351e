#include "experiment/truth_files.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

// A square of two triangles, all skin, and a point at its first vertex.
class TruthFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("m.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    folder_.write("i.csv", kLight);
    folder_.write("p.csv", "face,b0,b1,b2\n0,1,0,0\n");
    folder_.write("mask.csv", "1\n1\n");
  }
  TruthProblem read() const {
    const auto path = [&](const char* name) { return folder_.path() / name; };
    return read_truth_problem({path("m.obj"), path("i.csv"), path("p.csv"), path("mask.csv")});
  }
  // The message, without the folder's name.
  std::string refusal() const {
    const auto error = test::error_of([&] { read(); });
    if (!error) return "no error";
    EXPECT_EQ(error->kind(), ErrorKind::input);
    std::string message = error->what();
    const std::string folder = folder_.path().string() + "/";
    for (std::size_t at = 0; (at = message.find(folder, at)) != std::string::npos;)
      message.erase(at, folder.size());
    return message;
  }

  const std::string kLight = "r,g,b\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n";
  test::TempDir folder_;
};

// Triangles keep their corners' order, and points their places, whatever the mask takes away.
TEST_F(TruthFilesTest, KeepsFileOrder) {
  folder_.write("m.obj", "f 3 1 2\nf 4 1 3\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\n");
  folder_.write("i.csv", "r,g,b\n1,0,0\n2,0,0\n3,0,0\n4,0,0\n5,0,0\n");
  folder_.write("p.csv", "face,b0,b1,b2\n1,0.5,0.25,0.25\n1,1,0,0\n");
  folder_.write("mask.csv", "0\n1\n");
  const TruthProblem problem = read();
  ASSERT_EQ(problem.surface.triangles.size(), 1U);
  EXPECT_EQ(problem.mesh_triangle, (std::vector<std::size_t>{1}));
  EXPECT_EQ(problem.skin, (std::vector<bool>{false, true}));
  const SurfaceTriangle& triangle = problem.surface.triangles[0];
  EXPECT_EQ(triangle.corners_mm[0], Vec3d(0, 1, 0));
  EXPECT_EQ(triangle.irradiance[0], Vec3d(4, 0, 0));
  EXPECT_EQ(triangle.irradiance[1], Vec3d(1, 0, 0));
  EXPECT_EQ(triangle.irradiance[2], Vec3d(3, 0, 0));
  ASSERT_EQ(problem.points.size(), 2U);
  EXPECT_EQ(problem.places[0].triangle, 1U);
  EXPECT_EQ(problem.points[0].position_mm, Vec3d(0.25, 0.75, 0));
  EXPECT_EQ(problem.points[1].position_mm, Vec3d(0, 1, 0));
  EXPECT_EQ(problem.points[0].component, triangle.component);
}

// Two triangles that only touch in a vertex are two components; a shared edge, of other vertices too, joins.
TEST_F(TruthFilesTest, SharedEdgesConnect) {
  folder_.write("m.obj",
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
                "f 1 2 3\nf 1 4 5\nf 6 8 7\n");
  folder_.write("i.csv", "r,g,b\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n1,1,1\n");
  folder_.write("mask.csv", "skin\n1\n1\n1\n");
  const std::vector<SurfaceTriangle>& triangles = read().surface.triangles;
  ASSERT_EQ(triangles.size(), 3U);
  EXPECT_EQ(triangles[0].component, triangles[2].component);
  EXPECT_NE(triangles[0].component, triangles[1].component);
}

TEST_F(TruthFilesTest, RoundedBarycentricsAreSetRight) {
  folder_.write("p.csv", "face,b0,b1,b2\n0,-5e-10,0.5,0.5\n0,0.3333333333,0.3333333333,0.3333333333\n");
  const TruthProblem problem = read();
  EXPECT_EQ(problem.places[0].barycentric, Vec3d(0, 0.5, 0.5));
  for (const MeshPoint& place : problem.places) EXPECT_NEAR(place.barycentric.sum(), 1.0, 1e-15);
}

struct BrokenFile {
  std::string file;
  std::string content;
  std::string message;
};

TEST_F(TruthFilesTest, RefusesWhatIsBroken) {
  const std::vector<BrokenFile> table = {
      {"m.obj", "v 0 0 0\n", "m.obj: the file has no triangle"},
      {"m.obj", "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "m.obj:3: \"nan\" is not finite"},
      {"m.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 2 3 4\n",
       "m.obj: face 1 (from 0) has more than 3 corners: triangles are needed"},
      {"m.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 5\n", "m.obj:5: 5 is out of range"},
      {"i.csv", "", "i.csv:1: \"\" where the header \"r,g,b\" is needed"},
      {"i.csv", "r,g\n1,1\n", "i.csv:1: \"r,g\" where the header \"r,g,b\" is needed"},
      {"i.csv", "1,1,1\n1,1,1\n1,1,1\n1,1,1\n", "i.csv:1: \"1,1,1\" where the header \"r,g,b\" is needed"},
      {"i.csv", "r,g,b\n1,1,1\n1,1,1\n1,1,1\n",
       "i.csv: has 3 rows: m.obj has 4 vertices, and one row for each is needed"},
      {"i.csv", kLight + "1,1,1\n", "i.csv:6: this is row 5: m.obj has 4 vertices, and one row for each"},
      {"i.csv", "r,g,b\n1,1,1\n1,nan,1\n1,1,1\n1,1,1\n",
       "i.csv:3:3: \"nan\" is not finite: g must be a finite number"},
      {"i.csv", "r,g,b\n1,1,1\n1,1,1e999\n1,1,1\n1,1,1\n",
       "i.csv:3:5: \"1e999\" is not finite: b must be a finite number"},
      {"i.csv", "r,g,b\n1,1,1\n1,1,1\n1,one,1\n1,1,1\n", "i.csv:4:3: \"one\" is not a number: g must be"},
      {"i.csv", "r,g,b\n1,1,1\n1,,1\n1,1,1\n1,1,1\n", "i.csv:3:3: \"\" is not a number: g must be"},
      {"i.csv", "r,g,b\n1,1,1\n\n1,1,1\n1,1,1\n", "i.csv:3: the line is empty, and rows follow"},
      {"i.csv", "r,g,b\n1,1,1\n1,1\n1,1,1\n1,1,1\n", "i.csv:3: \"1,1\" has 2 values, and needs 3: r,g,b"},
      {"p.csv", "face,b0,b1\n0,1,0\n",
       "p.csv:1: \"face,b0,b1\" where the header \"face,b0,b1,b2\" is needed"},
      {"p.csv", "face,b0,b1,b2\n0,1,0,0\n2,1,0,0\n",
       "p.csv:3:1: face 2 is out of range: m.obj has faces 0 to 1"},
      {"p.csv", "face,b0,b1,b2\n-1,1,0,0\n", "p.csv:2:1: face -1 is out of range"},
      {"p.csv", "face,b0,b1,b2\n0.5,1,0,0\n", "p.csv:2:1: \"0.5\" is not a whole number that face can be"},
      {"p.csv", "face,b0,b1,b2\n0,0.5,0.5,0.5\n", "p.csv:2:3: b0, b1, b2 sum to 1.5: they must sum to 1"},
      {"p.csv", "face,b0,b1,b2\n0,1.5,0,-0.5\n", "p.csv:2:3: b0 is 1.5: it must be 0 to 1"},
      {"p.csv", "face,b0,b1,b2\n0,1,1e-8,-1e-8\n", "p.csv:2:10: b2 is -1e-08: it must be 0 to 1"},
      {"p.csv", "face,b0,b1,b2\n0,1,0,inf\n", "p.csv:2:7: \"inf\" is not finite: b2 must be a finite number"},
      {"mask.csv", "1\n2\n", "mask.csv:2:1: 2 where 0 or 1 (skin) is needed"},
      {"mask.csv", "1\n", "mask.csv: has 1 rows: m.obj has 2 triangles, and one row for each is needed"},
      {"mask.csv", "1\n1\n1\n", "mask.csv:3: this is row 3: m.obj has 2 triangles"},
      {"mask.csv", "mask\n1\n1\n", "mask.csv:1:1: \"mask\" is not a whole number that skin can be"},
  };
  for (const BrokenFile& broken : table) {
    SetUp();
    ASSERT_EQ(refusal(), "no error");
    folder_.write(broken.file, broken.content);
    EXPECT_EQ(refusal().substr(0, broken.message.size()), broken.message);
  }
}

}  // namespace
}  // namespace truescatter
