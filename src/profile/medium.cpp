#include "profile/medium.h"

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

#include "core/error.h"

namespace truescatter {
namespace {

constexpr double kMost = 1e9;
constexpr double kLeast = 1e-9;

// Halvings of the range of cosines: for eta near 1, where what is integrated is mostly rounding.
constexpr unsigned kDeepest = 10;

// For light that meets the surface at the cosine mu inside and leaves at mu_out outside.
double fresnel_reflectance(double eta, double mu, double mu_out) {
  const double parallel = (eta * mu_out - mu) / (eta * mu_out + mu);
  const double perpendicular = (eta * mu - mu_out) / (eta * mu + mu_out);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

}  // namespace

void require_valid(const Medium& medium) {
  const auto refuse = [](const char* name, double value, const char* rule) {
    throw_input_error({}, "{} is {}: it must be {}", name, value, rule);
  };
  if (!(medium.sigma_a_per_mm >= 0.0) || !std::isfinite(medium.sigma_a_per_mm))
    refuse("sigma_a (1/mm)", medium.sigma_a_per_mm, "0 or more, and finite");
  if (!(medium.sigma_s_prime_per_mm > 0.0) || !std::isfinite(medium.sigma_s_prime_per_mm))
    refuse("sigma_s' (1/mm)", medium.sigma_s_prime_per_mm, "above 0, and finite");
  if (medium.sigma_a_per_mm > kMost) refuse("sigma_a (1/mm)", medium.sigma_a_per_mm, "at most 1e9");
  if (medium.sigma_s_prime_per_mm > kMost || medium.sigma_s_prime_per_mm < kLeast)
    refuse("sigma_s' (1/mm)", medium.sigma_s_prime_per_mm, "1e-9 to 1e9");
  if (!(medium.eta > 1.0) || !std::isfinite(medium.eta)) refuse("eta", medium.eta, "above 1, and finite");
}

void require_thick(const Medium& medium, double thickness_mm, std::string_view what) {
  const double path_mm = medium.mean_free_path_mm();
  if (thickness_mm > path_mm) return;
  throw_input_error(
      {},
      "the {} is {} mm thick: diffusion theory has no valid answer for one that is no thicker than "
      "its mean free path, {} mm",
      what, thickness_mm, path_mm);
}

double extrapolation_factor(double diffuse_reflectance) {
  return (1.0 + diffuse_reflectance) / (1.0 - diffuse_reflectance);
}

const std::vector<Material>& materials() {
  static const std::vector<Material> table = {
      {"marble", {2.19, 2.62, 3.00}, {0.0021, 0.0041, 0.0071}, 1.5},
      {"skin1", {0.74, 0.88, 1.01}, {0.032, 0.17, 0.48}, 1.3},
      {"skin2", {1.09, 1.59, 1.79}, {0.013, 0.070, 0.145}, 1.3},
      {"whole-milk", {2.55, 3.21, 3.77}, {0.0011, 0.0024, 0.014}, 1.3},
      {"skim-milk", {0.70, 1.22, 1.90}, {0.0014, 0.0025, 0.0142}, 1.3},
      {"apple", {2.29, 2.39, 1.97}, {0.0030, 0.0034, 0.046}, 1.3},
      {"cream", {7.38, 5.47, 3.15}, {0.0002, 0.0028, 0.0163}, 1.3},
      {"ketchup", {0.18, 0.07, 0.03}, {0.061, 0.97, 1.45}, 1.3}};
  return table;
}

// Below the critical cosine all is reflected, which integrates by hand. Above it the integrals run over the
// cosine outside, mu_out dmu_out = eta^2 mu dmu, in which the reflectance has no square root at its end.
FresnelMoments internal_fresnel_moments(double eta) {
  using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;
  require_valid({0.0, 1.0, eta});
  const double critical2 = 1.0 - 1.0 / (eta * eta);
  const double critical = std::sqrt(critical2);
  const auto transmitted = [&](int power) {
    const auto integrand = [&](double mu_out) {
      const double mu = std::sqrt(critical2 + mu_out * mu_out / (eta * eta));
      return fresnel_reflectance(eta, mu, mu_out) * std::pow(mu, power) * mu_out / (eta * eta);
    };
    return Rule::integrate(integrand, 0.0, 1.0, kDeepest, 1e-13);
  };
  return {critical2 + 2.0 * transmitted(0), critical2 * critical + 3.0 * transmitted(1)};
}

double classical_diffuse_reflectance(double eta) {
  return -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
}

}  // namespace truescatter
