#pragma once

#include "core/image.h"

namespace truescatter {

// The share of microfacets per solid angle whose normal H leans from N by alpha, n_h = cos(alpha), at
// roughness m (Beckmann; Yang et al. equation 1):
//
//   D = exp(-tan^2(alpha) / m^2) / (pi m^2 cos^4(alpha)),   the integral of D cos(alpha) over the hemisphere
//   is 1;
//
// 0 for n_h <= 0. (d'Eon & Luebke's code leaves out the pi.)
double beckmann(double n_h, double m);

inline constexpr double kLeastRoughness = 0.1;
inline constexpr double kLargestRoughness = 1.0;

// What a table of D holds. logarithm: ln D. power: 0.5 D^0.1, d'Eon & Luebke's, which fits into [0, 1] over
// their roughnesses; between its texels it is the less exact the smaller D is.
enum class BeckmannEncoding { logarithm, power };

// D over n_h (columns, from 0 to 1) and ln m (rows, from the least roughness to the largest), a value at each
// texel's centre, to be read bilinearly. One channel.
//
// ln D = -(1 / n_h^2 - 1) / m^2 - ln(pi m^2 n_h^4). A line between values h apart misses a curve by h^2 / 8
// times its second derivative at most: along n_h 6 / (n_h^4 m^2), along ln m 4 (1 / n_h^2 - 1) / m^2. Where D
// is not below the smallest single float, ln D > -87.3, the first is largest at m = 1, n_h = 0.102, 5.5e4,
// and the second there 380. With 2048 columns and 512 rows: 0.0017 + 0.0010, less than 0.3 %.
struct BeckmannTable {
  BeckmannEncoding encoding = BeckmannEncoding::logarithm;
  Image texels;
};
BeckmannTable make_beckmann_table(BeckmannEncoding encoding);

// D as a table gives it to a shader that reads it bilinearly; m within the table's.
double read_beckmann(const BeckmannTable& table, double n_h, double m);

}  // namespace truescatter
