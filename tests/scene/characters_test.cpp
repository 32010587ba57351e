#include "scene/characters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "scene/builtin.h"

namespace truescatter {
namespace {

TEST(Characters, AreCopiesThatShareNoVertex) {
  const Mesh one = make_builtin("cards", {{"gap_mm", 5.0}});
  // The second stands where the first does, and is one of its own all the same.
  const std::vector<CharacterPlace> places = {{}, {}, {Vec3d(10.0, 20.0, 30.0), 90.0}};
  const Mesh all = place_characters(one, places);
  EXPECT_EQ(all.characters, 3U);
  ASSERT_EQ(all.triangle_count(), 3 * one.triangle_count());
  ASSERT_EQ(all.positions_mm.size(), 3 * one.positions_mm.size());
  for (std::size_t t = 0; t < all.triangle_count(); ++t) {
    const std::size_t of_one = t % one.triangle_count();
    const std::size_t character = t / one.triangle_count();
    EXPECT_EQ(all.character_of(t), character);
    EXPECT_EQ((*all.corner_uvs)[t], (*one.corner_uvs)[of_one]);
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const Vec3d p = one.corner(of_one, c);
      const Vec3d n = one.corner_normals[of_one][i];
      if (character < 2) {
        EXPECT_EQ(all.corner(t, c), p);
        EXPECT_EQ(all.corner_normals[t][i], n);
      } else {
        // A quarter turn about +y takes +z to +x, and +x to -z.
        EXPECT_LT((all.corner(t, c) - Vec3d(p.z() + 10.0, p.y() + 20.0, 30.0 - p.x())).norm(), 1e-12);
        EXPECT_LT((all.corner_normals[t][i] - Vec3d(n.z(), n.y(), -n.x())).norm(), 1e-15);
      }
    }
  }
  const auto components = [](const Mesh& mesh) {
    const std::vector<int> labels = label_components(
        mesh.triangle_count(), [&](std::size_t t) { return mesh.triangles[t]; },
        [](std::size_t) { return true; });
    return 1 + *std::max_element(labels.begin(), labels.end());
  };
  EXPECT_EQ(components(one), 2);
  EXPECT_EQ(components(all), 6);
}

}  // namespace
}  // namespace truescatter
