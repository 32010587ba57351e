#pragma once

#include "truth/edge_formula.h"

namespace truescatter {

// edge_inside_exact to about 1e-7 of a plane's mass, by Gauss-Legendre quadrature where the edge is short
// enough for it (derivation at edge_by_quadrature).
EdgeIntegrals edge_inside_fast(double p, double t0, double t1, double std_dev_mm, double at_foot);

// Where r > r_max: F(r) against its value at_cut at the cut-off.
EdgeIntegrals edge_outside_fast(double p, double t0, double t1, double h, double std_dev_mm, double at_cut);

}  // namespace truescatter
