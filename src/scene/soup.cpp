#include "scene/soup.h"

#include <cstddef>

namespace truescatter {
namespace {

Vec3d position(const Soup& soup, const SoupCorner& corner) {
  return soup.positions[static_cast<std::size_t>(corner.position)];
}

// Newell's normal: twice the polygon's area vector, also for a polygon that is not quite planar.
Vec3d area_vector(const Soup& soup, const std::vector<SoupCorner>& corners) {
  Vec3d sum = Vec3d::Zero();
  const Vec3d origin = position(soup, corners.front());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3d a = position(soup, corners[i]) - origin;
    const Vec3d b = position(soup, corners[(i + 1) % corners.size()]) - origin;
    sum += a.cross(b);
  }
  return sum;
}

// Is the polygon's corner `i` convex, with no other corner in the triangle that it makes with its neighbours?
bool is_ear(const Soup& soup, const std::vector<SoupCorner>& polygon, std::size_t i, const Vec3d& normal) {
  const std::size_t count = polygon.size();
  const std::size_t before = (i + count - 1) % count;
  const std::size_t after = (i + 1) % count;
  const Vec3d a = position(soup, polygon[before]);
  const Vec3d b = position(soup, polygon[i]);
  const Vec3d c = position(soup, polygon[after]);
  const auto side = [&normal](const Vec3d& from, const Vec3d& to, const Vec3d& point) {
    return (to - from).cross(point - from).dot(normal);
  };
  if (side(a, b, c) <= 0.0) return false;
  for (std::size_t j = 0; j < count; ++j) {
    if (j == before || j == i || j == after) continue;
    const Vec3d p = position(soup, polygon[j]);
    // A polygon with a hole walks along a bridge twice: its corners touch the ear without being inside.
    if (p == a || p == b || p == c) continue;
    if (side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0) return false;
  }
  return true;
}

}  // namespace

void Soup::add_face(int face, const std::vector<SoupCorner>& corners) {
  std::vector<SoupCorner> rest = corners;
  const Vec3d normal = area_vector(*this, corners);
  while (rest.size() > 3) {
    // Starting at the second corner makes convex polygons fans; where there is no ear (a polygon that
    // crosses itself), that corner is cut off all the same.
    std::size_t ear = 1;
    for (std::size_t step = 0; step < rest.size(); ++step) {
      const std::size_t candidate = (1 + step) % rest.size();
      if (is_ear(*this, rest, candidate, normal)) {
        ear = candidate;
        break;
      }
    }
    const std::size_t before = (ear + rest.size() - 1) % rest.size();
    const std::size_t after = (ear + 1) % rest.size();
    triangles.push_back({rest[before], rest[ear], rest[after]});
    face_of_triangle.push_back(face);
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({rest[0], rest[1], rest[2]});
  face_of_triangle.push_back(face);
}

}  // namespace truescatter
