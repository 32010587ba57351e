#pragma once

#include <array>
#include <complex>
#include <filesystem>
#include <string>
#include <vector>

#include "profile/medium.h"
#include "profile/radial_profile.h"

namespace truescatter {

// One layer of a stack, one channel. `medium.eta` is its own index of refraction, relative to air.
struct Layer {
  Medium medium;
  double thickness_mm;  // infinity: without end, the last layer only
};

// What a homogeneous slab does to light of the spatial frequency k (in rad/mm), as Hankel transforms
// 2 pi int R(r) J_0(k r) r dr of the multipole's profiles (Donner & Jensen 2005). Lit from above (+) and from
// below (-): these differ where the indices above and below do.
struct SlabResponse {
  double reflect_above;
  double transmit_above;
  double reflect_below;
  double transmit_below;
};

// The multipole in closed form. A source at depth z has the transform 2 pi sgn(z) exp(-g |z|) with g =
// sqrt(s_tr^2 + k^2), and the images are a geometric series of the period P = 2 (d + zb_above + zb_below):
// with the slab's thickness d and l = 1 / sigma_t'
//
//   R = a'/2 [sinh(g (P/2 - l)) + sinh(g (P/2 - l - 2 zb))] / sinh(g P/2)
//   T = a'/2 [sinh(g (P/2 - d + l)) - sinh(g (P/2 - d - l - 2 zb))] / sinh(g P/2)
//
// with zb = 2 A D of the side that is lit. `eta_above`, `eta_below`: of what the slab lies between; a ratio
// below 1 takes Fdr's branch for it (Egan & Hilgeman 1973): -0.4399 + 0.7099/eta - 0.3319/eta^2 +
// 0.0636/eta^3. A layer without end transmits nothing.
SlabResponse slab_response(const Layer& layer, double eta_above, double eta_below, double k_per_mm);

// The profile of a stack of layers under air, lit from above: slabs are combined frequency by frequency,
//
//   R+12 = R+1 + T+1 R+2 T-1 / (1 - R-1 R+2),   T+12 = T+1 T+2 / (1 - R-1 R+2)
//
// from the lowest upwards, so that what is below never needs its own R- and T. Back in space, with
//
//   f(r) = int R(k) J_0(k r) k dk / 2 pi.
//
// k R(k) is a Fourier series in log k to rounding: it falls off at either end and is analytic for |Im log k|
// < pi/2, where R falls as exp(-k l). Each of its terms k^(i w) has a closed transform (Talman 1978):
//
//   int k^(i w) J_0(k r) dk = 2^(i w) Gamma((1 + i w)/2) / Gamma((1 - i w)/2) r^(-1 - i w),
//
// of modulus 1/r, so r f(r) is as exact as k R(k) is: to some 1e-15 / l. F follows term by term. A
// RadialProfile.
class LayeredProfile {
 public:
  // Throws Error (input) for no layers; for a layer that is no thicker than its mean free path; for one
  // without end that is not the last; and for what require_valid refuses.
  explicit LayeredProfile(std::vector<Layer> layers);

  double value(double r_mm) const;
  double antiderivative(double r_mm) const;
  double albedo() const { return response(0.0); }
  double shortest_length_mm() const;  // the mean free path of the first layer

  // R(k) of the stack.
  double response(double k_per_mm) const;

 private:
  std::vector<Layer> layers_;
  double log_step_ = 0.0;                        // of w
  std::vector<std::complex<double>> harmonics_;  // of r f(r), in r^(-i m log_step); m = 0, 1, ...
};

static_assert(RadialProfile<LayeredProfile>);

// Stacks by name, three channels: skin-three-layer, as Donner & Jensen 2005 give it (epidermis, upper dermis,
// bloody dermis without end; coefficients read in 1/mm, the only reading that keeps each layer thicker than
// its mean free path).
struct LayeredMaterial {
  std::string name;
  std::array<std::vector<Layer>, 3> channels;
};
const std::vector<LayeredMaterial>& layered_materials();

// Reads a CSV of layers from the top, one a row, with the header
// `thickness_mm,sigma_a_r,sigma_a_g,sigma_a_b,sigma_s_prime_r,sigma_s_prime_g,sigma_s_prime_b,eta`:
// coefficients in 1/mm; a thickness of 0 says that the layer (the last one) has no end. Throws Error (input)
// that names file, line and rule.
std::array<std::vector<Layer>, 3> read_layers(const std::filesystem::path& path);

}  // namespace truescatter
