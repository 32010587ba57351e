#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "profile/fit_target.h"

namespace truescatter {

// The relative errors of a sum of Gaussians S against a profile R, the quadratic ones over the target's
// domain:
//
//   r     sqrt(int r (R - S)^2 dr / int r R^2 dr)         as d'Eon & Luebke 2007 state theirs; not finite for
//                                                         a profile that goes as 1/r at 0
//   area  int |R - S| 2 pi r dr / int |R| 2 pi r dr       over all radii: times the albedo it bounds the
//   error
//                                                         of convolving any irradiance in [0, 1] on a plane
//   r2    sqrt(int r^2 (R - S)^2 dr / int r^2 R^2 dr)     the tail weighs more
enum class FitNorm { r, area, r2 };

inline constexpr FitNorm kFitNorms[] = {FitNorm::r, FitNorm::area, FitNorm::r2};

// "r", "area", "r2".
std::string_view name_of(FitNorm norm);
// Nothing for another name.
std::optional<FitNorm> find_norm(std::string_view name);

// Throws Error (input) where the norm is not finite for the target.
void require_finite(FitNorm norm, const FitTarget& target);

// w_i G(v_i, r) of one channel.
struct WeightedGaussian {
  double variance_mm2;
  double weight;
};

// sum w_i G(v_i, r), in 1/mm^2, and F with F' = r S.
double sum_value(std::span<const WeightedGaussian> sum, double r_mm);
double sum_antiderivative(std::span<const WeightedGaussian> sum, double r_mm);

// A quadrature rule over the target's domain: int g dr = sum weight_mm g(radius_mm). In log r, in which a
// profile and its Gaussians are analytic for |Im log r| < pi/4, the trapezoid rule of `per_unit` nodes a unit
// of log r errs by exp(-pi^2 / 2 per_unit): 1e-13 at 6. Between breaks, Gauss's rule of 8 nodes.
struct RadialNode {
  double radius_mm;
  double weight_mm;
};
std::vector<RadialNode> radial_nodes(const FitTarget& target, double per_unit);

// 0, the zeros of a function that part neighbouring nodes, and r_max_mm. (Within the first node and beyond
// r_max_mm lie less light than tolerances, or a table's constant and nothing: no sign changes there.)
std::vector<double> stretches_of_one_sign(const FitTarget& target, std::span<const RadialNode> nodes,
                                          const std::function<double(double)>& function);

// int |R| r dr over all radii, by the antiderivative between the zeros of R, which is 0 at infinity.
double absolute_light(const FitTarget& target, std::span<const RadialNode> nodes);

struct FitErrors {
  std::optional<double> r;  // nothing: the norm is not finite
  double area = 0.0;
  double r2 = 0.0;

  std::optional<double> in(FitNorm norm) const;
};

// In every norm. The quadratic ones by radial_nodes; `area` exactly: R - S is integrated by its
// antiderivative between the zeros that lie between neighbouring nodes.
FitErrors fit_errors(const FitTarget& target, std::span<const WeightedGaussian> sum);

}  // namespace truescatter
