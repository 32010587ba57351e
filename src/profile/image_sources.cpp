#include "profile/image_sources.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"

namespace truescatter {
namespace {

constexpr int kFewestImages = 20;
constexpr int kMostImages = 10000;
constexpr double kBelowRounding = 37.0;  // exp(-37) < 1e-16

double distance(double r, double z) { return std::hypot(r, z); }

double flux_of(double r, double z, double s) {
  const double d = distance(r, z);
  return z * (1.0 + s * d) * std::exp(-s * d) / (d * d * d);
}

double flux_antiderivative(double r, double z, double s) {
  const double d = distance(r, z);
  return z / d * std::exp(-s * d);
}

// (exp(-s d_real) - exp(-s d_virtual)) / s, which stays accurate as s goes to 0.
double fluence_antiderivative(double r, const SourcePair& pair, double s) {
  const double d = distance(r, pair.real_mm);
  const double further = (pair.virtual_mm - pair.real_mm) * (pair.virtual_mm + pair.real_mm) /
                         (d + distance(r, pair.virtual_mm));
  return s > 0.0 ? -std::exp(-s * d) * std::expm1(-s * further) / s : further;
}

}  // namespace

ImageSources::ImageSources(double s_tr_per_mm, double flux, double fluence_per_mm,
                           std::vector<SourcePair> pairs)
    : s_tr_(s_tr_per_mm), flux_(flux), fluence_(fluence_per_mm), pairs_(std::move(pairs)) {
  assert(s_tr_ >= 0.0 && !pairs_.empty());
}

double ImageSources::value(double r_mm) const {
  double sum = 0.0;
  for (const SourcePair& pair : pairs_) {
    sum += flux_ * (flux_of(r_mm, pair.real_mm, s_tr_) - flux_of(r_mm, pair.virtual_mm, s_tr_));
    if (fluence_ == 0.0) continue;
    const double d_real = distance(r_mm, pair.real_mm);
    const double d_virtual = distance(r_mm, pair.virtual_mm);
    sum += fluence_ * (std::exp(-s_tr_ * d_real) / d_real - std::exp(-s_tr_ * d_virtual) / d_virtual);
  }
  return sum;
}

double ImageSources::antiderivative(double r_mm) const {
  double sum = 0.0;
  for (const SourcePair& pair : pairs_) {
    sum -= flux_ * (flux_antiderivative(r_mm, pair.real_mm, s_tr_) -
                    flux_antiderivative(r_mm, pair.virtual_mm, s_tr_));
    if (fluence_ != 0.0) sum -= fluence_ * fluence_antiderivative(r_mm, pair, s_tr_);
  }
  return sum;
}

double ImageSources::albedo() const { return -2.0 * kPi * antiderivative(0.0); }

double ImageSources::shortest_length_mm() const {
  double shortest = std::numeric_limits<double>::infinity();
  for (const SourcePair& pair : pairs_)
    shortest = std::min({shortest, std::abs(pair.real_mm), std::abs(pair.virtual_mm)});
  return shortest;
}

ImageSources classical_dipole(const Medium& medium) {
  require_valid(medium);
  const double diffusion_mm = medium.mean_free_path_mm() / 3.0;
  const double a = extrapolation_factor(classical_diffuse_reflectance(medium.eta));
  const double real_mm = medium.mean_free_path_mm();
  return {std::sqrt(medium.sigma_a_per_mm / diffusion_mm),
          medium.reduced_albedo() / (4.0 * kPi),
          0.0,
          {{real_mm, -(real_mm + 4.0 * a * diffusion_mm)}}};
}

ImageSources better_dipole(const Medium& medium) {
  require_valid(medium);
  return better_dipole(medium, internal_fresnel_moments(medium.eta));
}

ImageSources better_dipole(const Medium& medium, const FresnelMoments& moments) {
  require_valid(medium);
  const double real_mm = medium.mean_free_path_mm();
  const double diffusion_mm =
      (2.0 * medium.sigma_a_per_mm + medium.sigma_s_prime_per_mm) * real_mm * real_mm / 3.0;
  const double a = (1.0 + moments.three_c2) / (1.0 - moments.two_c1);
  const double by_fluence = 0.25 * (1.0 - moments.two_c1);  // C_phi
  const double by_flux = 0.5 * (1.0 - moments.three_c2);    // C_E
  const double strength = medium.reduced_albedo() * medium.reduced_albedo() / (4.0 * kPi);
  return {std::sqrt(medium.sigma_a_per_mm / diffusion_mm),
          strength * by_flux,
          strength * by_fluence / diffusion_mm,
          {{real_mm, -(real_mm + 4.0 * a * diffusion_mm)}}};
}

ImageSources multipole(const Medium& medium, double thickness_mm, SlabSide side) {
  const ImageSources dipole = classical_dipole(medium);
  const double real_mm = dipole.pairs().front().real_mm;
  const double boundary_mm = -0.5 * (dipole.pairs().front().virtual_mm + real_mm);  // z_b = 2 A D
  require_thick(medium, thickness_mm, "slab");
  if (!std::isfinite(thickness_mm))
    throw_input_error({}, "the slab is {} mm thick: a thickness is finite", thickness_mm);
  const double period_mm = 2.0 * (thickness_mm + 2.0 * boundary_mm);
  const double images = std::ceil(kBelowRounding / (dipole.s_tr_per_mm() * period_mm));
  if (!(images <= kMostImages)) {
    throw_input_error(
        {},
        "a slab of {} mm with sigma_a {} 1/mm absorbs so little that more than {} images on each "
        "side would matter",
        thickness_mm, medium.sigma_a_per_mm, kMostImages);
  }
  const int n = std::max(kFewestImages, static_cast<int>(images));
  std::vector<SourcePair> pairs;
  for (int i = -n; i <= n; ++i) {
    const SourcePair pair{i * period_mm + real_mm, i * period_mm - real_mm - 2.0 * boundary_mm};
    // Seen from the far side, depths count from there.
    pairs.push_back(side == SlabSide::lit
                        ? pair
                        : SourcePair{thickness_mm - pair.real_mm, thickness_mm - pair.virtual_mm});
  }
  return {dipole.s_tr_per_mm(), dipole.flux(), 0.0, std::move(pairs)};
}

}  // namespace truescatter
