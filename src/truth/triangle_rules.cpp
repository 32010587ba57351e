#include "truth/triangle_rules.h"

#include <array>
#include <cmath>
#include <vector>

namespace truescatter {
namespace {

// The orbits of the triangle's symmetry group: the centroid, (1 - 2a, a, a), (1 - a - b, a, b).
void add_centroid(std::vector<TriangleNode>& nodes, double weight) {
  nodes.push_back({Vec3d::Constant(1.0 / 3.0), weight});
}

void add_orbit3(std::vector<TriangleNode>& nodes, double a, double weight) {
  for (int i = 0; i < 3; ++i) {
    Vec3d barycentric = Vec3d::Constant(a);
    barycentric[i] = 1.0 - 2.0 * a;
    nodes.push_back({barycentric, weight});
  }
}

void add_orbit6(std::vector<TriangleNode>& nodes, double a, double b, double weight) {
  const double c = 1.0 - a - b;
  for (const Vec3d& barycentric :
       {Vec3d(a, b, c), Vec3d(b, c, a), Vec3d(c, a, b), Vec3d(a, c, b), Vec3d(c, b, a), Vec3d(b, a, c)}) {
    nodes.push_back({barycentric, weight});
  }
}

std::vector<TriangleNode> degree2() {
  std::vector<TriangleNode> nodes;
  add_orbit3(nodes, 1.0 / 6.0, 1.0 / 3.0);
  return nodes;
}

std::vector<TriangleNode> degree4() {
  std::vector<TriangleNode> nodes;
  add_orbit3(nodes, 0.445948490915965, 0.223381589678011);
  add_orbit3(nodes, 0.091576213509771, 0.109951743655322);
  return nodes;
}

std::vector<TriangleNode> degree5() {
  const double root = std::sqrt(15.0);
  std::vector<TriangleNode> nodes;
  add_centroid(nodes, 9.0 / 40.0);
  add_orbit3(nodes, (6.0 - root) / 21.0, (155.0 - root) / 1200.0);
  add_orbit3(nodes, (6.0 + root) / 21.0, (155.0 + root) / 1200.0);
  return nodes;
}

std::vector<TriangleNode> degree8() {
  std::vector<TriangleNode> nodes;
  add_centroid(nodes, 0.144315607677787);
  add_orbit3(nodes, 0.459292588292723, 0.095091634267285);
  add_orbit3(nodes, 0.170569307751760, 0.103217370534718);
  add_orbit3(nodes, 0.050547228317031, 0.032458497623198);
  add_orbit6(nodes, 0.263112829634638, 0.008394777409958, 0.027230314174435);
  return nodes;
}

}  // namespace

std::span<const TriangleRule> triangle_rules() {
  static const std::array<std::vector<TriangleNode>, 4> nodes = {degree2(), degree4(), degree5(), degree8()};
  static const std::array<TriangleRule, 4> rules = {
      TriangleRule{2, 0.4999, nodes[0]}, TriangleRule{4, 0.1999, nodes[1]}, TriangleRule{5, 0.1365, nodes[2]},
      TriangleRule{8, 0.0628, nodes[3]}};
  return rules;
}

}  // namespace truescatter
