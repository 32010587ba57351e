#include "experiment/builtin_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"

namespace truescatter {
namespace {

// Numbers in a row, as many as four at a time.
class Numbers {
 public:
  void put(double value) { numbers_.push_back(value); }
  template <typename Vector>
  void put_vector(const Vector& vector) {
    numbers_.insert(numbers_.end(), vector.data(), vector.data() + vector.size());
  }
  std::vector<Vec4d> values() && {
    numbers_.resize((numbers_.size() + 3) / 4 * 4, 0.0);
    std::vector<Vec4d> values;
    for (std::size_t i = 0; i < numbers_.size(); i += 4) values.emplace_back(&numbers_[i]);
    return values;
  }

 private:
  std::vector<double> numbers_;
};

class NumberReader {
 public:
  explicit NumberReader(const std::vector<Vec4d>& values)
      : numbers_(values.empty() ? nullptr : values.front().data(), 4 * values.size()) {}

  double take() { return take(1).front(); }
  std::size_t take_count() { return static_cast<std::size_t>(take()); }
  template <typename Vector>
  Vector take_vector() {
    return Vector(take(Vector::SizeAtCompileTime).data());
  }
  bool has(std::size_t count) const { return count <= numbers_.size() && next_ <= numbers_.size() - count; }

 private:
  std::span<const double> take(std::size_t count) {
    if (!has(count)) throw_run_error("a kept mesh ends too early");
    next_ += count;
    return numbers_.subspan(next_ - count, count);
  }

  std::span<const double> numbers_;
  std::size_t next_ = 0;
};

std::string content_of(std::string_view name, const BuiltinParameters& parameters) {
  std::string content = fmt::format("builtin {}", name);
  for (const auto& [parameter, value] : parameters) content += fmt::format(" {} {:a}", parameter, value);
  return content;
}

}  // namespace

std::vector<Vec4d> values_of_mesh(const Mesh& mesh) {
  Numbers numbers;
  for (const std::size_t count : {mesh.positions_mm.size(), mesh.triangles.size(), mesh.characters,
                                  std::size_t{mesh.has_uvs() ? 1U : 0U}})
    numbers.put(static_cast<double>(count));
  for (const Vec3d& position : mesh.positions_mm) numbers.put_vector(position);
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    for (const int vertex : triangle) numbers.put(vertex);
  }
  for (const std::array<Vec3d, 3>& normals : mesh.corner_normals) {
    for (const Vec3d& normal : normals) numbers.put_vector(normal);
  }
  if (mesh.has_uvs()) {
    for (const std::array<Vec2d, 3>& uvs : *mesh.corner_uvs) {
      for (const Vec2d& uv : uvs) numbers.put_vector(uv);
    }
  }
  return std::move(numbers).values();
}

Mesh mesh_of_values(const std::vector<Vec4d>& values) {
  NumberReader reader(values);
  const std::size_t vertices = reader.take_count();
  const std::size_t triangles = reader.take_count();
  Mesh mesh;
  mesh.characters = reader.take_count();
  const bool has_uvs = reader.take_count() != 0;
  if (!reader.has(3 * vertices) || !reader.has(12 * triangles))
    throw_run_error("a kept mesh is shorter than it says");
  mesh.positions_mm.resize(vertices);
  for (Vec3d& position : mesh.positions_mm) position = reader.take_vector<Vec3d>();
  mesh.triangles.resize(triangles);
  for (std::array<int, 3>& triangle : mesh.triangles) {
    for (int& vertex : triangle) vertex = static_cast<int>(reader.take());
  }
  mesh.corner_normals.resize(triangles);
  for (std::array<Vec3d, 3>& normals : mesh.corner_normals) {
    for (Vec3d& normal : normals) normal = reader.take_vector<Vec3d>();
  }
  if (!has_uvs) return mesh;
  mesh.corner_uvs.emplace(triangles);
  for (std::array<Vec2d, 3>& uvs : *mesh.corner_uvs) {
    for (Vec2d& uv : uvs) uv = reader.take_vector<Vec2d>();
  }
  return mesh;
}

Mesh builtin_mesh(std::string_view name, const BuiltinParameters& given, const BuiltinLocations& where,
                  const KeptValues& kept) {
  const BuiltinParameters parameters = complete_parameters(name, given, where);
  if (!kept.are_kept() || !is_sculpted(name)) return make_builtin(name, parameters, where);
  return mesh_of_values(kept.values(content_of(name, parameters), std::nullopt,
                                    [&] { return values_of_mesh(make_builtin(name, parameters, where)); })
                            .values);
}

}  // namespace truescatter
