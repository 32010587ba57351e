#pragma once

#include <string>

#include "experiment/profile_model.h"

namespace truescatter {

// What was fitted and how, the Gaussians, and their errors in every norm with its domain: a table to read.
std::string fit_table(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit);

// The Gaussians as arrays to paste, in single precision, with the comment that says what they are and which
// program made them.
std::string fit_glsl(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit);
std::string fit_cpp(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit);

}  // namespace truescatter
