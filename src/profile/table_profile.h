#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "profile/fit_target.h"

namespace truescatter {

// A measured profile of one channel: R at radii that ascend, between them the monotone cubic through its
// points (Fritsch & Carlson 1980, with the slopes of Fritsch & Butland 1984), which neither overshoots nor
// falls below 0. Within the first radius it is constant, beyond the last it is 0: what was not measured is
// not made up.
class TableProfile {
 public:
  // Radii (>= 0) ascend, values are >= 0 and not all 0, and there are two or more. Throws Error (input).
  TableProfile(std::vector<double> radius_mm, std::vector<double> value_per_mm2);

  double value(double r_mm) const;
  double antiderivative(double r_mm) const;  // closed: r times a cubic
  double albedo() const;
  double shortest_length_mm() const;  // the least distance between two radii

  const std::vector<double>& radius_mm() const { return radius_mm_; }

 private:
  double cubic_light(std::size_t interval, double t) const;

  std::vector<double> radius_mm_;
  std::vector<double> value_;
  std::vector<double> slope_;
  std::vector<double> light_beyond_;  // int r f dr from each radius on
};

static_assert(RadialProfile<TableProfile>);

// Its domain is what was measured, [0, last radius]; its radii are the breaks. A Gaussian narrower than half
// of the second radius would pass between the points.
FitTarget fit_target(const TableProfile& profile);

// Reads a CSV with the header `r_mm,r,g,b`: radii and R per channel in 1/mm^2. `r_cm` and `r_m` are read
// too; R is then in 1/cm^2 or 1/m^2. Throws Error (input) that names file, line and rule: a cell that is no
// finite number, radii that do not ascend, a negative value, a channel without light, fewer than two rows.
std::array<TableProfile, 3> read_table_profile(const std::filesystem::path& path);

}  // namespace truescatter
