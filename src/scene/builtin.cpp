#include "scene/builtin.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace truescatter {
namespace {

constexpr double kGutter = 1.0 / 64.0;    // between charts, of the atlas' side
constexpr double kHeadArea_mm2 = 1.67e5;  // by its triangles at the default edge
constexpr double kMostTriangles = 4.0e6;  // a larger scene is a slip in edge_mm
constexpr int kFewestSegmentsAround = 12;

double value_of(const BuiltinParameters& parameters, std::string_view name) {
  return parameters.find(name)->second;
}

int cells_along(double length_mm, double edge_mm) {
  return std::max(1, static_cast<int>(std::ceil(length_mm / edge_mm - 1e-9)));
}

// A vertex of one chart of a scene.
struct Sample {
  Vec3d position_mm;
  Vec3d normal;
  Vec2d uv;
};

// Collects triangles; positions that two charts share exactly are joined at the end.
class MeshBuilder {
 public:
  MeshBuilder() { mesh_.corner_uvs.emplace(); }

  void add_triangle(const Sample& a, const Sample& b, const Sample& c) {
    const int first = static_cast<int>(mesh_.positions_mm.size());
    mesh_.positions_mm.insert(mesh_.positions_mm.end(), {a.position_mm, b.position_mm, c.position_mm});
    mesh_.triangles.push_back({first, first + 1, first + 2});
    mesh_.corner_normals.push_back({a.normal, b.normal, c.normal});
    mesh_.corner_uvs->push_back({a.uv, b.uv, c.uv});
  }

  // A grid of columns x rows cells; `sample(i, j)` gives its vertices, i along u and j along v. A cell is
  // cut along its shorter diagonal; equal ones alternate, so that the grid has no preferred direction.
  template <typename SampleAt>
  void add_grid(int columns, int rows, const SampleAt& sample) {
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        const Sample a = sample(i, j);
        const Sample b = sample(i + 1, j);
        const Sample c = sample(i + 1, j + 1);
        const Sample d = sample(i, j + 1);
        const double ac = (c.position_mm - a.position_mm).norm();
        const double bd = (d.position_mm - b.position_mm).norm();
        const bool equal = std::abs(ac - bd) <= 1e-9 * (ac + bd);
        if (equal ? (i + j) % 2 == 0 : ac < bd) {
          add_triangle(a, b, c);
          add_triangle(a, c, d);
        } else {
          add_triangle(a, b, d);
          add_triangle(b, c, d);
        }
      }
    }
  }

  Mesh take() {
    weld_coincident_positions(mesh_);
    return std::move(mesh_);
  }

 private:
  Mesh mesh_;
};

// Where a chart that is measured in millimetres lies in the atlas.
struct Chart {
  Vec2d corner;  // UV of the chart's lower left
  double units_per_mm = 1.0;
  Vec2d uv(double x_mm, double y_mm) const { return corner + units_per_mm * Vec2d(x_mm, y_mm); }
};

// `index` of `count` steps from -half to +half; symmetric to the last bit, and exact at the ends.
double step_between(double half, int index, int count) {
  return half * static_cast<double>(2 * index - count) / static_cast<double>(count);
}

// A flat rectangle in the plane z, facing +z, with x from x_low to x_low + width and y centred.
void add_upright_rectangle(MeshBuilder& builder, double x_low, double width, double height, double z,
                           double edge_mm, const Chart& chart) {
  const int columns = cells_along(width, edge_mm);
  const int rows = cells_along(height, edge_mm);
  builder.add_grid(columns, rows, [&](int i, int j) {
    const double along = width * static_cast<double>(i) / static_cast<double>(columns);
    const double y = step_between(0.5 * height, j, rows);
    return Sample{{x_low + along, y, z}, Vec3d::UnitZ(), chart.uv(along, y + 0.5 * height)};
  });
}

// The plane's height: its width where none is given.
double plane_length_mm(const BuiltinParameters& parameters) {
  const double length = value_of(parameters, "length_mm");
  return length > 0.0 ? length : value_of(parameters, "size_mm");
}

// One chart that fills the atlas, or charts x charts ones at one scale between gutters. Their rows and
// columns run backwards through the atlas, so that no two edges that meet on the surface face each other
// there.
Mesh make_plane(const BuiltinParameters& parameters) {
  const double edge = value_of(parameters, "edge_mm");
  const double v_scale = 1.0 / value_of(parameters, "uv_stretch");
  const int charts = static_cast<int>(value_of(parameters, "charts"));
  const Vec2d size(value_of(parameters, "size_mm"), plane_length_mm(parameters));
  const double gutter = charts > 1 ? kGutter : 0.0;
  const double slot = (1.0 - (charts + 1) * gutter) / charts;
  const double scale = slot * charts / size.maxCoeff();
  const int columns = cells_along(size.x() / charts, edge);
  const int rows = cells_along(size.y() / charts, edge);
  MeshBuilder builder;
  for (int row = 0; row < charts; ++row) {
    for (int column = 0; column < charts; ++column) {
      const Vec2d corner = Vec2d::Constant(gutter) +
                           (slot + gutter) * Vec2d(charts - 1 - column, (charts - 1 - row) * v_scale);
      builder.add_grid(columns, rows, [&](int i, int j) {
        const Vec2d in_chart(scale * size.x() / charts * i / columns,
                             scale * v_scale * size.y() / charts * j / rows);
        return Sample{{step_between(0.5 * size.x(), column * columns + i, charts * columns),
                       step_between(0.5 * size.y(), row * rows + j, charts * rows), 0.0},
                      Vec3d::UnitZ(),
                      corner + in_chart};
      });
    }
  }
  return builder.take();
}

Mesh make_cards(const BuiltinParameters& parameters) {
  const double size = value_of(parameters, "size_mm");
  const double half_gap = 0.5 * value_of(parameters, "gap_mm");
  const double edge = value_of(parameters, "edge_mm");
  // Side by side, at one scale: a gutter, the back, a gutter, the front, a gutter.
  const double scale = (1.0 - 3.0 * kGutter) / (1.5 * size);
  const double front_u = 2.0 * kGutter + scale * size;
  MeshBuilder builder;
  add_upright_rectangle(builder, -0.5 * size, size, size, -half_gap, edge, {{kGutter, kGutter}, scale});
  add_upright_rectangle(builder, -0.5 * size, 0.5 * size, size, half_gap, edge, {{front_u, kGutter}, scale});
  return builder.take();
}

Mesh make_wedge(const BuiltinParameters& parameters) {
  const double size = value_of(parameters, "size_mm");
  const double edge = value_of(parameters, "edge_mm");
  const double half_angle = 0.5 * value_of(parameters, "dihedral_deg") * kPi / 180.0;
  const int columns = cells_along(0.5 * size, edge);
  const int rows = cells_along(size, edge);
  MeshBuilder builder;
  for (const double side : {-1.0, 1.0}) {
    const Vec3d outward(side * std::sin(half_angle), 0.0, -std::cos(half_angle));
    const Vec3d normal(side * std::cos(half_angle), 0.0, std::sin(half_angle));
    builder.add_grid(columns, rows, [&](int i, int j) {
      // i runs to the right in the unfolded chart: towards the edge on the left half, away from it on the
      // right.
      const int steps = side < 0.0 ? columns - i : i;
      const double distance = 0.5 * size * static_cast<double>(steps) / static_cast<double>(columns);
      const double y = step_between(0.5 * size, j, rows);
      return Sample{
          distance * outward + y * Vec3d::UnitY(), normal, {0.5 + side * distance / size, 0.5 + y / size}};
    });
  }
  return builder.take();
}

// A cube's face on the lattice {0..n}^3: vertex (i, j) is origin * n + i * right + j * up.
struct CubeFace {
  Vec3i origin;
  Vec3i right;
  Vec3i up;
  Vec3i outward() const { return right.cross(up); }
};

const std::array<CubeFace, 6>& cube_faces() {
  static const std::array<CubeFace, 6> faces{{
      {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},   // +z, the front
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}},  // -z
      {{1, 0, 1}, {0, 0, -1}, {0, 1, 0}},  // +x
      {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}},   // -x
      {{0, 1, 1}, {1, 0, 0}, {0, 0, -1}},  // +y
      {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}},   // -y
  }};
  return faces;
}

// A cube blown up into a sphere, in equal steps of angle along each face's middle lines. Three columns of
// two charts.
Mesh make_sphere(const BuiltinParameters& parameters) {
  const double radius = value_of(parameters, "radius_mm");
  const int cells = std::max(2, cells_along(0.5 * kPi * radius, value_of(parameters, "edge_mm")));
  const double chart_size = (1.0 - 4.0 * kGutter) / 3.0;
  // One table for all faces, so that they meet in exactly the same positions.
  std::vector<double> tangent;
  for (int i = 0; i <= cells; ++i) tangent.push_back(std::tan(step_between(0.25 * kPi, i, cells)));
  MeshBuilder builder;
  for (std::size_t f = 0; f < cube_faces().size(); ++f) {
    const CubeFace& face = cube_faces()[f];
    const std::size_t column = f % 3;
    const std::size_t row = f / 3;
    const Vec2d corner(kGutter + (chart_size + kGutter) * static_cast<double>(column),
                       kGutter + (chart_size + kGutter) * static_cast<double>(row));
    builder.add_grid(cells, cells, [&](int i, int j) {
      const Vec3i lattice = cells * face.origin + i * face.right + j * face.up;
      const auto at = [&](int axis) { return tangent[static_cast<std::size_t>(lattice[axis])]; };
      const Vec3d normal = Vec3d(at(0), at(1), at(2)).normalized();
      const Vec2d uv = corner + chart_size / static_cast<double>(cells) * Vec2d(i, j);
      return Sample{radius * normal, normal, uv};
    });
  }
  return builder.take();
}

// A box with a chart per face at one scale: front and back side by side, the four narrow faces above.
Mesh make_slab(const BuiltinParameters& parameters) {
  const double size = value_of(parameters, "size_mm");
  const double thickness = value_of(parameters, "thickness_mm");
  const double edge = value_of(parameters, "edge_mm");
  const int wide_cells = cells_along(size, edge);
  const Vec3i cells(wide_cells, wide_cells, cells_along(thickness, edge));
  const Vec3d half(0.5 * size, 0.5 * size, 0.5 * thickness);

  // In the upper half, from left to right: the faces towards +x and -x, upright, then those towards +y and
  // -y, one above the other.
  const double scale =
      std::min((1.0 - 3.0 * kGutter) / (2.0 * size), (1.0 - 4.0 * kGutter) / (size + 2.0 * thickness));
  const double big = scale * size;
  const double narrow = scale * thickness;
  const double top = 2.0 * kGutter + big;
  const std::array<Vec2d, 6> corners{{{kGutter, kGutter},
                                      {2.0 * kGutter + big, kGutter},
                                      {kGutter, top},
                                      {2.0 * kGutter + narrow, top},
                                      {3.0 * kGutter + 2.0 * narrow, top},
                                      {3.0 * kGutter + 2.0 * narrow, top + narrow + kGutter}}};
  MeshBuilder builder;
  for (std::size_t f = 0; f < cube_faces().size(); ++f) {
    const CubeFace& face = cube_faces()[f];
    const Chart chart{corners[f], scale};
    const int columns = std::abs(face.right.dot(cells));
    const int rows = std::abs(face.up.dot(cells));
    const double width = 2.0 * std::abs(face.right.cast<double>().dot(half));
    const double height = 2.0 * std::abs(face.up.cast<double>().dot(half));
    builder.add_grid(columns, rows, [&](int i, int j) {
      const Vec3i lattice = face.origin.cwiseProduct(cells) + i * face.right + j * face.up;
      Vec3d position;
      for (int axis = 0; axis < 3; ++axis)
        position[axis] = step_between(half[axis], lattice[axis], cells[axis]);
      return Sample{position, face.outward().cast<double>(),
                    chart.uv(width * static_cast<double>(i) / static_cast<double>(columns),
                             height * static_cast<double>(j) / static_cast<double>(rows))};
    });
  }
  return builder.take();
}

// The disc that closes a tube: rings of vertices at about the edge length, joined like a zip.
class TubeCap {
 public:
  TubeCap(double radius, int segments, double edge_mm) : radius_(radius), segments_(segments) {
    ring_count_ = std::max(1, cells_along(radius, edge_mm));
  }

  // `y`: the cap's height; it faces +y if that is positive.
  void add_to(MeshBuilder& builder, double y, const Chart& chart) const {
    for (int ring = 0; ring < ring_count_; ++ring) add_band(builder, ring, y, chart);
  }

 private:
  // Ring 0 is the centre, the last one the tube's rim.
  int points_on(int ring) const {
    if (ring == 0) return 1;
    if (ring == ring_count_) return segments_;
    return std::max(6, static_cast<int>(std::lround(static_cast<double>(segments_) * ring / ring_count_)));
  }

  Sample sample(int ring, int point, double y, const Chart& chart) const {
    const int count = points_on(ring);
    const double angle = 2.0 * kPi * static_cast<double>(point % count) / static_cast<double>(count);
    const double r = radius_ * static_cast<double>(ring) / static_cast<double>(ring_count_);
    const double side = y > 0.0 ? 1.0 : -1.0;
    const Vec3d position(r * std::sin(angle), y, r * std::cos(angle));
    // Seen from outside, x is on the right, and z is down on top and up below.
    return {position, {0.0, side, 0.0}, chart.uv(position.x() + radius_, radius_ - side * position.z())};
  }

  // The triangles between a ring and the next: on whichever ring the next point comes first goes on.
  void add_band(MeshBuilder& builder, int ring, double y, const Chart& chart) const {
    const int inner_count = points_on(ring);
    const int outer_count = points_on(ring + 1);
    int inner = 0;
    int outer = 0;
    while (outer < outer_count || (inner_count > 1 && inner < inner_count)) {
      const Sample a = sample(ring, inner, y, chart);
      const Sample b = sample(ring + 1, outer, y, chart);
      // Compares the middles of the two candidate steps, which keeps the triangles upright.
      const long inner_middle = static_cast<long>(2 * inner + 1) * outer_count;
      const long outer_middle = static_cast<long>(2 * outer + 1) * inner_count;
      const bool inner_done = inner_count == 1 || inner == inner_count;
      if (outer < outer_count && (inner_done || outer_middle <= inner_middle)) {
        add_facing(builder, y, a, b, sample(ring + 1, ++outer, y, chart));
      } else {
        add_facing(builder, y, a, b, sample(ring, ++inner, y, chart));
      }
    }
  }

  // The angle runs counter-clockwise seen from above, so from below the triangles are turned round.
  static void add_facing(MeshBuilder& builder, double y, const Sample& a, const Sample& b, const Sample& c) {
    if (y > 0.0) {
      builder.add_triangle(a, b, c);
    } else {
      builder.add_triangle(a, c, b);
    }
  }

  double radius_;
  int segments_;
  int ring_count_ = 1;
};

// The side's chart is the unrolled prism, so it has no stretch at all; the caps lie above it.
Mesh make_tube(const BuiltinParameters& parameters) {
  const double radius = value_of(parameters, "radius_mm");
  const double length = value_of(parameters, "length_mm");
  const double edge = value_of(parameters, "edge_mm");
  const int segments = std::max(kFewestSegmentsAround, cells_along(2.0 * kPi * radius, edge));
  const int rows = cells_along(length, edge);
  const double chord = 2.0 * radius * std::sin(kPi / static_cast<double>(segments));
  const double around = chord * static_cast<double>(segments);

  const double scale =
      std::min((1.0 - 2.0 * kGutter) / around, (1.0 - 3.0 * kGutter) / (length + 2.0 * radius));
  const double caps_v = 2.0 * kGutter + scale * length;
  const double second_cap_u = 2.0 * kGutter + 2.0 * scale * radius;
  MeshBuilder builder;
  const Chart side{{kGutter, kGutter}, scale};
  builder.add_grid(segments, rows, [&](int i, int j) {
    const double angle = 2.0 * kPi * static_cast<double>(i % segments) / static_cast<double>(segments);
    const Vec3d normal(std::sin(angle), 0.0, std::cos(angle));
    const double y = step_between(0.5 * length, j, rows);
    return Sample{radius * normal + y * Vec3d::UnitY(), normal,
                  side.uv(chord * static_cast<double>(i), y + 0.5 * length)};
  });
  const TubeCap cap(radius, segments, edge);
  cap.add_to(builder, 0.5 * length, {{kGutter, caps_v}, scale});
  cap.add_to(builder, -0.5 * length, {{second_cap_u, caps_v}, scale});
  return builder.take();
}

constexpr std::string_view kEdgeHelp = "target length of the triangles' edges";

BuiltinParameter edge_parameter() { return {"edge_mm", 2.0, 0.05, 100.0, kEdgeHelp}; }
BuiltinParameter size_parameter() { return {"size_mm", 60.0, 1.0, 1000.0, "side of the square"}; }

const BuiltinScene& find_scene(std::string_view name, const SourceLocation& where) {
  std::vector<std::string_view> names;
  for (const BuiltinScene& scene : builtin_scenes()) {
    if (scene.name == name) return scene;
    names.push_back(scene.name);
  }
  throw_input_error(where, "\"{}\" is not a built-in scene: {}", name, fmt::join(names, ", "));
}

SourceLocation location_of(const BuiltinLocations& where, std::string_view parameter) {
  const auto found = where.parameters.find(std::string(parameter));
  return found != where.parameters.end() ? found->second : where.name;
}

void check_known(const BuiltinScene& scene, std::string_view parameter, const BuiltinLocations& where) {
  std::vector<std::string_view> names;
  for (const BuiltinParameter& known : scene.parameters) {
    if (known.name == parameter) return;
    names.push_back(known.name);
  }
  throw_input_error(location_of(where, parameter), "the scene \"{}\" has no parameter \"{}\": {}", scene.name,
                    parameter, fmt::join(names, ", "));
}

void check_range(const BuiltinScene& scene, const BuiltinParameter& parameter, double value,
                 const BuiltinLocations& where) {
  const bool in_range = value >= parameter.minimum && value <= parameter.maximum;  // false for NaN
  if (in_range && parameter.whole && value != std::floor(value)) {
    throw_input_error(location_of(where, parameter.name), "the scene \"{}\" has {} = {}: it must be whole",
                      scene.name, parameter.name, value);
  }
  if (in_range) return;
  throw_input_error(location_of(where, parameter.name), "the scene \"{}\" has {} = {}: it must be {} to {}",
                    scene.name, parameter.name, value, parameter.minimum, parameter.maximum);
}

}  // namespace

double expected_triangles(std::string_view name, const BuiltinParameters& p) {
  const double edge = value_of(p, "edge_mm");
  double area = 0.0;
  if (name == "head") area = kHeadArea_mm2;
  if (name == "sphere") area = 4.0 * kPi * std::pow(value_of(p, "radius_mm"), 2);
  if (name == "plane") area = value_of(p, "size_mm") * plane_length_mm(p);
  if (name == "wedge") area = std::pow(value_of(p, "size_mm"), 2);
  if (name == "cards") area = 1.5 * std::pow(value_of(p, "size_mm"), 2);
  if (name == "slab")
    area = 2.0 * value_of(p, "size_mm") * (value_of(p, "size_mm") + 2.0 * value_of(p, "thickness_mm"));
  if (name == "tube")
    area = 2.0 * kPi * value_of(p, "radius_mm") * (value_of(p, "length_mm") + value_of(p, "radius_mm"));
  return 2.0 * area / (edge * edge);
}

const std::vector<BuiltinScene>& builtin_scenes() {
  static const std::vector<BuiltinScene> scenes{
      {"head",
       "a bust, about 200 mm tall, looking along +z",
       {{"edge_mm", 2.5, 1.5, 6.0, kEdgeHelp}},
       [](const BuiltinParameters& parameters) { return make_head(value_of(parameters, "edge_mm")); },
       true},
      {"sphere",
       "a sphere around the origin, in six charts",
       {{"radius_mm", 25.0, 0.5, 500.0, "radius"}, edge_parameter()},
       make_sphere},
      {"plane",
       "a square or rectangle in the plane z = 0 facing +z",
       {size_parameter(),
        {"length_mm", 0.0, 0.0, 1000.0, "its height; 0: as its width"},
        {"uv_stretch", 1.0, 1.0, 64.0, "mm per unit of v over mm per unit of u"},
        {"charts", 1.0, 1.0, 32.0, "along each side; more than one are parted by seams", true},
        edge_parameter()},
       make_plane},
      {"wedge",
       "two half squares that meet in a hard edge along the y axis, its bisector along +z",
       {{"dihedral_deg", 90.0, 10.0, 350.0, "the solid's interior angle; above 180 the edge is concave"},
        size_parameter(),
        edge_parameter()},
       make_wedge},
      {"slab",
       "a closed box with hard edges, thin along z",
       {{"thickness_mm", 4.0, 0.1, 200.0, "from the front at z = +thickness/2 to the back"},
        size_parameter(),
        edge_parameter()},
       make_slab},
      {"tube",
       "a closed cylinder along the y axis, its side in one chart with a seam",
       {{"radius_mm", 10.0, 0.1, 500.0, "radius"},
        {"length_mm", 80.0, 1.0, 1000.0, "from cap to cap"},
        edge_parameter()},
       make_tube},
      {"cards",
       "a square, and in front of its left half another surface facing the same way",
       {{"gap_mm", 20.0, 0.1, 1000.0, "from the back at z = -gap/2 to the front at z = +gap/2"},
        size_parameter(),
        edge_parameter()},
       make_cards},
  };
  return scenes;
}

bool is_sculpted(std::string_view name) { return find_scene(name, {}).sculpted; }

BuiltinParameters complete_parameters(std::string_view name, const BuiltinParameters& given,
                                      const BuiltinLocations& where) {
  const BuiltinScene& scene = find_scene(name, where.name);
  for (const auto& [parameter, value] : given) check_known(scene, parameter, where);
  BuiltinParameters complete = given;
  for (const BuiltinParameter& parameter : scene.parameters) {
    const double value =
        complete.try_emplace(std::string(parameter.name), parameter.default_value).first->second;
    check_range(scene, parameter, value, where);
  }
  if (const double triangles = expected_triangles(name, complete); triangles > kMostTriangles) {
    throw_input_error(location_of(where, "edge_mm"),
                      "the scene \"{}\" has edge_mm = {}: about {:.2g} triangles, and {:.2g} is the most",
                      scene.name, value_of(complete, "edge_mm"), triangles, kMostTriangles);
  }
  return complete;
}

Mesh make_builtin(std::string_view name, const BuiltinParameters& parameters, const BuiltinLocations& where) {
  const BuiltinParameters complete = complete_parameters(name, parameters, where);
  return find_scene(name, where.name).generate(complete);
}

}  // namespace truescatter
