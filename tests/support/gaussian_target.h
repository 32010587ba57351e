#pragma once

#include <cmath>
#include <vector>

#include "profile/fit_norms.h"
#include "profile/fit_target.h"

namespace truescatter::test {

// A profile that is a sum of Gaussians itself, of one channel.
struct GaussianSum {
  std::vector<WeightedGaussian> gaussians;

  double value(double r_mm) const { return sum_value(gaussians, r_mm); }
  double antiderivative(double r_mm) const { return sum_antiderivative(gaussians, r_mm); }
  double albedo() const {
    double sum = 0.0;
    for (const WeightedGaussian& g : gaussians) sum += g.weight;
    return sum;
  }
  double shortest_length_mm() const {
    double shortest = gaussians.front().variance_mm2;
    for (const WeightedGaussian& g : gaussians) shortest = std::min(shortest, g.variance_mm2);
    return std::sqrt(shortest);
  }
};

inline FitTarget gaussian_target(std::vector<WeightedGaussian> gaussians) {
  return fit_target(GaussianSum{std::move(gaussians)});
}

}  // namespace truescatter::test
