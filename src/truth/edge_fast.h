#pragma once

#include "truth/edge_formula.h"

namespace truescatter {

// edge_inside_exact to 2e-8 of at_foot (and of s at_foot): Owen's T by interpolation in a table.
EdgeIntegrals edge_inside_fast(double p, double t0, double t1, double std_dev_mm, double at_foot);

// Where r > r_max: F(r) against its value at_cut at the cut-off. As accurate.
EdgeIntegrals edge_outside_fast(double p, double t0, double t1, double h, double std_dev_mm, double at_cut);

}  // namespace truescatter
