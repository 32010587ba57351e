#pragma once

#include <concepts>

namespace truescatter {

// A radial diffusion profile of one channel, as the truth needs it (README, Definitions):
//
//   value(r_mm)           f(r), in 1/mm^2: exitance per power that enters at one point; r > 0, and r = 0
//   where
//                         the profile is finite there
//   antiderivative(r_mm)  F(r), without a unit: F'(r) = r f(r), and F falls to 0 far away; r >= 0
//   albedo()              2 pi int_0^inf r f dr = -2 pi F(0): what a plane under irradiance 1 sends back
//   shortest_length_mm()  F changes over no shorter a length: it is analytic where |Im r| is below it
template <typename P>
concept RadialProfile = requires(const P& profile, double r_mm) {
  { profile.value(r_mm) } -> std::convertible_to<double>;
  { profile.antiderivative(r_mm) } -> std::convertible_to<double>;
  { profile.albedo() } -> std::convertible_to<double>;
  { profile.shortest_length_mm() } -> std::convertible_to<double>;
};

}  // namespace truescatter
