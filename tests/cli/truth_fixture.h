#pragma once

#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cli/cli_fixture.h"
#include "core/vec.h"

namespace truescatter::test {

inline std::string number(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

// A mesh, its irradiance and points on it, as the files say them.
struct Files {
  std::vector<Vec3d> vertices;
  std::vector<Vec3d> irradiance;
  std::vector<std::array<int, 3>> faces;
  std::vector<std::pair<int, Vec3d>> points;

  int add_vertex(const Vec3d& position, const Vec3d& light) {
    vertices.push_back(position);
    irradiance.push_back(light);
    return static_cast<int>(vertices.size()) - 1;
  }
  // The square [x0, x1] x [y0, y1] at z = 0, of one irradiance: two triangles.
  void add_square(double x0, double x1, double y0, double y1, const Vec3d& light) {
    const int a = add_vertex({x0, y0, 0}, light);
    const int b = add_vertex({x1, y0, 0}, light);
    const int c = add_vertex({x1, y1, 0}, light);
    const int d = add_vertex({x0, y1, 0}, light);
    faces.push_back({a, b, c});
    faces.push_back({a, c, d});
  }
  Vec3d position(std::size_t point) const {
    Vec3d sum = Vec3d::Zero();
    const auto& [face, b] = points[point];
    for (std::size_t c = 0; c < 3; ++c) {
      const int v = faces[static_cast<std::size_t>(face)][c];
      sum += b[static_cast<Eigen::Index>(c)] * vertices[static_cast<std::size_t>(v)];
    }
    return sum;
  }

  std::string obj() const {
    std::string text = "# a mesh\n";
    for (const Vec3d& v : vertices)
      text += "v " + number(v.x()) + " " + number(v.y()) + " " + number(v.z()) + "\n";
    for (const auto& f : faces) {
      text += "f " + std::to_string(f[0] + 1) + " " + std::to_string(f[1] + 1) + " " +
              std::to_string(f[2] + 1) + "\n";
    }
    return text;
  }
  std::string irradiance_csv() const {
    std::string text = "r,g,b\n";
    for (const Vec3d& v : irradiance)
      text += number(v.x()) + "," + number(v.y()) + "," + number(v.z()) + "\n";
    return text;
  }
  std::string points_csv() const {
    std::string text = "face,b0,b1,b2\n";
    for (const auto& [face, b] : points) {
      text += std::to_string(face) + "," + number(b[0]) + "," + number(b[1]) + "," + number(b[2]) + "\n";
    }
    return text;
  }
};

struct Row {
  int point = 0;
  double sigma = 0.0;
  Vec3d rgb = Vec3d::Zero();
  double mass = 0.0;
};

inline double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

inline const Vec3d kLight(1.0, 0.5, 0.25);
inline const Vec3d kThird = Vec3d::Constant(1.0 / 3.0);

// The command `truth` on files in a folder of its own.
class CliTruth : public Cli {
 protected:
  void write(const Files& files) const {
    folder_.write("m.obj", files.obj());
    folder_.write("i.csv", files.irradiance_csv());
    folder_.write("p.csv", files.points_csv());
  }
  // `more` replaces or adds to the usual options; an empty value takes one away.
  ProgramResult truth(const std::map<std::string, std::string>& more = {}, bool exact = false) const {
    std::map<std::string, std::string> options = {{"--mesh", "m.obj"},
                                                  {"--irradiance", "i.csv"},
                                                  {"--points", "p.csv"},
                                                  {"--sigma", "1"},
                                                  {"--out", "o.csv"}};
    for (const auto& [name, value] : more) options[name] = value;
    std::vector<std::string> arguments = {"truth"};
    for (const auto& [name, value] : options) {
      if (value.empty()) continue;
      arguments.push_back(name);
      arguments.push_back(value);
    }
    if (exact) arguments.emplace_back("--exact");
    return truescatter(arguments);
  }
  std::vector<Row> rows(const std::map<std::string, std::string>& more = {}, bool exact = true) const {
    const ProgramResult result = truth(more, exact);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    if (result.exit_code != 0) return {};
    EXPECT_EQ(result.out, "o.csv\n");
    return parsed(text("o.csv"));
  }
  static std::vector<Row> parsed(const std::string& csv) {
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "point,sigma,r,g,b,mass");
    std::vector<Row> rows;
    while (std::getline(lines, line)) {
      std::istringstream cells(line);
      Row row;
      char comma = 0;
      cells >> row.point >> comma >> row.sigma >> comma >> row.rgb[0] >> comma >> row.rgb[1] >> comma >>
          row.rgb[2] >> comma >> row.mass;
      EXPECT_FALSE(cells.fail()) << line;
      rows.push_back(row);
    }
    return rows;
  }
  void expect_refused(const ProgramResult& result, const std::string& message) const {
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(contains(result.err, message)) << message << "\nis not in\n" << result.err;
    EXPECT_FALSE(exists("o.csv"));
  }
};

}  // namespace truescatter::test
