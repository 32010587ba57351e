#pragma once

#include <span>

#include "profile/fit_target.h"
#include "profile/variance_search.h"

namespace truescatter {

// From some variances to a least sum over channels of the relative errors in the area norm (which is the
// cost) nearby. `problem` is that of the targets, with any scale.
//
// Weighted squares lead near it: |e| <= e^2 / 2|e_0| + |e_0| / 2 with equality at e_0, so squares weighted by
// 1 / |e_0|, again and again, go down (majorisation; Ceres by variance_search.h). They slow down as they come
// near, and the rest of the way is by quasi-Newton steps (BFGS, Ceres) on the norm itself. Its gradient is
// exact: between neighbouring zeros of R - S the error has one sign and the antiderivatives of S's
// derivatives are closed; that the zeros move counts for nothing, as the error is 0 there.
FoundSum descend_in_area(std::span<const FitTarget> targets, FitProblem problem,
                         std::span<const double> start);

}  // namespace truescatter
