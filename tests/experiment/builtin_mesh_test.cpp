// Generated meshes that the cache keeps.
#include "experiment/builtin_mesh.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

void expect_same(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.positions_mm, b.positions_mm);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.corner_normals, b.corner_normals);
  EXPECT_EQ(a.corner_uvs, b.corner_uvs);
  EXPECT_EQ(a.characters, b.characters);
}

TEST(MeshValues, GiveTheMeshBack) {
  Mesh mesh = make_builtin("wedge");
  mesh.positions_mm.front() = Vec3d(-0.0, 1.0 / 3.0, 5e-324);
  mesh.characters = 2;
  expect_same(mesh_of_values(values_of_mesh(mesh)), mesh);
  mesh.corner_uvs.reset();
  expect_same(mesh_of_values(values_of_mesh(mesh)), mesh);
}

TEST(MeshValues, AreRefusedWhereTheyEndTooEarly) {
  const std::vector<Vec4d> values = values_of_mesh(make_builtin("wedge"));
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, values.size() / 2, values.size() - 1})
    EXPECT_THROW(mesh_of_values({values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count)}), Error)
        << count;
}

TEST(BuiltinMesh, IsSculptedOnce) {
  const TempDir folder;
  const BuiltinParameters coarse = {{"edge_mm", 6.0}};
  const auto head = [&](const std::string& program, const BuiltinParameters& parameters) {
    TruthCache cache(folder.path(), 1 << 28);
    const Mesh mesh = builtin_mesh("head", parameters, {}, {&cache, program});
    return std::pair(mesh, cache.stored_count());
  };
  const auto [made, stored] = head("program", coarse);
  EXPECT_EQ(stored, 1U);
  const auto [kept, stored_again] = head("program", coarse);
  EXPECT_EQ(stored_again, 0U);
  expect_same(kept, made);
  const auto [finer, stored_too] = head("program", {{"edge_mm", 5.9}});
  EXPECT_EQ(stored_too, 1U);
  EXPECT_GT(finer.triangle_count(), made.triangle_count());
}

TEST(BuiltinMesh, IsNotKeptWhereItIsMadeAtOnce) {
  const TempDir folder;
  TruthCache cache(folder.path(), 1 << 28);
  const KeptValues kept(&cache, "program");
  expect_same(builtin_mesh("wedge", {}, {}, kept), make_builtin("wedge"));
  EXPECT_TRUE(folder.names().empty());
  EXPECT_THROW(builtin_mesh("head", {{"edge_mm", 0.0}}, {}, kept), Error);
  EXPECT_THROW(builtin_mesh("no such scene", {}, {}, kept), Error);
}

}  // namespace
}  // namespace truescatter::test
