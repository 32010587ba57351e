#include "experiment/truth_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

#include "core/csv.h"
#include "core/error.h"
#include "experiment/mesh_checks.h"
#include "scene/load_mesh.h"

namespace truescatter {
namespace {

// What decimals that were cut short may be off by.
constexpr double kBarycentricSlack = 1e-9;

// Points name faces, and masks count them: a face that was cut into triangles would shift both.
void require_triangles(const LoadedMesh& loaded, const std::filesystem::path& path) {
  const std::vector<int>& face = loaded.file_face_of_triangle;
  for (std::size_t t = 1; t < face.size(); ++t) {
    if (face[t] != face[t - 1]) continue;
    throw_input_error({path.string()}, "face {} (from 0) has more than 3 corners: triangles are needed",
                      face[t]);
  }
}

// The values of a row too many stand at `reader`; those of a row missing, nowhere.
[[noreturn]] void refuse_count(const CsvReader& reader, std::size_t needed, std::string_view of_what,
                               const std::filesystem::path& mesh) {
  const std::string rule =
      fmt::format("{} has {} {}, and one row for each is needed", mesh.string(), needed, of_what);
  if (reader.rows() > needed) throw_input_error(reader.where(), "this is row {}: {}", reader.rows(), rule);
  throw_input_error({reader.name()}, "has {} rows: {}", reader.rows(), rule);
}

// RGB of each of the mesh's vertices, from a row for each of the file's.
std::vector<Vec3d> read_irradiance(const TruthFiles& files, const LoadedMesh& loaded) {
  struct Given {
    std::size_t file_vertex = 0;
    int line = 0;  // 0: none yet
  };
  const std::vector<int>& vertex_of = loaded.vertex_of_file_vertex;
  std::vector<Vec3d> irradiance(loaded.mesh.positions_mm.size(), Vec3d::Zero());
  std::vector<Given> given(irradiance.size());
  CsvReader reader(files.irradiance, {"r", "g", "b"});
  while (reader.next()) {
    const std::size_t file_vertex = reader.rows() - 1;
    if (file_vertex >= vertex_of.size()) refuse_count(reader, vertex_of.size(), "vertices", files.mesh);
    const Vec3d value(reader.number(0), reader.number(1), reader.number(2));
    const auto v = static_cast<std::size_t>(vertex_of[file_vertex]);
    if (given[v].line == 0) {
      irradiance[v] = value;
      given[v] = {file_vertex, reader.where().line};
    } else if (value != irradiance[v]) {
      throw_input_error(reader.where(),
                        "vertex {} is at the position of vertex {} (from 0), and its irradiance ({}, {}, {}) "
                        "differs from ({}, {}, {}) in line {}: it must be one function on the surface",
                        file_vertex, given[v].file_vertex, value.x(), value.y(), value.z(), irradiance[v].x(),
                        irradiance[v].y(), irradiance[v].z(), given[v].line);
    }
  }
  if (reader.rows() < vertex_of.size()) refuse_count(reader, vertex_of.size(), "vertices", files.mesh);
  return irradiance;
}

std::vector<bool> read_mask(const TruthFiles& files, std::size_t triangles) {
  std::vector<bool> skin(triangles, true);
  if (files.mask.empty()) return skin;
  CsvReader reader(files.mask, {"skin"}, CsvReader::Header::optional);
  while (reader.next()) {
    if (reader.rows() > triangles) refuse_count(reader, triangles, "triangles", files.mesh);
    const int label = reader.whole(0);
    if (label != 0 && label != 1)
      throw_input_error(reader.where(0), "{} where 0 or 1 (skin) is needed", label);
    skin[reader.rows() - 1] = label == 1;
  }
  if (reader.rows() < triangles) refuse_count(reader, triangles, "triangles", files.mesh);
  return skin;
}

MeshPoint read_place(const CsvReader& reader, const TruthProblem& problem, const TruthFiles& files) {
  const int face = reader.whole(0);
  const std::size_t count = problem.mesh.triangle_count();
  if (face < 0 || static_cast<std::size_t>(face) >= count) {
    throw_input_error(reader.where(0), "face {} is out of range: {} has faces 0 to {}", face,
                      files.mesh.string(), count - 1);
  }
  MeshPoint place{static_cast<std::size_t>(face), Vec3d::Zero()};
  if (!problem.skin[place.triangle]) {
    throw_input_error(reader.where(0), "face {} is not skin in {}: there is no truth at its points", face,
                      files.mask.string());
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const double b = reader.number(c + 1);
    if (b < -kBarycentricSlack || b > 1.0 + kBarycentricSlack)
      throw_input_error(reader.where(c + 1), "b{} is {}: it must be 0 to 1", c, b);
    place.barycentric[static_cast<Eigen::Index>(c)] = b;
  }
  if (std::abs(place.barycentric.sum() - 1.0) > kBarycentricSlack) {
    throw_input_error(reader.where(1), "b0, b1, b2 sum to {}: they must sum to 1", place.barycentric.sum());
  }
  place.barycentric = place.barycentric.cwiseMax(0.0);
  place.barycentric /= place.barycentric.sum();
  return place;
}

}  // namespace

TruthProblem read_truth_problem(const TruthFiles& files) {
  LoadedMesh loaded = load_mesh_in_file_order(files.mesh, {});
  require_triangles(loaded, files.mesh);
  TruthProblem problem;
  const std::vector<Vec3d> irradiance = read_irradiance(files, loaded);
  problem.skin = read_mask(files, loaded.mesh.triangle_count());
  problem.mesh = std::move(loaded.mesh);
  const Mesh& mesh = problem.mesh;
  const std::vector<int> components = label_components(
      mesh.triangle_count(), [&](std::size_t t) { return mesh.triangles[t]; },
      [&](std::size_t t) { return problem.skin[t]; });
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    if (!problem.skin[t]) continue;
    SurfaceTriangle triangle;
    triangle.component = components[t];
    for (std::size_t c = 0; c < 3; ++c) {
      triangle.corners_mm[c] = mesh.corner(t, static_cast<int>(c));
      triangle.irradiance[c] = irradiance[static_cast<std::size_t>(mesh.triangles[t][c])];
    }
    problem.surface.triangles.push_back(triangle);
    problem.mesh_triangle.push_back(t);
  }
  refuse_repeated_triangles(mesh, problem.mesh_triangle, {files.mesh.string()});
  refuse_parted_surface(mesh, problem.mesh_triangle, components, {files.mesh.string()});
  CsvReader reader(files.points, {"face", "b0", "b1", "b2"});
  while (reader.next()) {
    problem.places.push_back(read_place(reader, problem, files));
    const MeshPoint& place = problem.places.back();
    problem.points.push_back({position_mm(mesh, place), components[place.triangle]});
  }
  return problem;
}

std::string truth_csv(std::span<const TruthLayer> layers, const TruthValues& values) {
  std::string text = "point,sigma,r,g,b,mass\n";
  const std::size_t points = layers.empty() ? 0 : values.front().size();
  for (std::size_t i = 0; i < points; ++i) {
    for (std::size_t l = 0; l < layers.size(); ++l) {
      const Vec4d& value = values[l][i];
      if (!value.allFinite())
        throw_run_error("the truth at point {}, sigma {}, is not a finite number", i, layers[l].std_dev_mm);
      fmt::format_to(std::back_inserter(text), "{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", i,
                     layers[l].std_dev_mm, value[0], value[1], value[2], value[3]);
    }
  }
  return text;
}

std::string fit_truth_csv(std::span<const GaussianLevel> levels, const TruthValues& values) {
  std::string text = "point,r,g,b,normalised_r,normalised_g,normalised_b,mass_r,mass_g,mass_b\n";
  const std::size_t points = levels.empty() ? 0 : values.front().size();
  for (std::size_t i = 0; i < points; ++i) {
    Vec3d raw = Vec3d::Zero();
    Vec3d normalised = Vec3d::Zero();
    Vec3d mass = Vec3d::Zero();
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const Vec4d& value = values[l][i];
      const Vec3d light = levels[l].weight.cwiseProduct(value.head<3>());
      raw += light;
      if (value[3] > 0.0) normalised += light / value[3];
      mass += levels[l].weight * value[3];
    }
    if (!raw.allFinite() || !normalised.allFinite() || !mass.allFinite())
      throw_run_error("the truth at point {} is not a finite number", i);
    fmt::format_to(std::back_inserter(text), "{}", i);
    for (const Vec3d& rgb : {raw, normalised, mass}) {
      fmt::format_to(std::back_inserter(text), ",{:.17g},{:.17g},{:.17g}", rgb.x(), rgb.y(), rgb.z());
    }
    text += '\n';
  }
  return text;
}

}  // namespace truescatter
