#include "profile/table_profile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "core/csv.h"
#include "core/error.h"
#include "core/file.h"
#include "core/vec.h"

namespace truescatter {
namespace {

// Beyond these no one has measured, and squares lose their digits.
constexpr double kLeastRadius_mm = 1e-9;
constexpr double kMostRadius_mm = 1e9;
constexpr double kLeastValue = 1e-40;
constexpr double kMostValue = 1e40;

// Of a table, by the name of its first column.
struct Unit {
  const char* column;
  double mm;
};

// Millimetres unless the header's first cell says otherwise.
Unit unit_of(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  const std::string first = text.substr(0, text.find_first_of(",\r\n"));
  if (first.ends_with("r_cm")) return {"r_cm", 10.0};
  if (first.ends_with("r_m")) return {"r_m", 1000.0};
  return {"r_mm", 1.0};
}

// f = a + b t + c t^2 + d t^3 on an interval, t from 0 to 1.
struct Cubic {
  double a, b, c, d;
};

Cubic hermite(double length, double from, double to, double slope_from, double slope_to) {
  return {from, length * slope_from, 3.0 * (to - from) - length * (2.0 * slope_from + slope_to),
          2.0 * (from - to) + length * (slope_from + slope_to)};
}

// At an end: the parabola's slope, kept from overshooting.
double end_slope(double length, double next_length, double secant, double next_secant) {
  const double slope =
      ((2.0 * length + next_length) * secant - length * next_secant) / (length + next_length);
  if (slope * secant <= 0.0) return 0.0;
  if (secant * next_secant <= 0.0 && std::abs(slope) > 3.0 * std::abs(secant)) return 3.0 * secant;
  return slope;
}

std::vector<double> monotone_slopes(const std::vector<double>& r, const std::vector<double>& f) {
  const std::size_t intervals = r.size() - 1;
  std::vector<double> length(intervals);
  std::vector<double> secant(intervals);
  for (std::size_t i = 0; i < intervals; ++i) {
    length[i] = r[i + 1] - r[i];
    secant[i] = (f[i + 1] - f[i]) / length[i];
  }
  std::vector<double> slope(r.size(), secant.front());
  if (intervals == 1) return slope;
  slope.front() = end_slope(length[0], length[1], secant[0], secant[1]);
  slope.back() =
      end_slope(length[intervals - 1], length[intervals - 2], secant[intervals - 1], secant[intervals - 2]);
  for (std::size_t i = 1; i < intervals; ++i) {
    const double before = 2.0 * length[i] + length[i - 1];
    const double after = length[i] + 2.0 * length[i - 1];
    slope[i] = secant[i - 1] * secant[i] <= 0.0
                   ? 0.0
                   : (before + after) / (before / secant[i - 1] + after / secant[i]);
  }
  return slope;
}

}  // namespace

TableProfile::TableProfile(std::vector<double> radius_mm, std::vector<double> value_per_mm2)
    : radius_mm_(std::move(radius_mm)), value_(std::move(value_per_mm2)) {
  if (radius_mm_.size() < 2 || radius_mm_.size() != value_.size()) {
    throw_input_error({},
                      "a table of {} radii and {} values: it needs two or more, and as many of one as of "
                      "the other",
                      radius_mm_.size(), value_.size());
  }
  for (std::size_t i = 0; i < radius_mm_.size(); ++i) {
    if (!(radius_mm_[i] >= 0.0) || !std::isfinite(radius_mm_[i]))
      throw_input_error({}, "radius {} is {} mm: it must be 0 or more, and finite", i, radius_mm_[i]);
    if (i > 0 && !(radius_mm_[i] > radius_mm_[i - 1]))
      throw_input_error({}, "radius {} is {} mm, after {}: radii must ascend", i, radius_mm_[i],
                        radius_mm_[i - 1]);
    if (!(value_[i] >= 0.0) || !std::isfinite(value_[i]))
      throw_input_error({}, "value {} is {}: it must be 0 or more, and finite", i, value_[i]);
  }
  if (*std::max_element(value_.begin(), value_.end()) == 0.0)
    throw_input_error({}, "every value is 0: a profile needs light");
  slope_ = monotone_slopes(radius_mm_, value_);
  light_beyond_.assign(radius_mm_.size(), 0.0);
  for (std::size_t i = radius_mm_.size() - 1; i-- > 0;)
    light_beyond_[i] = light_beyond_[i + 1] + cubic_light(i, 1.0);
}

// int r f dr over the first part `t` of an interval.
double TableProfile::cubic_light(std::size_t i, double t) const {
  const double length = radius_mm_[i + 1] - radius_mm_[i];
  const Cubic f = hermite(length, value_[i], value_[i + 1], slope_[i], slope_[i + 1]);
  const double flat = t * (f.a + t * (f.b / 2.0 + t * (f.c / 3.0 + t * f.d / 4.0)));
  const double rising = t * t * (f.a / 2.0 + t * (f.b / 3.0 + t * (f.c / 4.0 + t * f.d / 5.0)));
  return length * (radius_mm_[i] * flat + length * rising);
}

double TableProfile::value(double r_mm) const {
  if (r_mm <= radius_mm_.front()) return value_.front();
  if (r_mm > radius_mm_.back()) return 0.0;
  const auto above = std::lower_bound(radius_mm_.begin(), radius_mm_.end(), r_mm);
  const auto i = static_cast<std::size_t>(above - radius_mm_.begin()) - 1;
  const double length = radius_mm_[i + 1] - radius_mm_[i];
  const double t = (r_mm - radius_mm_[i]) / length;
  const Cubic f = hermite(length, value_[i], value_[i + 1], slope_[i], slope_[i + 1]);
  return std::max(0.0, f.a + t * (f.b + t * (f.c + t * f.d)));
}

double TableProfile::antiderivative(double r_mm) const {
  const double first = radius_mm_.front();
  if (r_mm <= first) return -(light_beyond_.front() + 0.5 * value_.front() * (first * first - r_mm * r_mm));
  if (r_mm >= radius_mm_.back()) return 0.0;
  const auto above = std::lower_bound(radius_mm_.begin(), radius_mm_.end(), r_mm);
  const auto i = static_cast<std::size_t>(above - radius_mm_.begin()) - 1;
  const double t = (r_mm - radius_mm_[i]) / (radius_mm_[i + 1] - radius_mm_[i]);
  return -(light_beyond_[i] - cubic_light(i, t));
}

double TableProfile::albedo() const { return -2.0 * kPi * antiderivative(0.0); }

double TableProfile::shortest_length_mm() const {
  double shortest = radius_mm_.back();
  for (std::size_t i = 1; i < radius_mm_.size(); ++i)
    shortest = std::min(shortest, radius_mm_[i] - radius_mm_[i - 1]);
  return shortest;
}

FitTarget fit_target(const TableProfile& profile) {
  return {[profile](double r_mm) { return profile.value(r_mm); },
          [profile](double r_mm) { return profile.antiderivative(r_mm); },
          profile.albedo(),
          0.5 * profile.radius_mm()[1],
          3.0 * profile.radius_mm().back(),  // falls by 5 % over the table
          0.0,
          profile.radius_mm().back(),
          profile.radius_mm(),
          true};
}

std::array<TableProfile, 3> read_table_profile(const std::filesystem::path& path) {
  const Unit unit = unit_of(path);
  CsvReader reader(path, {unit.column, "r", "g", "b"});
  std::vector<double> radius_mm;
  std::array<std::vector<double>, 3> values;
  while (reader.next()) {
    const double radius = reader.number(0);
    if (radius < 0.0) throw_input_error(reader.where(0), "{}: a radius must not be negative", radius);
    if (radius != 0.0 && !(radius * unit.mm > kLeastRadius_mm && radius * unit.mm < kMostRadius_mm)) {
      throw_input_error(reader.where(0), "{}: a radius is 0, or {} to {} mm", radius, kLeastRadius_mm,
                        kMostRadius_mm);
    }
    if (!radius_mm.empty() && !(radius * unit.mm > radius_mm.back())) {
      throw_input_error(reader.where(0), "{} after {}: radii must ascend", radius,
                        radius_mm.back() / unit.mm);
    }
    radius_mm.push_back(radius * unit.mm);
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = reader.number(c + 1);
      if (value < 0.0) throw_input_error(reader.where(c + 1), "{}: R must not be negative", value);
      if (value != 0.0 && !(value > kLeastValue && value < kMostValue)) {
        throw_input_error(reader.where(c + 1), "{}: R is 0, or {} to {}", value, kLeastValue, kMostValue);
      }
      values[c].push_back(value / (unit.mm * unit.mm));
    }
  }
  if (radius_mm.size() < 2)
    throw_input_error(reader.where(), "the table has {} of at least 2 rows", radius_mm.size());
  constexpr const char* kNames[] = {"r", "g", "b"};
  for (std::size_t c = 0; c < 3; ++c) {
    if (*std::max_element(values[c].begin(), values[c].end()) == 0.0)
      throw_input_error({path.string()}, "the channel {} has no light: every R of it is 0", kNames[c]);
  }
  return {TableProfile(radius_mm, values[0]), TableProfile(radius_mm, values[1]),
          TableProfile(radius_mm, values[2])};
}

}  // namespace truescatter
