#include "truth/triangle_rules.h"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
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

std::vector<TriangleNode> degree6() {
  std::vector<TriangleNode> nodes;
  add_orbit3(nodes, 0.480137964112215044, 0.0807310895930309783);
  add_orbit3(nodes, 0.21942998254978296, 0.17133312415298103);
  add_orbit6(nodes, 0.0193717243612407884, 0.141619015923968158, 0.0406345597936606625);
  return nodes;
}

std::vector<TriangleNode> degree8() {
  std::vector<TriangleNode> nodes;
  add_centroid(nodes, 0.144315607677787168);
  add_orbit3(nodes, 0.0505472283170309755, 0.0324584976231980803);
  add_orbit3(nodes, 0.459292588292723156, 0.0950916342672846248);
  add_orbit3(nodes, 0.170569307751760207, 0.10321737053471825);
  add_orbit6(nodes, 0.00839477740995760534, 0.263112829634638113, 0.0272303141744349943);
  return nodes;
}

std::vector<TriangleNode> degree10() {
  std::vector<TriangleNode> nodes;
  add_centroid(nodes, 0.0817433291462859664);
  add_orbit3(nodes, 0.142161101056564385, 0.045957963604744728);
  add_orbit3(nodes, 0.0320553732169435129, 0.0133529688131495663);
  add_orbit6(nodes, 0.0296198894887297676, 0.369146781827810987, 0.0341846481629594286);
  add_orbit6(nodes, 0.0283676653399384393, 0.163701733737182496, 0.0252977577072883844);
  add_orbit6(nodes, 0.14813288578382055, 0.321812995288835421, 0.0639049063964240454);
  return nodes;
}

std::vector<TriangleNode> degree12() {
  std::vector<TriangleNode> nodes;
  add_orbit3(nodes, 0.488217389773804883, 0.0257310664404553354);
  add_orbit3(nodes, 0.439724392294460273, 0.0436925445380384021);
  add_orbit3(nodes, 0.0213173504532103702, 0.00616626105155901723);
  add_orbit3(nodes, 0.127576145541585925, 0.034796112930708943);
  add_orbit3(nodes, 0.271210385012115922, 0.0628582242178851004);
  add_orbit6(nodes, 0.0257340505483302282, 0.116251915907597141, 0.0173162311086588924);
  add_orbit6(nodes, 0.0228383322222570296, 0.281325580989939548, 0.0223567732023034457);
  add_orbit6(nodes, 0.115343494534697999, 0.275713269685514194, 0.0403715577663809295);
  return nodes;
}

// A product Gauss rule of 30 x 30 nodes, exact to degree 58: what the rules' errors are measured against.
std::vector<TriangleNode> reference_nodes() {
  using Gauss = boost::math::quadrature::gauss<double, 30>;
  std::vector<std::array<double, 2>> line;  // node in [0, 1], weight
  for (std::size_t i = 0; i < Gauss::abscissa().size(); ++i) {
    line.push_back({0.5 - 0.5 * Gauss::abscissa()[i], 0.5 * Gauss::weights()[i]});
    line.push_back({0.5 + 0.5 * Gauss::abscissa()[i], 0.5 * Gauss::weights()[i]});
  }
  std::vector<TriangleNode> nodes;
  for (const auto& [u, wu] : line) {
    for (const auto& [v, wv] : line) nodes.push_back({{1.0 - u, u * (1.0 - v), u * v}, 2.0 * u * wu * wv});
  }
  return nodes;
}

// The sums over the nodes of w x^k and of w x^k lambda_i, for all k, with x = sum_i corner_i lambda_i.
using Moments = std::array<Vec4d, kTaylorOrders>;
Moments moments(std::span<const TriangleNode> nodes, const Vec3d& corner) {
  Moments sums;
  sums.fill(Vec4d::Zero());
  for (const TriangleNode& node : nodes) {
    const double x = corner.dot(node.barycentric);
    Vec4d term(node.weight, node.weight * node.barycentric[0], node.weight * node.barycentric[1],
               node.weight * node.barycentric[2]);
    for (Vec4d& sum : sums) {
      sum += term;
      term *= x;
    }
  }
  return sums;
}

std::array<double, kTaylorOrders> taylor_errors(std::span<const TriangleNode> nodes,
                                                std::span<const TriangleNode> reference) {
  std::array<double, kTaylorOrders> errors{};
  constexpr int kShapes = 32;
  for (int i = 0; i <= kShapes; ++i) {
    // Chebyshev points: a polynomial of degree k between them exceeds its values there by little.
    const double t = -0.5 + 0.5 * std::cos(kPi * i / kShapes);
    const Vec3d corner(1.0, t, -1.0 - t);
    const Moments rule = moments(nodes, corner);
    const Moments exact = moments(reference, corner);
    for (std::size_t k = 0; k < kTaylorOrders; ++k) {
      const Vec4d e = rule[k] - exact[k];
      for (Eigen::Index c = 1; c < 4; ++c)
        errors[k] = std::max({errors[k], std::abs(e[0]), std::abs(e[c]), std::abs(e[0] - e[c])});
    }
  }
  return errors;
}

// Means of |x - c| and |x - c| lambda_i.
Vec4d kink_moments(std::span<const TriangleNode> nodes, const Vec3d& corner, double c) {
  Vec4d sum = Vec4d::Zero();
  for (const TriangleNode& node : nodes) {
    const double value = node.weight * std::abs(corner.dot(node.barycentric) - c);
    sum += value * Vec4d(1.0, node.barycentric[0], node.barycentric[1], node.barycentric[2]);
  }
  return sum;
}

struct KinkErrors {
  double largest = 0.0;
  double rms = 0.0;
};

KinkErrors kink_errors(std::span<const TriangleNode> nodes, std::span<const TriangleNode> reference) {
  constexpr int kShapes = 8;
  constexpr int kOffsets = 24;
  KinkErrors errors;
  int count = 0;
  for (int i = 0; i <= kShapes; ++i) {
    const double t = -static_cast<double>(i) / kShapes;
    const Vec3d corner(1.0, t, -1.0 - t);
    for (int j = 1; j < kOffsets; ++j) {
      const double c = -1.0 + 2.0 * j / kOffsets;
      if (c <= corner.minCoeff()) continue;
      const Vec4d e = kink_moments(nodes, corner, c) - kink_moments(reference, corner, c);
      double worst = std::abs(e[0]);
      for (Eigen::Index k = 1; k < 4; ++k) worst = std::max({worst, std::abs(e[k]), std::abs(e[0] - e[k])});
      errors.largest = std::max(errors.largest, worst);
      errors.rms += worst * worst;
      ++count;
    }
  }
  errors.rms = std::max(std::sqrt(errors.rms / count), 0.25 * errors.largest);
  return errors;
}

struct Rules {
  std::vector<std::vector<TriangleNode>> nodes;
  std::vector<TriangleRule> rules;

  Rules() : nodes{degree2(), degree4(), degree5(), degree6(), degree8(), degree10(), degree12()} {
    constexpr std::array<int, 7> kDegrees = {2, 4, 5, 6, 8, 10, 12};
    const std::vector<TriangleNode> reference = reference_nodes();
    for (std::size_t r = 0; r < nodes.size(); ++r) {
      const KinkErrors kinks = kink_errors(nodes[r], reference);
      rules.push_back({kDegrees[r], taylor_errors(nodes[r], reference), kinks.largest, kinks.rms, nodes[r]});
    }
  }
};

}  // namespace

HermiteMoments::HermiteMoments(double beyond_std_devs) {
  // The midpoint rule in polar coordinates: 1 % is enough.
  constexpr int kRadii = 300;
  constexpr int kAngles = 100;
  constexpr double kWidth = 9.0;
  magnitude.fill(0.0);
  for (int i = 0; i < kRadii; ++i) {
    const double rho = beyond_std_devs + kWidth * (i + 0.5) / kRadii;
    const double weight = rho * std::exp(-0.5 * rho * rho) * kWidth / kRadii / kAngles;
    for (int j = 0; j < kAngles; ++j) {
      const double z = rho * std::cos(0.5 * kPi * (j + 0.5) / kAngles);
      double before = 0.0;
      double value = 1.0;  // He_k(z) / sqrt(k!)
      for (std::size_t k = 0; k < kTaylorOrders; ++k) {
        magnitude[k] += weight * std::abs(value);
        const auto order = static_cast<double>(k);
        const double next = (z * value - std::sqrt(order) * before) / std::sqrt(order + 1.0);
        before = value;
        value = next;
      }
    }
  }
}

double gaussian_error(const TriangleRule& rule, const HermiteMoments& moments, double radius_in_std_devs) {
  double sum = 0.0;
  double factor = 0.5 * kPi;  // times x^k / sqrt(k!)
  for (std::size_t k = 0; k < kTaylorOrders; ++k) {
    if (k > 0) factor *= radius_in_std_devs / std::sqrt(static_cast<double>(k));
    if (k >= static_cast<std::size_t>(rule.degree)) sum += rule.errors[k] * moments.magnitude[k] * factor;
  }
  return sum;
}

std::span<const TriangleRule> triangle_rules() {
  static const Rules all;
  return all.rules;
}

}  // namespace truescatter
