#include "experiment/fit_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"
#include "core/file.h"
#include "core/json_text.h"
#include "experiment/result_json.h"

namespace truescatter {
namespace {

using nlohmann::json;

const json& array_at(const json& object, const std::string& file, const char* key) {
  if (!object.is_object()) throw_input_error({file}, "an object with the key \"{}\" is needed", key);
  if (!object.contains(key)) throw_input_error({file}, "the key \"{}\" is missing", key);
  const json& value = object[key];
  if (!value.is_array() || value.empty())
    throw_input_error({file}, "{} is {}: an array of one or more is needed", key, value.dump());
  return value;
}

double number(const json& value, const std::string& file, const std::string& key) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw_input_error({file}, "{} is {}: a finite number is needed", key, value.dump());
  return value.get<double>();
}

constexpr int kCurvePoints = 200;

json asked_json(const DiffusionProfile& profile, const FitSpec& asked) {
  const ProfileModelSpec& spec = profile.spec;
  json object = {{"profile", spec.model}, {"title", profile.title()}};
  if (!spec.material.empty()) object["material"] = spec.material;
  if (!spec.table.empty()) object["table"] = spec.table;
  if (!spec.layers.empty()) object["layers"] = spec.layers;
  if (spec.sigma_s_prime_per_mm.maxCoeff() > 0.0) {
    object["sigma_a_per_mm"] = vector_json(spec.sigma_a_per_mm);
    object["sigma_s_prime_per_mm"] = vector_json(spec.sigma_s_prime_per_mm);
    object["eta"] = spec.eta;
  }
  if (spec.thickness_mm > 0.0) object["thickness_mm"] = spec.thickness_mm;
  if (spec.model == "burley") object["scaling"] = spec.scaling;
  if (!asked.file.empty()) {
    object["scored"] = asked.file;
    object["energy"] = asked.keep_albedo ? "albedo" : "free";
    return object;
  }
  object["gaussians"] = asked.gaussians > 0 ? json(asked.gaussians) : json("auto");
  object["tolerance"] = asked.gaussians > 0 ? json() : json(asked.tolerance);
  object["norm"] = asked.norm;
  object["weights"] = asked.nonnegative ? "non-negative" : "free";
  object["energy"] = asked.keep_albedo ? "albedo" : "free";
  object["variances"] = asked.shared_variances ? "shared" : "per-channel";
  if (asked.min_variance_mm2) object["min_variance_mm2"] = *asked.min_variance_mm2;
  if (asked.max_variance_mm2) object["max_variance_mm2"] = *asked.max_variance_mm2;
  object["seed"] = asked.seed;
  return object;
}

// Radii from the narrowest domain's start to the widest one's end, evenly in log r. A profile that is known
// from 0 on starts at 1e-4 of its end.
json curve_json(const std::array<FitTarget, 3>& targets, const GaussianFit& fit) {
  double from_mm = targets[0].r_max_mm;
  double to_mm = 0.0;
  for (const FitTarget& target : targets) {
    from_mm = std::min(from_mm, std::max(target.r_min_mm, 1e-4 * target.r_max_mm));
    to_mm = std::max(to_mm, target.r_max_mm);
  }
  const std::array<std::vector<WeightedGaussian>, 3> sums = {fit.channel(0), fit.channel(1), fit.channel(2)};
  json curve = {{"r_mm", json::array()}, {"profile", json::array()}, {"fit", json::array()}};
  for (int i = 0; i < kCurvePoints; ++i) {
    const double r_mm = from_mm * std::pow(to_mm / from_mm, i / (kCurvePoints - 1.0));
    Vec3d profile;
    Vec3d sum;
    for (std::size_t c = 0; c < 3; ++c) {
      profile[static_cast<Eigen::Index>(c)] = targets[c].value(r_mm);
      sum[static_cast<Eigen::Index>(c)] = sum_value(sums[c], r_mm);
    }
    curve["r_mm"].push_back(r_mm);
    curve["profile"].push_back(vector_json(profile));
    curve["fit"].push_back(vector_json(sum));
  }
  return curve;
}

}  // namespace

json fit_json(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit) {
  const std::array<FitTarget, 3> targets = profile.fit_targets();
  json object = {{"schema", "truescatter-fit/1"}, {"asked", asked_json(profile, asked)}};
  object["variances"] = json::array();
  object["weights"] = json::array();
  for (const GaussianLevel& level : fit.levels) {
    object["variances"].push_back(level.variance_mm2);
    object["weights"].push_back(vector_json(level.weight));
  }
  for (const FitNorm norm : kFitNorms) {
    json& errors = object["error"][std::string(name_of(norm))];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::optional<double> error = fit.errors[c].in(norm);
      const bool dark = is_dark(fit, c);
      errors.push_back(error && !dark ? json(*error) : json());
      if (dark) object["error_note"] = "the sum has no Gaussian in a channel";
      if (!error) object["error_note"] = "the norm r is not finite: the profile goes as 1/r at 0";
    }
  }
  object["albedo"] = {{"profile", vector_json(profile.albedo())}, {"fit", vector_json(fit.total_weight())}};
  for (const FitTarget& target : targets) object["domain_mm"].push_back({target.r_min_mm, target.r_max_mm});
  object["curve"] = curve_json(targets, fit);
  return object;
}

GaussianFit score(const DiffusionProfile& profile, const Profile& gaussians, bool to_albedo) {
  if (!gaussians.delta_weight.isZero(0.0)) {
    throw_input_error({}, "{} has light in a spike, which is no Gaussian: its norms are not finite",
                      gaussians.name);
  }
  const std::array<FitTarget, 3> targets = profile.fit_targets();
  GaussianFit scored;
  scored.levels = gaussian_levels(gaussians);
  if (to_albedo) {
    const Vec3d total = gaussians.total_weight();
    // A channel without light stays dark.
    const Vec3d scale = (total.array() != 0.0).select(profile.albedo().cwiseQuotient(total), 0.0);
    for (GaussianLevel& level : scored.levels) level.weight = level.weight.cwiseProduct(scale);
  }
  for (std::size_t c = 0; c < 3; ++c) scored.errors[c] = fit_errors(targets[c], scored.channel(c));
  return scored;
}

std::vector<GaussianLevel> read_fit(const std::filesystem::path& path) {
  const std::string file = path.string();
  const json fit = parse_json(file, read_text_file(path));
  const json& variances = array_at(fit, file, "variances");
  const json& weights = array_at(fit, file, "weights");
  if (weights.size() != variances.size()) {
    throw_input_error({file}, "weights has {} rows and variances {}: one row for each variance is needed",
                      weights.size(), variances.size());
  }
  std::vector<GaussianLevel> levels;
  for (std::size_t i = 0; i < variances.size(); ++i) {
    const std::string key = fmt::format("variances[{}]", i);
    GaussianLevel level{number(variances[i], file, key), Vec3d::Zero()};
    if (level.variance_mm2 <= 0.0)
      throw_input_error({file}, "{} is {}: a variance in mm^2 must be above 0", key, level.variance_mm2);
    if (i > 0 && level.variance_mm2 <= levels.back().variance_mm2) {
      throw_input_error({file}, "{} is {}, after {}: variances must ascend", key, level.variance_mm2,
                        levels.back().variance_mm2);
    }
    const json& row = weights[i];
    if (!row.is_array() || row.size() != 3)
      throw_input_error({file}, "weights[{}] is {}: three weights [r, g, b] are needed", i, row.dump());
    for (std::size_t c = 0; c < 3; ++c) {
      level.weight[static_cast<Eigen::Index>(c)] = number(row[c], file, fmt::format("weights[{}][{}]", i, c));
    }
    levels.push_back(level);
  }
  return levels;
}

}  // namespace truescatter
