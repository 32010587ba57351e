#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "cli/truth_fixture.h"

namespace truescatter::test {
namespace {

// A half of the plane, to 20 mm.
Files half_plane() {
  Files files;
  files.add_square(-20, 0, -20, 20, kLight);
  return files;
}

// Square cells of 1 mm, and a light that is linear: 1 + x/10, 1 - y/20, 1/4.
Files grid(int cells) {
  Files files;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const Vec3d at(i - 0.5 * cells, j - 0.5 * cells, 0);
      files.add_vertex(at, {1 + 0.1 * at.x(), 1 - 0.05 * at.y(), 0.25});
    }
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i;
      files.faces.push_back({a, a + 1, a + cells + 2});
      files.faces.push_back({a, a + cells + 2, a + cells + 1});
    }
  }
  return files;
}

constexpr double kRounding = 1e-11;

// A rectangle's mass is a product of differences of the normal distribution's integral.
TEST_F(CliTruth, ARectangleIsAProductOfErrorFunctions) {
  Files files = half_plane();
  files.points = {
      {0, Vec3d(0.2, 0.3, 0.5)}, {1, kThird}, {0, Vec3d(0.01, 0.49, 0.5)}, {0, Vec3d(0, 0.5, 0.5)}};
  write(files);
  const std::vector<double> sigmas = {1.0, 0.3};
  const std::vector<Row> found = rows({{"--sigma", "1,0.3"}});
  ASSERT_EQ(found.size(), 8U);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].point, static_cast<int>(i / 2));
    EXPECT_EQ(found[i].sigma, sigmas[i % 2]);
    const Vec3d at = files.position(i / 2);
    const double s = found[i].sigma;
    const double along_x = normal_cdf(-at.x() / s) - normal_cdf((-20 - at.x()) / s);
    const double along_y = normal_cdf((20 - at.y()) / s) - normal_cdf((-20 - at.y()) / s);
    EXPECT_NEAR(found[i].mass, along_x * along_y, kRounding);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[i].rgb[c], kLight[c] * along_x * along_y, kRounding);
  }
}

// A step of irradiance within one component: a ramp of width w between the half-planes. Its convolution
// differs from the step's by w^2/24 times the largest slope of the Gaussian's section, 0.25 / s^2: by 1e-12.
TEST_F(CliTruth, AStepEdge) {
  Files files;
  const double w = 1e-5;
  files.add_square(-20, -0.5 * w, -20, 20, kLight);
  files.add_square(0.5 * w, 20, -20, 20, Vec3d::Zero());
  files.faces.push_back({1, 4, 7});
  files.faces.push_back({1, 7, 2});
  files.points = {{0, Vec3d(0.02, 0.5, 0.48)},
                  {3, Vec3d(0.5, 0.02, 0.48)},
                  {2, Vec3d(0.46, 0.04, 0.5)},
                  {4, Vec3d(0.5, 0, 0.5)}};
  write(files);
  for (const Row& row : rows()) {
    const double u = -files.position(static_cast<std::size_t>(row.point)).x();
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(row.rgb[c], kLight[c] * 0.5 * (1 + std::erf(u / std::sqrt(2.0))), kRounding);
    }
    EXPECT_NEAR(row.mass, 1.0, kRounding);
  }
}

// A linear function is its own convolution with an even kernel: every vertex and face must be where the files
// say. Points lie inside, on an edge, and on a vertex; the grid ends 15 s away.
TEST_F(CliTruth, LinearIrradianceIsReproduced) {
  Files files = grid(20);
  files.points = {
      {420, kThird}, {421, Vec3d(0.25, 0.75, 0)}, {379, Vec3d(0, 0, 1)}, {419, Vec3d(0.1, 0.2, 0.7)}};
  write(files);
  for (const Row& row : rows({{"--sigma", "0.3,0.5"}})) {
    const Vec3d at = files.position(static_cast<std::size_t>(row.point));
    EXPECT_NEAR(row.rgb[0], 1 + 0.1 * at.x(), kRounding);
    EXPECT_NEAR(row.rgb[1], 1 - 0.05 * at.y(), kRounding);
    EXPECT_NEAR(row.rgb[2], 0.25, kRounding);
  }
}

// The same surface with vertices and faces in another order, corners turned, Windows line ends and blanks.
TEST_F(CliTruth, FileOrderDecides) {
  const Files files = grid(6);
  Files other;
  const auto count = static_cast<int>(files.vertices.size());
  for (int v = count - 1; v >= 0; --v) {
    other.add_vertex(files.vertices[static_cast<std::size_t>(v)],
                     files.irradiance[static_cast<std::size_t>(v)]);
  }
  const auto faces = files.faces.size();
  for (std::size_t i = 0; i < faces; ++i) {
    const std::array<int, 3>& f = files.faces[(i * 7 + 3) % faces];
    other.faces.push_back({count - 1 - f[1], count - 1 - f[2], count - 1 - f[0]});
  }
  Files first = files;
  const Vec3d b(0.2, 0.3, 0.5);
  for (std::size_t i = 0; i < faces; ++i) {
    first.points.emplace_back(static_cast<int>((i * 7 + 3) % faces), b);
    other.points.emplace_back(static_cast<int>(i), Vec3d(b[1], b[2], b[0]));
  }
  write(first);
  const std::vector<Row> expected = rows();
  write(other);
  std::string points;
  for (const char c : other.points_csv())
    points += c == '\n' ? "\r\n" : (c == ',' ? " , " : std::string(1, c));
  folder_.write("p.csv", "\xEF\xBB\xBF" + points + "\r\n\r\n");
  const std::vector<Row> found = rows();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LT((found[i].rgb - expected[i].rgb).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_NEAR(found[i].mass, expected[i].mass, 1e-13);
  }
}

// On a plane, what is within r_max has the mass 1 - exp(-r_max^2 / 2 s^2).
TEST_F(CliTruth, RMaxCutsTheKernelOff) {
  Files files = half_plane();
  files.points = {{0, Vec3d(0.25, 0.25, 0.5)}};
  write(files);
  for (const char* engine : {"exact", "fast", "brute"}) {
    for (const Row& row : rows({{"--sigma", "0.8,2"}, {"--r-max", "1.7"}, {"--engine", engine}}, false)) {
      const double expected = 1 - std::exp(-0.5 * 1.7 * 1.7 / (row.sigma * row.sigma));
      const double tolerance = std::string(engine) == "fast" ? 1e-4 : 1.1e-10;
      EXPECT_NEAR(row.mass, expected, tolerance) << engine;
      EXPECT_NEAR(row.rgb[1], 0.5 * expected, tolerance) << engine;
    }
  }
}

// Three engines, one answer, at each one's tolerance, on a folded sheet.
TEST_F(CliTruth, EnginesAgree) {
  Files files = grid(10);
  for (Vec3d& v : files.vertices) v.z() = 1.5 * std::abs(v.x()) + 0.2 * std::sin(3 * v.y());
  for (int f = 0; f < 200; f += 9) files.points.emplace_back(f, Vec3d(0.1, 0.3, 0.6));
  write(files);
  const double largest = 1.5;
  const std::vector<Row> exact = rows({{"--sigma", "0.2,0.6,2"}});
  const auto compare = [&](const std::string& engine, const std::string& tolerance, double allowed) {
    std::map<std::string, std::string> options = {{"--sigma", "0.2,0.6,2"}, {"--engine", engine}};
    if (!tolerance.empty()) options["--tolerance"] = tolerance;
    const std::vector<Row> found = rows(options, false);
    ASSERT_EQ(found.size(), exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      EXPECT_LE((found[i].rgb - exact[i].rgb).cwiseAbs().maxCoeff(), allowed * largest) << engine;
      EXPECT_LE(std::abs(found[i].mass - exact[i].mass), allowed) << engine;
    }
  };
  compare("fast", "", 1e-4);
  compare("fast", "1e-6", 1e-6);
  compare("brute", "", 1.1e-10);
  compare("brute", "1e-5", 1.1e-5);
  compare("exact", "", 0.0);
}

// Half of the square is masked out: on the cut, half of the plane's mass is left.
TEST_F(CliTruth, TheMaskLeavesTrianglesOut) {
  Files files = half_plane();
  files.points = {{0, Vec3d(0.5, 0, 0.5)}};
  write(files);
  for (const char* mask : {"1\n0\n", "skin\n1\n0\n"}) {
    folder_.write("mask.csv", mask);
    const std::vector<Row> found = rows({{"--mask", "mask.csv"}});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NEAR(found[0].mass, 0.5, kRounding);
    EXPECT_NEAR(found[0].rgb[0], 0.5, kRounding);
  }
  files.points = {{0, kThird}, {1, kThird}};
  write(files);
  std::filesystem::remove(folder_.path() / "o.csv");
  expect_refused(truth({{"--mask", "mask.csv"}}), "truescatter: p.csv:3:1: face 1 is not skin in mask.csv");
}

// Light does not cross from one component to another, however near; the mask can part what was one.
TEST_F(CliTruth, ComponentsAreApart) {
  Files files = half_plane();
  files.add_square(1e-9, 20, -20, 20, kLight);
  files.points = {{0, Vec3d(0, 0.5, 0.5)}, {2, Vec3d(0.5, 0, 0.5)}};
  write(files);
  const std::vector<Row> two = rows();
  ASSERT_EQ(two.size(), 2U);
  EXPECT_NEAR(two[0].mass, 0.5, kRounding);  // on the boundary of its own

  Files sheet = grid(8);
  for (int i = 0; i < 128; ++i) {
    if (i / 2 % 8 < 4) sheet.points.emplace_back(i, kThird);
  }
  std::string mask;
  for (int i = 0; i < 128; ++i) mask += i / 2 % 8 == 4 ? "0\n" : "1\n";  // a column of cells, 1 mm wide
  write(sheet);
  folder_.write("mask.csv", mask);
  for (const Row& row : rows({{"--mask", "mask.csv"}})) {
    const Vec3d at = sheet.position(static_cast<std::size_t>(row.point));
    const double along_x = normal_cdf(-at.x()) - normal_cdf(-4 - at.x());
    const double along_y = normal_cdf(4 - at.y()) - normal_cdf(-4 - at.y());
    EXPECT_NEAR(row.mass, along_x * along_y, kRounding);
  }
}

// A file split at a UV seam: two squares that share positions, not vertices.
TEST_F(CliTruth, ASeamIsNoBoundary) {
  Files files = half_plane();
  files.add_square(0, 20, -20, 20, kLight);
  files.points = {{0, Vec3d(0, 0.5, 0.5)}, {2, Vec3d(0.5, 0, 0.5)}};
  write(files);
  const std::vector<Row> found = rows();
  ASSERT_EQ(found.size(), 2U);
  for (const Row& row : found) {
    EXPECT_NEAR(row.mass, 1.0, kRounding);
    EXPECT_NEAR(row.rgb[2], 0.25, kRounding);
  }
  std::filesystem::remove(folder_.path() / "o.csv");
  files.irradiance[7] = Vec3d(1, 0.5, 0.3);
  write(files);
  expect_refused(truth(),
                 "i.csv:9: vertex 7 is at the position of vertex 2 (from 0), and its irradiance "
                 "(1, 0.5, 0.3) differs from (1, 0.5, 0.25) in line 4");
}

TEST_F(CliTruth, JobsDoNotChangeABit) {
  Files files = grid(8);
  for (int f = 0; f < 128; ++f) files.points.emplace_back(f, Vec3d(0.2, 0.2, 0.6));
  write(files);
  for (const char* engine : {"fast", "exact", "brute"}) {
    rows({{"--engine", engine}, {"--jobs", "1"}, {"--sigma", "0.4,3"}}, false);
    const std::string one = text("o.csv");
    rows({{"--engine", engine}, {"--jobs", "4"}, {"--sigma", "0.4,3"}}, false);
    EXPECT_EQ(text("o.csv"), one) << engine;
  }
}

// Every digit that a double has; no points, no rows; nothing left beside the file.
TEST_F(CliTruth, WritesFullPrecision) {
  Files files = half_plane();
  write(files);
  EXPECT_EQ(rows().size(), 0U);
  files.points = {{0, Vec3d(0.2, 0.3, 0.5)}};
  write(files);
  rows({{"--sigma", "0.1"}});
  const std::string csv = text("o.csv");
  EXPECT_TRUE(contains(csv, "\n0,0.10000000000000001,")) << csv;
  EXPECT_EQ(folder_.names().size(), 4U);
}

TEST_F(CliTruth, RefusesBrokenFiles) {
  write(half_plane());
  folder_.write("p.csv", "face,b0,b1,b2\n0,1,0,0\n2,1,0,0\n");
  expect_refused(truth(), "truescatter: p.csv:3:1: face 2 is out of range: m.obj has faces 0 to 1\n");
}

// On a convex plane geodesics are straight lines, so every value is the Euclidean one; a mask changes
// neither.
TEST_F(CliTruth, GeodesicIsEuclideanOnAPlane) {
  Files files = grid(12);
  for (int i = 0; i < 12; ++i) files.points.emplace_back(23 * i, Vec3d(0.2, 0.1 + 0.02 * i, 0.7 - 0.02 * i));
  files.points.emplace_back(100, Vec3d(0, 1, 0));
  files.points.emplace_back(130, Vec3d(0.5, 0.5, 0));
  write(files);
  std::string mask;
  for (std::size_t f = 0; f < files.faces.size(); ++f) mask += f % 24 < 20 ? "1\n" : "0\n";
  folder_.write("mask.csv", mask);
  for (const std::string& masked : std::vector<std::string>{"", "mask.csv"}) {
    if (!masked.empty()) std::erase_if(files.points, [](const auto& p) { return p.first % 24 >= 20; });
    write(files);
    for (const std::string& r_max : std::vector<std::string>{"", "1.7"}) {
      const std::map<std::string, std::string> options = {
          {"--sigma", "0.4,1.1"}, {"--mask", masked}, {"--r-max", r_max}};
      std::map<std::string, std::string> geodesic = options;
      geodesic["--metric"] = "geodesic";
      const std::vector<Row> straight = rows(options);
      const std::vector<Row> along = rows(geodesic);
      geodesic["--engine"] = "fast";
      const std::vector<Row> fast = rows(geodesic, false);
      ASSERT_EQ(straight.size(), 2 * files.points.size());
      ASSERT_EQ(along.size(), straight.size());
      ASSERT_EQ(fast.size(), straight.size());
      for (std::size_t i = 0; i < straight.size(); ++i) {
        EXPECT_NEAR(along[i].mass, straight[i].mass, kRounding) << i;
        EXPECT_LE((along[i].rgb - straight[i].rgb).cwiseAbs().maxCoeff(), 1.6 * kRounding) << i;
        EXPECT_NEAR(fast[i].mass, straight[i].mass, 1e-4) << i;
        EXPECT_LE((fast[i].rgb - straight[i].rgb).cwiseAbs().maxCoeff(), 1.6e-4) << i;
      }
    }
  }
}

// Three squares at a cube's corner, 0.8 standard deviations away from it: tabulated.
TEST_F(CliTruth, GeodesicMassAtACubesCorner) {
  Files files;
  const int o = files.add_vertex({0, 0, 0}, kLight);
  const int x = files.add_vertex({30, 0, 0}, kLight);
  const int y = files.add_vertex({0, 30, 0}, kLight);
  const int z = files.add_vertex({0, 0, 30}, kLight);
  const int xy = files.add_vertex({30, 30, 0}, kLight);
  const int yz = files.add_vertex({0, 30, 30}, kLight);
  const int zx = files.add_vertex({30, 0, 30}, kLight);
  files.faces = {{o, x, xy}, {o, xy, y}, {o, y, yz}, {o, yz, z}, {o, z, zx}, {o, zx, x}};
  const double share = 0.8 / 30.0 / std::sqrt(2.0);  // along the diagonal of the first square
  files.points = {{0, Vec3d(1.0 - share, 0, share)}, {1, Vec3d(1.0 - share, share, 0)}};
  write(files);
  const std::vector<Row> found = rows({{"--metric", "geodesic"}});
  ASSERT_EQ(found.size(), 2U);
  for (const Row& row : found) EXPECT_NEAR(row.mass, 0.918316175058, 1e-12);
}

// On rough ground, part of which is no skin: plain quadrature, with distances of either kind, and the
// formula. The second opinions keep to 1e-6 by default; beyond their reach lies a hundredth of that.
TEST_F(CliTruth, GeodesicSecondOpinionsAgree) {
  Files files = grid(5);
  for (std::size_t v = 0; v < files.vertices.size(); ++v)
    files.vertices[v].z() = 0.8 * std::sin(2.1 * static_cast<double>(v * v % 17));
  files.points = {{3, kThird}, {22, Vec3d(0, 0.4, 0.6)}, {25, Vec3d(0, 1, 0)}};
  write(files);
  std::string mask;
  for (std::size_t f = 0; f < files.faces.size(); ++f) mask += f % 10 < 7 ? "1\n" : "0\n";
  folder_.write("mask.csv", mask);
  for (const std::string& r_max : std::vector<std::string>{"", "1.3"}) {
    std::map<std::string, std::string> options = {
        {"--metric", "geodesic"}, {"--sigma", "0.3,1"}, {"--mask", "mask.csv"}, {"--r-max", r_max}};
    const std::vector<Row> exact = rows(options);
    ASSERT_EQ(exact.size(), 6U);
    for (const char* engine : {"brute", "cgal"}) {
      options["--engine"] = engine;
      options["--jobs"] = "1";
      const std::vector<Row> found = rows(options, false);
      const std::string one = text("o.csv");
      options["--jobs"] = "3";
      rows(options, false);
      EXPECT_EQ(text("o.csv"), one) << engine;
      ASSERT_EQ(found.size(), exact.size());
      for (std::size_t i = 0; i < exact.size(); ++i) {
        EXPECT_NEAR(found[i].mass, exact[i].mass, 1.1e-6) << engine << " " << i;
        // The largest irradiance is 1.25.
        EXPECT_LE((found[i].rgb - exact[i].rgb).cwiseAbs().maxCoeff(), 1.25 * 1.1e-6) << engine << " " << i;
      }
    }
  }
}

// Two Gaussians of signed weights: sum w M, sum w M / m and sum w m of what --sigma gives for each, on either
// metric and by every engine. Sums of a few doubles: 1e-14. Where an engine keeps to a tolerance, each
// Gaussian is computed to that over 1.75, the largest sum of |weights|.
TEST_F(CliTruth, AFitIsTheWeightedSum) {
  Files files = grid(12);
  for (int i = 0; i < 6; ++i) files.points.emplace_back(47 * i, Vec3d(0.2, 0.1 + 0.02 * i, 0.7 - 0.02 * i));
  write(files);
  folder_.write("fit.json", R"({"variances": [0.25, 2.25], "albedo": [1, 1, 1],
      "weights": [[0.5, 1, -0.25], [0.25, 0.75, 1]]})");
  const std::array<Vec3d, 2> weights = {Vec3d(0.5, 1, -0.25), Vec3d(0.25, 0.75, 1)};
  const std::map<std::string, std::vector<std::string>> engines = {
      {"euclidean", {"fast", "exact", "brute"}}, {"geodesic", {"fast", "exact", "brute", "cgal"}}};
  for (const auto& [metric, names] : engines) {
    for (const std::string& engine : names) {
      std::map<std::string, std::string> options = {
          {"--metric", metric}, {"--engine", engine}, {"--r-max", "2.5"}};
      const double tolerance = 1e-5;
      if (engine != "exact") options["--tolerance"] = number(tolerance / 1.75);
      options["--sigma"] = "0.5,1.5";
      const std::vector<Row> each = rows(options, false);
      options["--sigma"] = "";
      options["--fit"] = "fit.json";
      if (engine != "exact") options["--tolerance"] = number(tolerance);
      const ProgramResult result = truth(options);
      ASSERT_EQ(result.exit_code, 0) << result.err;
      std::istringstream lines(text("o.csv"));
      std::string line;
      std::getline(lines, line);
      EXPECT_EQ(line, "point,r,g,b,normalised_r,normalised_g,normalised_b,mass_r,mass_g,mass_b");
      for (std::size_t i = 0; i < files.points.size(); ++i) {
        ASSERT_TRUE(std::getline(lines, line));
        std::istringstream cells(line);
        std::size_t point = 0;
        cells >> point;
        EXPECT_EQ(point, i);
        const Row& a = each[2 * i];
        const Row& b = each[2 * i + 1];
        const Vec3d raw = weights[0].cwiseProduct(a.rgb) + weights[1].cwiseProduct(b.rgb);
        const Vec3d normalised =
            weights[0].cwiseProduct(a.rgb) / a.mass + weights[1].cwiseProduct(b.rgb) / b.mass;
        const Vec3d mass = weights[0] * a.mass + weights[1] * b.mass;
        for (const Vec3d& expected : {raw, normalised, mass}) {
          for (int c = 0; c < 3; ++c) {
            char comma = 0;
            double value = 0.0;
            cells >> comma >> value;
            EXPECT_NEAR(value, expected[c], 1e-14) << metric << " " << engine << ": " << line;
          }
        }
      }
      EXPECT_FALSE(std::getline(lines, line));
    }
  }
}

TEST_F(CliTruth, RefusesWrongUsage) {
  Files files = half_plane();
  files.points = {{0, kThird}};
  write(files);
  folder_.write("tiny.json", R"({"variances": [1e-20], "weights": [[1, 1, 1]]})");
  folder_.write("heavy.json", R"({"variances": [1, 2], "weights": [[-1, 0, 0], [3, 0, 0]]})");
  using Options = std::map<std::string, std::string>;
  const std::vector<std::pair<Options, std::string>> table = {
      {{{"--mesh", ""}}, "--mesh is required"},
      {{{"--sigma", ""}}, "truescatter: --sigma or --fit is required\n"},
      {{{"--fit", "fit.json"}}, "--sigma and --fit contradict each other"},
      {{{"--sigma", ""}, {"--fit", "none.json"}}, "none.json: no such file"},
      {{{"--sigma", ""}, {"--fit", "p.csv"}}, "p.csv:1:3: this is not valid JSON"},
      {{{"--sigma", ""}, {"--fit", "tiny.json"}}, "tiny.json: variances[0] is 1e-20: it must be 1e-18"},
      {{{"--sigma", ""}, {"--fit", "heavy.json"}, {"--tolerance", "1e-9"}},
       "--tolerance: 1e-09 is out of reach: the fit's weights sum to 4 in magnitude"},
      {{{"--mesh", "none.obj"}}, "none.obj: there is no such file"},
      {{{"--irradiance", "none.csv"}}, "none.csv: no such file"},
      {{{"--points", "none.csv"}}, "none.csv: no such file"},
      {{{"--mask", "none.csv"}}, "none.csv: no such file"},
      {{{"--points", "."}}, ".: is a folder"},
      {{{"--sigma", "0"}}, "truescatter: --sigma: \"0\": a standard deviation in mm must be above 0"},
      {{{"--sigma", "1,-2"}}, "--sigma: \"-2\": a standard deviation in mm must be above 0"},
      {{{"--sigma", "1,,2"}}, "--sigma: \"\" is not a number"},
      {{{"--sigma", "1,2,"}}, "--sigma: \"\" is not a number"},
      {{{"--sigma", "1;2"}}, "--sigma: \"1;2\" is not a number"},
      {{{"--sigma", "inf"}}, "--sigma: \"inf\" is not finite"},
      {{{"--sigma", "1e-170"}},
       "--sigma: \"1e-170\" is out of range: a standard deviation is 1e-09 to 1000000000 mm"},
      {{{"--r-max", "-1"}}, "--r-max: \"-1\": a cut-off in mm must be above 0"},
      {{{"--r-max", "0"}}, "--r-max: \"0\": a cut-off in mm must be above 0"},
      {{{"--r-max", "nan"}}, "--r-max: \"nan\" is not finite"},
      {{{"--tolerance", "0"}}, "--tolerance: \"0\": a tolerance must be above 0"},
      {{{"--tolerance", "1e-12"}}, "--tolerance: 1e-12 is out of range: with this engine it is 1e-09 to 0.1"},
      {{{"--tolerance", "1e-15"}, {"--engine", "brute"}}, "with this engine it is 1e-13 to 0.1"},
      {{{"--tolerance", "2"}}, "--tolerance: 2 is out of range"},
      {{{"--engine", "slow"}}, "--engine: \"slow\" is not known; there are: fast, exact, brute, cgal"},
      {{{"--engine", "cgal"}}, "--engine: cgal computes geodesic distances: it needs --metric geodesic"},
      {{{"--metric", "manhattan"}}, "--metric: \"manhattan\" is not known; there are: euclidean, geodesic"},
      {{{"--metric", "geodesic"}, {"--engine", "brute"}, {"--tolerance", "1e-10"}},
       "--tolerance: 1e-10 is out of range: with this engine it is 1e-09 to 0.1"},
      {{{"--metric", "geodesic"}, {"--engine", "cgal"}, {"--tolerance", "1e-10"}},
       "--tolerance: 1e-10 is out of range: with this engine it is 1e-09 to 0.1"},
      {{{"--jobs", "0"}}, "--jobs"},
      {{{"--out", "none/o.csv"}}, "none/o.csv: cannot be written: there is no folder none"},
      {{{"--out", "."}}, "is a folder; the name of a file is needed"},
      {{{"--frobnicate", "1"}}, "--frobnicate"},
  };
  for (const auto& [options, message] : table) expect_refused(truth(options), message);
  expect_refused(truth({{"--engine", "fast"}}, true), "--exact and --engine fast contradict each other");
  EXPECT_EQ(truth({{"--engine", "exact"}}, true).exit_code, 0);
}

}  // namespace
}  // namespace truescatter::test
