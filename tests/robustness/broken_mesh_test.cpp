// What `truescatter truth` makes of meshes as they come: a right answer, or a refusal that names the file and
// the element. Never a wrong answer without a word.
#include <algorithm>

#include "cli/truth_fixture.h"
#include "support/sampling.h"
#include "truth/brute.h"

namespace truescatter::test {
namespace {

constexpr double kStdDev = 0.6;
constexpr int kCells = 10;
constexpr int kFaces = 2 * kCells * kCells;

// A square of 10 mm about the origin, in cells of 1 mm; of one irradiance.
Files square() {
  Files files;
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) files.add_vertex({i - 0.5 * kCells, j - 0.5 * kCells, 0.0}, kLight);
  }
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      const int a = j * (kCells + 1) + i;
      files.faces.push_back({a, a + 1, a + kCells + 2});
      files.faces.push_back({a, a + kCells + 2, a + kCells + 1});
    }
  }
  // All over, on edges and at vertices.
  for (int f = 0; f < kFaces; f += 47) {
    files.points.emplace_back(f, Vec3d(0.2, 0.5, 0.3));
    files.points.emplace_back(f + 1, Vec3d(0.0, 0.6, 0.4));
    files.points.emplace_back(f + 2, Vec3d(0.0, 1.0, 0.0));
  }
  return files;
}

// The mass of [x0, x1] x [y0, y1] at z = 0.
double rectangle_mass(const Vec3d& at, double x0, double x1, double y0, double y1) {
  const auto along = [](double a, double b) { return normal_cdf(b / kStdDev) - normal_cdf(a / kStdDev); };
  return along(x0 - at.x(), x1 - at.x()) * along(y0 - at.y(), y1 - at.y()) *
         std::exp(-0.5 * std::pow(at.z() / kStdDev, 2));
}

double square_mass(const Vec3d& at) { return rectangle_mass(at, -5.0, 5.0, -5.0, 5.0); }

class BrokenMesh : public CliTruth {
 protected:
  using Mass = std::function<double(std::size_t point)>;

  // Every engine of the metric gives this mass, and light as kLight has it.
  void expect_right(const Files& files, const std::string& metric, const Mass& mass,
                    double rounding = 1e-11) const {
    write(files);
    std::vector<std::pair<const char*, double>> engines = {
        {"exact", rounding}, {"fast", 1e-4}, {"brute", 1.1e-6}};
    for (const auto& [engine, allowed] : engines) {
      std::map<std::string, std::string> options = {
          {"--sigma", number(kStdDev)}, {"--metric", metric}, {"--engine", engine}};
      if (std::string(engine) == "brute") options["--tolerance"] = "1e-6";
      const std::vector<Row> found = rows(options, false);
      ASSERT_EQ(found.size(), files.points.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_NEAR(found[i].mass, mass(i), allowed) << metric << " " << engine << " point " << i;
        EXPECT_LE((found[i].rgb - mass(i) * kLight).cwiseAbs().maxCoeff(), allowed)
            << metric << " " << engine << " point " << i;
      }
      std::filesystem::remove(folder_.path() / "o.csv");
    }
  }
  void expect_right(const Files& files, const Mass& mass) const {
    for (const char* metric : {"euclidean", "geodesic"}) expect_right(files, metric, mass);
  }
  void expect_refusal(const Files& files, const std::string& metric, const std::string& message) const {
    write(files);
    for (const char* engine : {"exact", "fast", "brute"})
      expect_refused(truth({{"--metric", metric}, {"--engine", engine}}), message);
  }
  static Mass of_square(const Files& files) {
    return [&files](std::size_t i) { return square_mass(files.position(i)); };
  }
  // By quadrature in this process, of all faces but those that `keep` refuses.
  static Mass by_quadrature(const Files& files, const std::function<bool(std::size_t face)>& keep) {
    Surface surface;
    for (std::size_t f = 0; f < files.faces.size(); ++f) {
      if (!keep(f)) continue;
      SurfaceTriangle triangle;
      for (std::size_t c = 0; c < 3; ++c) {
        triangle.corners_mm[c] = files.vertices[static_cast<std::size_t>(files.faces[f][c])];
        triangle.irradiance[c] = kLight;
      }
      surface.triangles.push_back(triangle);
    }
    return [&files, surface](std::size_t i) {
      return BruteEngine(surface, 1e-12).convolve({files.position(i), 0}, {kStdDev})[3];
    };
  }
};

TEST_F(BrokenMesh, AsItShouldBe) {
  const Files files = square();
  expect_right(files, of_square(files));
}

TEST_F(BrokenMesh, TrianglesWithoutArea) {
  const Vec3d middle(0.25, 0.0, 0.0);
  for (const int kind : {0, 1, 2}) {
    Files files = square();
    if (kind == 0) files.faces.push_back({0, 0, 1});  // names a vertex twice
    if (kind == 1) files.faces.push_back({0, 1, 2});  // on one line
    if (kind == 2) {                                  // a position twice
      const int twin = files.add_vertex(files.vertices[50], kLight);
      files.faces.push_back({50, twin, 51});
    }
    files.points.emplace_back(kFaces, Vec3d(0.5, 0.25, 0.25));
    expect_right(files, "euclidean", of_square(files));
    expect_refusal(files, "geodesic", "truescatter: m.obj: triangle 200 at (");
  }
}

// A vertex for each corner of each face, as exporters write them: one surface.
TEST_F(BrokenMesh, EveryVertexManyTimes) {
  const Files joined = square();
  Files files;
  for (const auto& f : joined.faces) {
    std::array<int, 3> face{};
    for (std::size_t c = 0; c < 3; ++c)
      face[c] = files.add_vertex(joined.vertices[static_cast<std::size_t>(f[c])], kLight);
    files.faces.push_back(face);
  }
  files.points = joined.points;
  expect_right(files, of_square(files));
}

// A triangle twice over is no more surface than once.
TEST_F(BrokenMesh, ATriangleTwice) {
  for (const int turned : {0, 1, 2}) {
    Files files = square();
    std::array<int, 3> again = files.faces[77];
    std::rotate(again.begin(), again.begin() + turned, again.end());
    files.faces.push_back(again);
    for (const char* metric : {"euclidean", "geodesic"})
      expect_refusal(files, metric,
                     "truescatter: m.obj: faces 77 and 200 (from 0) are the same triangle, at (");
  }
  // Where one of the two is no skin, it does no harm; paths would run over either.
  Files files = square();
  files.faces.push_back(files.faces[77]);
  write(files);
  std::string mask;
  for (int f = 0; f <= kFaces; ++f) mask += f < kFaces ? "1\n" : "0\n";
  folder_.write("mask.csv", mask);
  const std::vector<Row> found = rows({{"--sigma", number(kStdDev)}, {"--mask", "mask.csv"}});
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i].mass, square_mass(files.position(i)), 1e-11);
  std::filesystem::remove(folder_.path() / "o.csv");
  expect_refused(truth({{"--mask", "mask.csv"}, {"--metric", "geodesic"}}), "truescatter: m.obj: triangles ");
}

// Both sides of a sheet without thickness: twice the light, which is the limit of a thin slab.
TEST_F(BrokenMesh, BothSidesOfASheet) {
  Files files = square();
  for (int f = 0; f < kFaces; ++f) {
    const auto [a, b, c] = files.faces[static_cast<std::size_t>(f)];
    files.faces.push_back({a, c, b});
  }
  expect_right(files, "euclidean", [&](std::size_t i) { return 2.0 * square_mass(files.position(i)); });
  expect_refusal(files, "geodesic", "truescatter: m.obj: triangles 1 and 200 run along one edge");
}

// Light does not cross over, though the other sheet lies within a deviation.
TEST_F(BrokenMesh, SeveralComponents) {
  Files files = square();
  const auto count = static_cast<int>(files.vertices.size());
  for (int v = 0; v < count; ++v)
    files.add_vertex(files.vertices[static_cast<std::size_t>(v)] + Vec3d(0.3, 0.1, 0.4), kLight);
  for (int f = 0; f < kFaces; ++f) {
    const auto [a, b, c] = files.faces[static_cast<std::size_t>(f)];
    files.faces.push_back({a + count, b + count, c + count});
  }
  files.points.emplace_back(kFaces + 100, Vec3d(0.1, 0.1, 0.8));
  expect_right(files, [&](std::size_t i) {
    const bool upper = files.points[i].first >= kFaces;
    return square_mass(files.position(i) - (upper ? Vec3d(0.3, 0.1, 0.4) : Vec3d(0, 0, 0)));
  });
}

// The right half in cells of 2 mm, the left one in cells of 1 mm.
Files halves_that_do_not_fit() {
  Files files;
  const auto add = [&](double x0, double cell, int columns) {
    const int rows = static_cast<int>(10.0 / cell);
    const auto first = static_cast<int>(files.vertices.size());
    for (int j = 0; j <= rows; ++j) {
      for (int i = 0; i <= columns; ++i) files.add_vertex({x0 + cell * i, cell * j - 5.0, 0.0}, kLight);
    }
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        const int a = first + j * (columns + 1) + i;
        files.faces.push_back({a, a + 1, a + columns + 2});
        files.faces.push_back({a, a + columns + 2, a + columns + 1});
      }
    }
  };
  add(-5.0, 1.0, 5);
  add(0.0, 2.0, 2);
  files.points = {{44, kThird}, {48, Vec3d(0, 0.5, 0.5)}, {108, kThird}};
  return files;
}

TEST_F(BrokenMesh, TJunctions) {
  const Files parted = halves_that_do_not_fit();
  expect_refusal(
      parted, "euclidean",
      "(from 0; a T-junction), and nothing else joins the two: whether light passes from one to the "
      "other cannot be told");
  expect_refusal(parted, "euclidean", "truescatter: m.obj: the vertex (0, -4, 0) of face ");
  expect_refusal(parted, "geodesic", "truescatter: m.obj: the vertex (0, -4, 0) of face ");

  // A cell split where the two meet: they share edges there, and light passes as over one surface, on which
  // points of each are in place wherever they lie.
  Files joined = halves_that_do_not_fit();
  std::erase_if(joined.faces, [&](const std::array<int, 3>& f) {
    double x = 0.0;
    double y = 0.0;
    for (const int v : f) {
      x += joined.vertices[static_cast<std::size_t>(v)].x() / 3.0;
      y += joined.vertices[static_cast<std::size_t>(v)].y() / 3.0;
    }
    return x > 0.0 && x < 2.0 && y > -5.0 && y < -3.0;
  });
  const int lower = joined.add_vertex({0, -5, 0}, kLight);
  const int middle = joined.add_vertex({0, -4, 0}, kLight);
  const int upper = joined.add_vertex({0, -3, 0}, kLight);
  const int lower_right = joined.add_vertex({2, -5, 0}, kLight);
  const int upper_right = joined.add_vertex({2, -3, 0}, kLight);
  joined.faces.insert(
      joined.faces.end(),
      {{lower, lower_right, middle}, {middle, lower_right, upper_right}, {middle, upper_right, upper}});
  joined.points = {{44, kThird}, {48, Vec3d(0, 0.5, 0.5)}, {108, kThird}};
  expect_right(joined, "euclidean",
               [&](std::size_t i) { return rectangle_mass(joined.position(i), -5.0, 4.0, -5.0, 5.0); });
  expect_refusal(joined, "geodesic", "truescatter: m.obj: the vertex (0, ");
}

// A fin on an edge inside: its light arrives, too.
TEST_F(BrokenMesh, AnEdgeOfThreeTriangles) {
  Files files = square();
  const int tip = files.add_vertex({0.3, 0.4, 0.9}, kLight);
  files.faces.push_back({60, 61, tip});
  files.points.emplace_back(kFaces, Vec3d(0.3, 0.3, 0.4));
  expect_right(files, "euclidean", by_quadrature(files, [](std::size_t) { return true; }));
  expect_refusal(files, "geodesic", "truescatter: m.obj: triangles ");
  expect_refusal(files, "geodesic",
                 " and 200 run along one edge in the same direction: an edge of three triangles");
}

TEST_F(BrokenMesh, OppositeWinding) {
  Files files = square();
  for (std::size_t f = 40; f < 60; ++f) std::swap(files.faces[f][1], files.faces[f][2]);
  expect_right(files, "euclidean", of_square(files));
  expect_refusal(files, "geodesic", "truescatter: m.obj: triangles ");
  // All of it the other way round is as good as before.
  files = square();
  for (auto& f : files.faces) std::swap(f[1], f[2]);
  expect_right(files, of_square(files));
}

// Two triangles with one vertex in common share no edge: no light crosses.
TEST_F(BrokenMesh, SheetsThatTouchAtAVertex) {
  Files files;
  const int o = files.add_vertex({0, 0, 0}, kLight);
  const int a = files.add_vertex({1, 0.2, 0}, kLight);
  const int b = files.add_vertex({0.3, 1, 0}, kLight);
  const int c = files.add_vertex({-1, -0.2, 0}, kLight);
  const int d = files.add_vertex({-0.1, -1, 0.5}, kLight);
  files.faces = {{o, a, b}, {o, c, d}};
  files.points = {{0, kThird}, {0, Vec3d(1, 0, 0)}, {1, kThird}};
  Files first = files;
  first.points.resize(2);
  expect_right(first, "euclidean", by_quadrature(first, [](std::size_t f) { return f == 0; }));
  expect_refusal(files, "geodesic", "truescatter: m.obj: at the vertex (0, 0, 0) two sheets touch");
}

// Needles: vertices put into edges and faces of the square, a fraction `height` of an edge away from others.
// The plane stays what it was, for both metrics.
TEST_F(BrokenMesh, NeedlesChangeNothing) {
  for (const double height : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 3e-12}) {
    Files files = square();
    // Face 88 is cut at a point that close to its first edge, face 92 at one that close to a corner; the edge
    // between faces 110 and 111 at one that close to its end.
    const auto cut = [&](std::size_t face, const Vec3d& b) {
      const auto [p, q, r] = files.faces[face];
      Vec3d at = Vec3d::Zero();
      for (std::size_t c = 0; c < 3; ++c)
        at +=
            b[static_cast<Eigen::Index>(c)] * files.vertices[static_cast<std::size_t>(files.faces[face][c])];
      const int x = files.add_vertex(at, kLight);
      files.faces[face] = {p, q, x};
      files.faces.push_back({q, r, x});
      files.faces.push_back({r, p, x});
    };
    cut(88, Vec3d(0.4 - height, 0.6, height));
    cut(92, Vec3d(1.0 - 3.0 * height, height, 2.0 * height));
    const int a = files.faces[110][0];
    const int b = files.faces[110][2];  // the diagonal a to b
    const Vec3d at =
        files.vertices[static_cast<std::size_t>(a)] +
        height * (files.vertices[static_cast<std::size_t>(b)] - files.vertices[static_cast<std::size_t>(a)]);
    const int x = files.add_vertex(at, kLight);
    const int low = files.faces[110][1];
    const int high = files.faces[111][2];
    files.faces[110] = {a, low, x};
    files.faces[111] = {a, x, high};
    files.faces.push_back({low, b, x});
    files.faces.push_back({x, b, high});
    for (const int f : {88, 92, 110, 111, 200, 203, 205}) {
      files.points.emplace_back(f, kThird);
      files.points.emplace_back(f, Vec3d(0.0, 0.3, 0.7));
      files.points.emplace_back(f, Vec3d(0.0, 0.0, 1.0));
    }
    SCOPED_TRACE(height);
    expect_right(files, "euclidean", of_square(files));
    // From a vertex that lies 3 heights from another, the direction to that one is off by the rounding of
    // positions in the face over so short a way, some 1e-16 / 3 height; a wedge as wide may be lost, or taken
    // twice, at either end: its share of 2 pi.
    expect_right(files, "geodesic", of_square(files), 1e-11 + 2e-17 / height);
  }
}

}  // namespace
}  // namespace truescatter::test
