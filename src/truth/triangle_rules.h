#pragma once

#include <span>

#include "core/vec.h"

namespace truescatter {

// A node of a quadrature rule on a triangle: barycentric coordinates, and a weight; weights sum to 1.
struct TriangleNode {
  Vec3d barycentric;
  double weight;
};

// A symmetric rule that integrates polynomials up to `degree` exactly (Strang & Fix 1973, Dunavant 1985),
// with positive weights and all nodes inside.
struct TriangleRule {
  int degree;
  // With rho = distance from the centroid over the farthest corner's: the rule's sum plus the exact mean of
  // rho^degree, for the equilateral triangle, which has the largest of any shape. It bounds the error of
  // integrating a remainder of at most rho^degree.
  double remainder;
  std::span<const TriangleNode> nodes;
};

// The rules that there are, ascending: degrees 2, 4, 5, 8 with 3, 6, 7, 16 nodes.
std::span<const TriangleRule> triangle_rules();

}  // namespace truescatter
