#pragma once

#include <array>
#include <span>

#include "core/vec.h"

namespace truescatter {

// A node of a quadrature rule on a triangle: barycentric coordinates, and a weight; weights sum to 1.
struct TriangleNode {
  Vec3d barycentric;
  double weight;
};

// Orders of a Taylor series that are looked at: at 3 standard deviations, the widest that any rule is used
// at, x^k / sqrt(k!) has fallen to 1e-7 there.
inline constexpr std::size_t kTaylorOrders = 48;

// A symmetric rule that integrates polynomials up to `degree` exactly, with positive weights and all nodes
// inside (Strang & Fix 1973, Dunavant 1985; the others solved for from the moment equations, to 40 digits).
struct TriangleRule {
  int degree;
  // errors[k]: the largest error of the rule's mean of (x.e)^k L(x) over any triangle whose corners lie
  // within 1 of its centroid (the origin), any direction e and any linear L with values in [0, 1]. In
  // barycentric coordinates x.e is sum_i c_i lambda_i with sum_i c_i = 0 and |c_i| <= 1, so the shapes are
  // one family, c = (1, t, -1-t), and extreme L are 1, lambda_i and 1 - lambda_i.
  std::array<double, kTaylorOrders> errors;
  std::span<const TriangleNode> nodes;

  // What the rule can err by, of the largest irradiance, when it integrates G(s) I over a plane of triangles
  // whose corners lie within x standard deviations of their centroids. G around a centroid is its Taylor
  // series, sum_k |x|^k D_e^k G / k!, so a triangle of area A errs by at most A x^k s^k |D_e^k G| errors[k] /
  // k! at order k, exact below k = degree. Summed over the plane, s^k integral |D_e^k G| = E|He_k| <=
  // sqrt(k!), and the total is at most sum over k >= degree of errors[k] x^k / sqrt(k!).
  double gaussian_error(double radius_in_std_devs) const;
};

// The rules that there are, ascending: degrees 2, 4, 5, 6, 8, 10, 12 with 3, 6, 7, 12, 16, 25, 33 nodes.
std::span<const TriangleRule> triangle_rules();

}  // namespace truescatter
