#pragma once

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

#include "core/vec.h"

namespace truescatter {

// What a quadrature found, and by how much its rules differed, summed: a bound on the coarser one's error.
struct Quadrature {
  Vec4d value = Vec4d::Zero();
  Vec4d difference = Vec4d::Zero();
  bool converged = true;

  Quadrature& operator+=(const Quadrature& other) {
    value += other.value;
    difference += other.difference;
    converged = converged && other.converged;
    return *this;
  }
};

// int_from^to integrand(x) dx by Gauss-Kronrod with 7 and 15 nodes, halved until the two differ by at most
// `allowed` in each entry (or by the rounding of the value), `depth` times at most.
template <typename Integrand>
Quadrature integrate_adaptively(const Integrand& integrand, double from, double to, const Vec4d& allowed,
                                int depth) {
  using Kronrod = boost::math::quadrature::gauss_kronrod<double, 15>;
  using Gauss = boost::math::quadrature::gauss<double, 7>;
  const auto& nodes = Kronrod::abscissa();
  const auto& weights = Kronrod::weights();
  const auto& gauss_weights = Gauss::weights();
  const double middle = 0.5 * (from + to);
  const double half = 0.5 * (to - from);
  Vec4d fine = weights[0] * integrand(middle);
  Vec4d coarse = fine * (gauss_weights[0] / weights[0]);
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const Vec4d pair = integrand(middle - half * nodes[i]) + integrand(middle + half * nodes[i]);
    fine += weights[i] * pair;
    if (i % 2 == 0) coarse += gauss_weights[i / 2] * pair;
  }
  Quadrature result{fine * half, ((fine - coarse) * half).cwiseAbs()};
  const Vec4d rounding = 1e-14 * result.value.cwiseAbs();
  if ((result.difference.array() <= (allowed + rounding).array()).all()) return result;
  if (depth <= 0) {
    result.converged = false;
    return result;
  }
  result = integrate_adaptively(integrand, from, middle, allowed, depth - 1);
  result += integrate_adaptively(integrand, middle, to, allowed, depth - 1);
  return result;
}

}  // namespace truescatter
