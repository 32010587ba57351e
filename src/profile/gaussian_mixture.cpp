#include "profile/gaussian_mixture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>

#include "core/error.h"

namespace truescatter {
namespace {

constexpr double kSmallestTolerance = 1e-12;
constexpr double kLargestTolerance = 0.1;
constexpr double kStepShare = 0.5;  // of the tolerance; what is left out has a quarter at either end
constexpr double kEndShare = 0.25;
constexpr double kUnderflow = 750.0;  // exp(-750) = 0
constexpr double kRounding = 1e-14;   // of the sum of |weights|

// The bound on N(a) for c = cos 2a.
double norm_on_line(const ImageSources& sources, double c) {
  const double s = sources.s_tr_per_mm();
  const double strength =
      sources.flux() + (sources.fluence_per_mm() == 0.0 ? 0.0 : sources.fluence_per_mm() / s);
  double sum = 0.0;
  for (const SourcePair& pair : sources.pairs())
    sum += std::exp(-c * s * std::abs(pair.real_mm)) + std::exp(-c * s * std::abs(pair.virtual_mm));
  return 2.0 * kPi * std::pow(c, -1.5) * strength * sum;
}

// Calls visit(a, N(a)) for half widths a of the strip from 0 to pi/4, where the integrand ceases to decay.
template <typename Visit>
void for_each_strip(const ImageSources& sources, const Visit& visit) {
  constexpr int kStrips = 200;
  for (int i = 1; i < kStrips; ++i) {
    const double a = 0.25 * kPi * i / kStrips;
    visit(a, norm_on_line(sources, std::cos(2.0 * a)));
  }
}

// The largest step whose error is at most `allowed`.
double largest_step(const ImageSources& sources, double allowed) {
  double largest = 0.0;
  for_each_strip(sources, [&](double a, double norm) {
    largest = std::max(largest, 2.0 * kPi * a / std::log1p(2.0 * norm / allowed));
  });
  return largest;
}

double step_error(const ImageSources& sources, double step) {
  double least = std::numeric_limits<double>::infinity();
  for_each_strip(sources, [&](double a, double norm) {
    least = std::min(least, 2.0 * norm / std::expm1(2.0 * kPi * a / step));
  });
  return least;
}

// The weight of the Gaussian at the node u.
double weight_at(const ImageSources& sources, double u, double step) {
  const double t = std::exp(u);
  const double s = sources.s_tr_per_mm();
  const double damping = 0.25 * s * s / (t * t);
  double sum = 0.0;
  for (const SourcePair& pair : sources.pairs()) {
    const double real = std::exp(-pair.real_mm * pair.real_mm * t * t - damping);
    const double image = std::exp(-pair.virtual_mm * pair.virtual_mm * t * t - damping);
    sum += 2.0 * sources.flux() * t * (pair.real_mm * real - pair.virtual_mm * image);
    if (sources.fluence_per_mm() == 0.0) continue;
    // real - image, which cancel where t is small.
    const double further = (pair.virtual_mm - pair.real_mm) * (pair.virtual_mm + pair.real_mm) * t * t;
    const double difference = further > 0.0 ? -real * std::expm1(-further) : image * std::expm1(further);
    sum += sources.fluence_per_mm() / t * difference;
  }
  return 2.0 * std::sqrt(kPi) * step * sum;
}

// One channel's weights by node index k, u = k step.
struct NodeWeights {
  std::map<int, double> weights;
  double left_out = 0.0;  // sum of |weights|
};

// All nodes whose weights do not underflow: beyond, exp(-z^2 t^2) or exp(-s^2 / 4t^2) is 0. Without
// absorption weights fall off as t instead; those below t = 1e-20 / z sum to less than rounding.
NodeWeights all_nodes(const ImageSources& sources, double step) {
  double nearest_mm = std::numeric_limits<double>::infinity();
  double farthest_mm = 0.0;
  for (const SourcePair& pair : sources.pairs()) {
    for (const double z : {std::abs(pair.real_mm), std::abs(pair.virtual_mm)}) {
      nearest_mm = std::min(nearest_mm, z);
      farthest_mm = std::max(farthest_mm, z);
    }
  }
  const double first = std::max(0.5 * sources.s_tr_per_mm() / std::sqrt(kUnderflow), 1e-20 / farthest_mm);
  const double last = std::sqrt(kUnderflow) / nearest_mm;
  NodeWeights nodes;
  for (int k = static_cast<int>(std::floor(std::log(first) / step)); k * step <= std::log(last); ++k)
    nodes.weights.emplace(k, weight_at(sources, k * step, step));
  return nodes;
}

// Leaves out nodes at either end while their weights sum to `allowed` at most.
void trim(NodeWeights& nodes, double allowed) {
  for (const bool front : {true, false}) {
    double sum = 0.0;
    while (!nodes.weights.empty()) {
      const auto end = front ? nodes.weights.begin() : std::prev(nodes.weights.end());
      if (sum + std::abs(end->second) > allowed) break;
      sum += std::abs(end->second);
      nodes.weights.erase(end);
    }
    nodes.left_out += sum;
  }
}

}  // namespace

GaussianMixture gaussian_mixture(const std::array<ImageSources, 3>& channels, double tolerance) {
  if (!(tolerance >= kSmallestTolerance && tolerance <= kLargestTolerance)) {
    throw_input_error({}, "a mixture's tolerance is {}: it must be {} to {}", tolerance, kSmallestTolerance,
                      kLargestTolerance);
  }
  double step = std::numeric_limits<double>::infinity();
  for (const ImageSources& sources : channels) {
    if (sources.fluence_per_mm() != 0.0 && !(sources.s_tr_per_mm() > 0.0))
      throw_input_error({}, "the better dipole has no mixture of Gaussians where nothing is absorbed");
    step = std::min(step, largest_step(sources, kStepShare * tolerance));
  }
  GaussianMixture mixture;
  std::map<int, Vec3d, std::greater<>> weights;  // ascending in the variance
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto channel = static_cast<Eigen::Index>(c);
    NodeWeights nodes = all_nodes(channels[c], step);
    trim(nodes, kEndShare * tolerance);
    double total = 0.0;
    for (const auto& [k, weight] : nodes.weights) {
      weights.try_emplace(k, Vec3d::Zero()).first->second[channel] = weight;
      total += std::abs(weight);
    }
    mixture.error_bound[channel] = step_error(channels[c], step) + nodes.left_out + kRounding * total;
  }
  for (const auto& [k, weight] : weights) mixture.levels.push_back({0.5 * std::exp(-2.0 * k * step), weight});
  return mixture;
}

}  // namespace truescatter
