#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "experiment/profile_model.h"
#include "profile/profile.h"

namespace truescatter {

// A fit as FIT.json has it (README, Commands): `schema`, `asked` (the profile and how it was fitted),
// `variances` (mm^2, ascending), `weights` ([r, g, b] for each), `error` (by norm, [r, g, b] each; null where
// the norm is not finite, and `error_note` says why), `albedo` (`profile` and `fit`, [r, g, b]), `domain_mm`
// (of the norms: [from, to] of each channel) and `curve` (the profile and the fit at some radii of the
// domain: `r_mm`, `profile`, `fit`).
nlohmann::json fit_json(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit);

// The errors of any sum of Gaussians against a profile; `to_albedo`: of the sum whose every channel is scaled
// to the profile's albedo, for published sums are of total 1. Throws Error (input) for Gaussians with a spike
// beside them, which has no finite norm.
GaussianFit score(const DiffusionProfile& profile, const Profile& gaussians, bool to_albedo);

// Reads the sum of Gaussians of a FIT.json (README, Commands): `variances`, in mm^2, above 0 and ascending,
// and `weights`, one [r, g, b] for each. Other keys are the fit's own account and are not read. Throws Error
// (input) that names the file and the line and column of a slip in its JSON, or the key, the value and the
// rule that it breaks.
std::vector<GaussianLevel> read_fit(const std::filesystem::path& path);

}  // namespace truescatter
