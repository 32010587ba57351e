#pragma once

#include <filesystem>
#include <vector>

#include "profile/profile.h"

namespace truescatter {

// Reads the sum of Gaussians of a FIT.json (DESIGN section 4): `variances`, in mm^2, above 0 and ascending,
// and `weights`, one [r, g, b] for each. Other keys are the fit's own account and are not read. Throws Error
// (input) that names the file and the line and column of a slip in its JSON, or the key, the value and the
// rule that it breaks.
std::vector<GaussianLevel> read_fit(const std::filesystem::path& path);

}  // namespace truescatter
