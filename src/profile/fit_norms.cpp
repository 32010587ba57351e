#include "profile/fit_norms.h"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "core/error.h"
#include "core/vec.h"

namespace truescatter {
namespace {

// Beyond what the trapezoid rule needs: zeros of R - S must not fall in pairs between nodes.
constexpr double kNormNodesPerUnit = 64.0;
constexpr int kGaussNodes = 8;

using GaussRule = boost::math::quadrature::gauss<double, kGaussNodes>;

void append_gauss(double from_mm, double to_mm, std::vector<RadialNode>& nodes) {
  const double middle = 0.5 * (from_mm + to_mm);
  const double half = 0.5 * (to_mm - from_mm);
  const auto& abscissas = GaussRule::abscissa();
  const auto& weights = GaussRule::weights();
  for (std::size_t i = abscissas.size(); i-- > 0;)
    nodes.push_back({middle - half * abscissas[i], half * weights[i]});
  for (std::size_t i = 0; i < abscissas.size(); ++i)
    nodes.push_back({middle + half * abscissas[i], half * weights[i]});
}

std::vector<RadialNode> nodes_between_breaks(const FitTarget& target) {
  std::vector<RadialNode> nodes;
  double from_mm = target.r_min_mm;
  for (const double break_mm : target.breaks_mm) {
    if (break_mm <= from_mm) continue;
    append_gauss(from_mm, std::min(break_mm, target.r_max_mm), nodes);
    from_mm = break_mm;
    if (from_mm >= target.r_max_mm) return nodes;
  }
  append_gauss(from_mm, target.r_max_mm, nodes);
  return nodes;
}

double power(double r_mm, FitNorm norm) { return norm == FitNorm::r ? r_mm : r_mm * r_mm; }

}  // namespace

std::string_view name_of(FitNorm norm) {
  switch (norm) {
    case FitNorm::r:
      return "r";
    case FitNorm::area:
      return "area";
    case FitNorm::r2:
      return "r2";
  }
  return {};
}

std::optional<FitNorm> find_norm(std::string_view name) {
  for (const FitNorm norm : kFitNorms)
    if (name_of(norm) == name) return norm;
  return std::nullopt;
}

void require_finite(FitNorm norm, const FitTarget& target) {
  if (norm == FitNorm::r && !target.square_integrable)
    throw_input_error({}, "the norm r is not finite for a profile that goes as 1/r at 0: use area or r2");
}

double sum_value(std::span<const WeightedGaussian> sum, double r_mm) {
  double value = 0.0;
  for (const WeightedGaussian& g : sum)
    value += g.weight * std::exp(-0.5 * r_mm * r_mm / g.variance_mm2) / (2.0 * kPi * g.variance_mm2);
  return value;
}

double sum_antiderivative(std::span<const WeightedGaussian> sum, double r_mm) {
  double value = 0.0;
  for (const WeightedGaussian& g : sum)
    value -= g.weight * std::exp(-0.5 * r_mm * r_mm / g.variance_mm2) / (2.0 * kPi);
  return value;
}

std::vector<RadialNode> radial_nodes(const FitTarget& target, double per_unit) {
  assert(target.r_max_mm > target.r_min_mm);
  if (!target.breaks_mm.empty()) return nodes_between_breaks(target);
  const double length = std::log(target.r_max_mm / target.r_min_mm);
  const int steps = static_cast<int>(std::ceil(length * per_unit));
  const double step = length / steps;
  std::vector<RadialNode> nodes;
  for (int i = 0; i <= steps; ++i) {
    const double radius_mm = target.r_min_mm * std::exp(i * step);
    nodes.push_back({radius_mm, radius_mm * step * (i == 0 || i == steps ? 0.5 : 1.0)});
  }
  return nodes;
}

std::vector<double> stretches_of_one_sign(const FitTarget& target, std::span<const RadialNode> nodes,
                                          const std::function<double(double)>& function) {
  std::vector<double> ends = {0.0};
  double last_radius = nodes.front().radius_mm;
  double last_value = function(last_radius);
  for (const RadialNode& node : nodes) {
    const double here = function(node.radius_mm);
    if ((here < 0.0) != (last_value < 0.0)) {
      std::uintmax_t steps = 100;
      const auto [low, high] =
          boost::math::tools::toms748_solve(function, last_radius, node.radius_mm, last_value, here,
                                            boost::math::tools::eps_tolerance<double>(48), steps);
      ends.push_back(0.5 * (low + high));
    }
    last_radius = node.radius_mm;
    last_value = here;
  }
  ends.push_back(target.r_max_mm);
  return ends;
}

double absolute_light(const FitTarget& target, std::span<const RadialNode> nodes) {
  const std::vector<double> ends = stretches_of_one_sign(target, nodes, target.value);
  double light = std::abs(target.antiderivative(ends.back()));
  for (std::size_t i = 1; i < ends.size(); ++i)
    light += std::abs(target.antiderivative(ends[i]) - target.antiderivative(ends[i - 1]));
  return light;
}

std::optional<double> FitErrors::in(FitNorm norm) const {
  if (norm == FitNorm::r) return r;
  return norm == FitNorm::area ? area : r2;
}

FitErrors fit_errors(const FitTarget& target, std::span<const WeightedGaussian> sum) {
  const std::vector<RadialNode> nodes = radial_nodes(target, kNormNodesPerUnit);
  const auto quadratic = [&](FitNorm norm) {
    double error = 0.0;
    double whole = 0.0;
    for (const RadialNode& node : nodes) {
      const double weight = node.weight_mm * power(node.radius_mm, norm);
      const double value = target.value(node.radius_mm);
      const double off = value - sum_value(sum, node.radius_mm);
      error += weight * off * off;
      whole += weight * value * value;
    }
    return std::sqrt(error / whole);
  };
  FitErrors errors;
  if (target.square_integrable) errors.r = quadratic(FitNorm::r);
  errors.r2 = quadratic(FitNorm::r2);
  FitTarget off = target;
  off.value = [&](double r_mm) { return target.value(r_mm) - sum_value(sum, r_mm); };
  off.antiderivative = [&](double r_mm) {
    return target.antiderivative(r_mm) - sum_antiderivative(sum, r_mm);
  };
  errors.area = absolute_light(off, nodes) / absolute_light(target, nodes);
  return errors;
}

}  // namespace truescatter
