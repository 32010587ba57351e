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
  // The same for |x.e - c| L(x), a kink along a line that crosses the triangle: the largest, and the root
  // mean square over the shapes and the places of the line (for the worst L), or a quarter of the largest if
  // that is more: four deviations are never exceeded. Over all c the errors' mean is 0, for the integral of
  // |u - c| over c is quadratic in u.
  double kink_error;
  double kink_rms;
  std::span<const TriangleNode> nodes;
};

// Moments of the Gaussian's derivatives beyond a distance, as TriangleRule errors need them:
// magnitude[k] = E[ |He_k(Z_1)| / sqrt(k!) ; |Z| > c ] for a normal Z of two dimensions. At most 1.
struct HermiteMoments {
  explicit HermiteMoments(double beyond_std_devs);
  std::array<double, kTaylorOrders> magnitude;
};

// What `rule` can err by, of the largest irradiance, when it integrates G(s) I over the triangles of a plane
// that lie beyond the moments' distance and whose corners lie within x standard deviations of their
// centroids. G around a centroid is its Taylor series, sum_k |x|^k D_e^k G / k!, so a triangle of area A errs
// by at most A x^k s^k |D_e^k G| errors[k] / k! at order k, exact below k = degree. Summed over the plane,
// that is at most
//
//   sum over k >= degree of (pi/2) errors[k] magnitude[k] x^k / sqrt(k!);
//
// pi/2, the crest of |sin| over its mean, allows for centroids that meet the oscillating derivative's crests.
double gaussian_error(const TriangleRule& rule, const HermiteMoments& moments, double radius_in_std_devs);

// The rules that there are, ascending: degrees 2, 4, 5, 6, 8, 10, 12 with 3, 6, 7, 12, 16, 25, 33 nodes.
std::span<const TriangleRule> triangle_rules();

}  // namespace truescatter
