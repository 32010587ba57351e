#include "profile/burley.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/vec.h"
#include "profile/image_sources.h"

namespace truescatter {

Burley::Burley(double albedo, double d_mm) : albedo_(albedo), d_mm_(d_mm) {
  if (!(albedo >= 0.0 && albedo <= 1.0)) throw_input_error({}, "albedo is {}: it must be 0 to 1", albedo);
  if (!(d_mm > 0.0) || !std::isfinite(d_mm))
    throw_input_error({}, "d is {} mm: it must be above 0, and finite", d_mm);
}

double Burley::value(double r_mm) const {
  return albedo_ * (std::exp(-r_mm / d_mm_) + std::exp(-r_mm / (3.0 * d_mm_))) / (8.0 * kPi * d_mm_ * r_mm);
}

double Burley::antiderivative(double r_mm) const {
  return -albedo_ * (std::exp(-r_mm / d_mm_) + 3.0 * std::exp(-r_mm / (3.0 * d_mm_))) / (8.0 * kPi);
}

FitTarget fit_target(const Burley& profile) {
  FitTarget target = fit_target<Burley>(profile);
  target.square_integrable = false;
  return target;
}

double burley_scale(double albedo, BurleyScaling scaling) {
  switch (scaling) {
    case BurleyScaling::searchlight:
      return 1.85 - albedo + 7.0 * std::pow(std::abs(albedo - 0.8), 3);
    case BurleyScaling::diffuse:
      return 1.9 - albedo + 3.5 * std::pow(albedo - 0.8, 2);
    case BurleyScaling::diffuse_free_path:
      return 3.5 + 100.0 * std::pow(albedo - 0.33, 4);
  }
  return 0.0;
}

Burley burley(const Medium& medium, BurleyScaling scaling) {
  const ImageSources dipole = better_dipole(medium);
  double length_mm = medium.mean_free_path_mm();
  if (scaling == BurleyScaling::diffuse_free_path) {
    if (medium.sigma_a_per_mm == 0.0) {
      throw_input_error({}, "sigma_a is 0: a medium that does not absorb has no diffuse mean free path");
    }
    length_mm = 1.0 / dipole.s_tr_per_mm();
  }
  // Without absorption the better dipole's albedo is 1 up to rounding.
  const double albedo = std::min(1.0, dipole.albedo());
  return {albedo, length_mm / burley_scale(albedo, scaling)};
}

}  // namespace truescatter
