#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// A weighted point of the surface: what a quadrature node gives. Weights are area times R, G, B, 1.
struct GaussSource {
  Vec3d position_mm;
  Vec4d weight;
};

// sum_j w_j G(s, |x_i - y_j|) at all points x_i at once, by way of a grid; the cost is one visit per source
// and one per point, whatever s and however many sources lie within its reach.
//
// A Gaussian is the convolution of two narrower ones, and its integral is, to a very small error, a sum over
// any lattice that is finer than they are (the trapezoidal rule):
//
//   G3(s, x - y) = h^3 sum_u G3(s/sqrt 2, x - u) G3(s/sqrt 2, u - y),      u in h Z^3,
//
// with G3 the Gaussian of three dimensions, sqrt(2 pi) s G3(s, r) = G(s, r). So the sources are spread onto
// the lattice and the points gather from it; both kernels are products over the axes, and a bundle of sources
// or points that share their lattice points is one matrix product.
//
// Errors, relative to the largest irradiance:
// - Aliasing. The product of the two Gaussians is one of variance s^2/4 in u, and the lattice sum of such a
//   Gaussian differs from its integral by a factor within 2 exp(-2 pi^2 (s^2/4) / h^2) per axis (Poisson's
//   sum formula). So each pair's kernel is off by a factor within 6.1 exp(-pi^2 s^2 / 2h^2): `budget` / 2.
// - Reach. Lattice points farther than rho along an axis from a point or a source are left out of its sum.
// For
//   a source on a plane through x, u - x along an axis is Gaussian of variance at most s^2/4 + s^2/4, as is
//   u - y, so the mass left out is at most 6 erfc(rho / s): `budget` / 2.
struct GaussLattice {
  double step_mm = 0.0;   // h
  double reach_mm = 0.0;  // rho
  int span = 0;           // blocks per axis that hold all lattice points in reach of a point

  GaussLattice(double std_dev_mm, double budget);
};

// Lattice points per block and axis.
inline constexpr int kGaussBlock = 4;

// Adds the sums to out[i] for points[i]. `gray`: the first three weights are equal, so that two channels are
// enough. Runs in Scalar (float or double); bitwise the same for any number of jobs.
template <typename Scalar>
void add_gauss_sums(const GaussLattice& lattice, double std_dev_mm, std::span<const GaussSource> sources,
                    std::span<const Vec3d> points, bool gray, std::span<Vec4d> out);

extern template void add_gauss_sums<float>(const GaussLattice&, double, std::span<const GaussSource>,
                                           std::span<const Vec3d>, bool, std::span<Vec4d>);
extern template void add_gauss_sums<double>(const GaussLattice&, double, std::span<const GaussSource>,
                                            std::span<const Vec3d>, bool, std::span<Vec4d>);

}  // namespace truescatter
