#include "experiment/fit_text.h"

#include <fmt/format.h>

#include <cctype>
#include <optional>

#include "experiment/provenance.h"

namespace truescatter {
namespace {

std::string asked_text(const FitSpec& asked, std::size_t gaussians) {
  if (!asked.file.empty()) {
    return fmt::format("{} Gaussians of {}{}", gaussians, asked.file,
                       asked.keep_albedo ? ", scaled to the profile's albedo" : "");
  }
  std::string text = fmt::format(
      "{} Gaussians{}, norm {}, {} weights, {} variances", gaussians,
      asked.gaussians > 0 ? "" : fmt::format(" (the fewest within {})", asked.tolerance), asked.norm,
      asked.nonnegative ? "non-negative" : "free", asked.shared_variances ? "shared" : "per-channel");
  if (asked.keep_albedo) text += ", energy of the profile";
  return text;
}

std::string percent(const std::optional<double>& error) {
  return error ? fmt::format("{:>12.4g}", 100.0 * *error) : fmt::format("{:>12}", "not finite");
}

// What was fitted, how, and how well, in one line.
std::string caption(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit) {
  const FitNorm norm = find_norm(asked.norm).value();
  std::string text = fmt::format("{}: {}", profile.title(), asked_text(asked, fit.levels.size()));
  if (fit.errors[0].in(norm)) {
    text += fmt::format("; relative error {:.3g} / {:.3g} / {:.3g} %", 100.0 * *fit.errors[0].in(norm),
                        100.0 * *fit.errors[1].in(norm), 100.0 * *fit.errors[2].in(norm));
  }
  const Vec3d total = fit.total_weight();
  return text + fmt::format("; weights sum to {:.4g} / {:.4g} / {:.4g}; by {}", total[0], total[1], total[2],
                            software_name());
}

// Nine digits give a float back; always with a point, as GLSL asks for.
std::string literal(double value) {
  std::string text = fmt::format("{:.9g}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

}  // namespace

std::string fit_table(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit) {
  std::string text = fmt::format("{}\n{}\n\n", profile.title(), asked_text(asked, fit.levels.size()));
  text +=
      fmt::format("{:>14}{:>14}{:>12}{:>12}{:>12}\n", "variance mm^2", "std dev mm", "weight r", "g", "b");
  for (const GaussianLevel& level : fit.levels) {
    text += fmt::format("{:>14.6g}{:>14.6g}{:>12.6f}{:>12.6f}{:>12.6f}\n", level.variance_mm2,
                        level.std_dev_mm(), level.weight[0], level.weight[1], level.weight[2]);
  }
  const Vec3d total = fit.total_weight();
  const Vec3d albedo = profile.albedo();
  text += fmt::format("{:>28}{:>12.6f}{:>12.6f}{:>12.6f}\n", "sum", total[0], total[1], total[2]);
  text += fmt::format("{:>28}{:>12.6f}{:>12.6f}{:>12.6f}\n\n", "profile's albedo", albedo[0], albedo[1],
                      albedo[2]);
  text += fmt::format("{:<28}{:>12}{:>12}{:>12}\n", "relative error, %", "r", "g", "b");
  const char* meanings[] = {"r    sqrt(int r e^2)", "area int |e| r, all r", "r2   sqrt(int r^2 e^2)"};
  for (std::size_t i = 0; i < 3; ++i) {
    text += fmt::format("{:<28}", meanings[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      text +=
          is_dark(fit, c) ? fmt::format("{:>12}", "no Gaussian") : percent(fit.errors[c].in(kFitNorms[i]));
    }
    text += "\n";
  }
  const std::array<FitTarget, 3> targets = profile.fit_targets();
  text += fmt::format("{:<28}", "over r from, mm");
  for (const FitTarget& target : targets) text += fmt::format("{:>12.3g}", target.r_min_mm);
  text += fmt::format("\n{:<28}", "         to, mm");
  for (const FitTarget& target : targets) text += fmt::format("{:>12.3g}", target.r_max_mm);
  return text + "\n";
}

std::string fit_glsl(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit) {
  const std::size_t count = fit.levels.size();
  std::vector<std::string> variances;
  std::vector<std::string> weights;
  for (const GaussianLevel& level : fit.levels) {
    variances.push_back(literal(level.variance_mm2));
    weights.push_back(fmt::format("vec3({}, {}, {})", literal(level.weight[0]), literal(level.weight[1]),
                                  literal(level.weight[2])));
  }
  return fmt::format(
      "// {}\n// profile(r) = sum of weight[i] * exp(-r * r / (2 * variance_mm2[i])) / (2 * pi * "
      "variance_mm2[i])\n"
      "const int gaussian_count = {};\n"
      "const float variance_mm2[{}] = float[{}]({});\n"
      "const vec3 weight[{}] = vec3[{}](\n    {});\n",
      caption(profile, asked, fit), count, count, count, fmt::join(variances, ", "), count, count,
      fmt::join(weights, ",\n    "));
}

std::string fit_cpp(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit) {
  std::vector<std::string> rows;
  for (const GaussianLevel& level : fit.levels) {
    rows.push_back(fmt::format("    {{{}f, {{{}f, {}f, {}f}}}}", literal(level.variance_mm2),
                               literal(level.weight[0]), literal(level.weight[1]), literal(level.weight[2])));
  }
  return fmt::format(
      "// {}\n// profile(r) = sum of weight[i] * exp(-r * r / (2 * variance_mm2)) / (2 * pi * variance_mm2)\n"
      "struct Gaussian {{\n  float variance_mm2;\n  float weight[3];  // r, g, b\n}};\n"
      "constexpr Gaussian gaussians[{}] = {{\n{}}};\n",
      caption(profile, asked, fit), fit.levels.size(), fmt::join(rows, ",\n"));
}

}  // namespace truescatter
