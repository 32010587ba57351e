#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "arguments.h"
#include "commands.h"
#include "core/error.h"
#include "core/file.h"
#include "core/parse_number.h"
#include "core/stopwatch.h"
#include "experiment/fit_file.h"
#include "experiment/fit_text.h"
#include "experiment/provenance.h"
#include "report/fit_plot.h"

namespace truescatter::cli {
namespace {

constexpr int kMostSeed = 1000000000;

// A number for every channel, or one for each: "1" or "1,2,3".
Vec3d rgb(const std::string& text, const std::string& name, std::string_view what) {
  const std::vector<std::string_view> words = comma_separated(text);
  if (words.size() != 1 && words.size() != 3)
    throw_input_error(option(name), "\"{}\": {} needs one number, or three as R,G,B", text, what);
  Vec3d values;
  for (std::size_t c = 0; c < 3; ++c)
    values[static_cast<Eigen::Index>(c)] = parse_finite(words[words.size() == 3 ? c : 0], option(name), what);
  return values;
}

void refuse_with(const std::string& given, const std::string& name, const std::string& why) {
  if (!given.empty()) throw_input_error(option(name), "\"{}\": {}", given, why);
}

// The medium by its coefficients, all of them.
void set_coefficients(const FitArguments& arguments, ProfileModelSpec& spec) {
  for (const auto& [name, given] :
       {std::pair("sigma-a", &arguments.sigma_a), std::pair("sigma-s-prime", &arguments.sigma_s_prime),
        std::pair("eta", &arguments.eta)}) {
    if (given->empty()) {
      throw_input_error(option(name),
                        "is missing: a medium is a --material, or --sigma-a, --sigma-s-prime and --eta");
    }
  }
  spec.sigma_a_per_mm = rgb(arguments.sigma_a, "sigma-a", "an absorption in 1/mm");
  spec.sigma_s_prime_per_mm = rgb(arguments.sigma_s_prime, "sigma-s-prime", "a reduced scattering in 1/mm");
  spec.eta = parse_finite(arguments.eta, option("eta"), "an index of refraction");
  if (!(spec.eta > 1.0))
    throw_input_error(option("eta"), "{}: an index of refraction must be above 1", arguments.eta);
  if (spec.sigma_a_per_mm.minCoeff() < 0.0)
    throw_input_error(option("sigma-a"), "\"{}\": an absorption must not be negative", arguments.sigma_a);
  if (!(spec.sigma_s_prime_per_mm.minCoeff() > 0.0))
    throw_input_error(option("sigma-s-prime"), "\"{}\": a reduced scattering must be above 0",
                      arguments.sigma_s_prime);
}

ProfileModelSpec profile_of(const FitArguments& arguments) {
  ProfileModelSpec spec;
  const std::string name = arguments.profile == "dipole" ? "classical-dipole" : arguments.profile;
  spec.model = one_of(name, "profile", {"classical-dipole", "better-dipole", "multipole", "burley", "table"});
  spec.truth = false;
  spec.where = option("profile");
  spec.material = arguments.material;
  spec.material_where = option("material");
  if (spec.model != "table") refuse_with(arguments.table, "table", "goes with --profile table");
  if (spec.model != "burley") refuse_with(arguments.scaling, "scaling", "goes with --profile burley");
  if (spec.model != "multipole") {
    refuse_with(arguments.thickness, "thickness", "goes with --profile multipole");
    refuse_with(arguments.layers, "layers", "goes with --profile multipole");
  }
  const bool of_file = spec.model == "table" || !arguments.layers.empty();
  if (of_file || !spec.material.empty()) {
    const std::string why = of_file ? "is in the file" : "is the material's: give one or the other";
    refuse_with(arguments.sigma_a, "sigma-a", why);
    refuse_with(arguments.sigma_s_prime, "sigma-s-prime", why);
    refuse_with(arguments.eta, "eta", why);
  }
  if (of_file) {
    refuse_with(spec.material, "material", "is in the file");
    if (spec.model == "table" && arguments.table.empty())
      throw_input_error(option("table"), "is missing: a CSV with the header r_mm,r,g,b");
    refuse_with(arguments.thickness, "thickness", "is in the file");
    spec.table = arguments.table;
    spec.layers = arguments.layers;
    return spec;
  }
  if (spec.material.empty()) set_coefficients(arguments, spec);
  if (!arguments.thickness.empty())
    spec.thickness_mm = positive(arguments.thickness, "thickness", "a thickness in mm");
  if (!arguments.scaling.empty())
    spec.scaling = one_of(arguments.scaling, "scaling", {"searchlight", "diffuse", "diffuse-free-path"});
  return spec;
}

// Of two words, of which the first is the default.
bool is_first(const std::string& given, const std::string& name, const std::string& first,
              const std::string& second) {
  return given.empty() || one_of(given, name, {first, second}) == first;
}

bool keeps_albedo(const FitArguments& arguments) {
  return !is_first(arguments.energy, "energy", "free", "albedo");
}

FitSpec fit_of(const FitArguments& arguments) {
  FitSpec fit;
  fit.where = option("gaussians");
  fit.norm_where = option("norm");
  fit.tolerance_where = option("tolerance");
  if (arguments.gaussians == "auto") {
    if (arguments.tolerance.empty())
      throw_input_error(option("tolerance"), "is missing: --gaussians auto finds the fewest that keep to it");
    fit.tolerance = positive(arguments.tolerance, "tolerance", "a relative error");
  } else {
    refuse_with(arguments.tolerance, "tolerance", "goes with --gaussians auto");
    fit.gaussians = parse_integer(arguments.gaussians, option("gaussians"), "a number of Gaussians");
    if (fit.gaussians < 1 || fit.gaussians > kMostGaussians)
      throw_input_error(option("gaussians"), "{} is out of range: 1 to {}, or auto", fit.gaussians,
                        kMostGaussians);
  }
  // Burley's profile has no finite norm r.
  const std::string usual_norm = arguments.profile == "burley" ? "area" : "r";
  fit.norm = arguments.norm.empty() ? usual_norm : one_of(arguments.norm, "norm", {"r", "area", "r2"});
  fit.nonnegative = is_first(arguments.weights, "weights", "non-negative", "free");
  fit.keep_albedo = keeps_albedo(arguments);
  fit.shared_variances = is_first(arguments.variances, "variances", "shared", "per-channel");
  if (!arguments.min_variance.empty())
    fit.min_variance_mm2 = positive(arguments.min_variance, "min-variance", "a variance in mm^2");
  if (!arguments.max_variance.empty())
    fit.max_variance_mm2 = positive(arguments.max_variance, "max-variance", "a variance in mm^2");
  if (!arguments.seed.empty()) {
    fit.seed = parse_integer(arguments.seed, option("seed"), "a seed");
    if (fit.seed < 0 || fit.seed > kMostSeed)
      throw_input_error(option("seed"), "{} is out of range: 0 to {}", fit.seed, kMostSeed);
  }
  return fit;
}

// Null where there is none of this name.
const Profile* published_sum(const std::string& name) {
  const std::vector<Profile>& known = published_sums();
  const auto found =
      std::find_if(known.begin(), known.end(), [&](const Profile& p) { return p.name == name; });
  return found == known.end() ? nullptr : &*found;
}

// A published sum by its name, or the Gaussians of a file.
Profile gaussians_named(const std::string& name) {
  if (const Profile* known = published_sum(name)) return *known;
  if (!std::filesystem::exists(name)) {
    std::vector<std::string> names;
    for (const Profile& p : published_sums()) names.push_back(p.name);
    throw_input_error(option("score"), "\"{}\" is no file, and no published sum; there are: {}", name,
                      fmt::join(names, ", "));
  }
  return sum_of_gaussians(name, read_fit(name));
}

// The files that a fit is made from. What came through a pipe cannot be read again.
std::vector<std::filesystem::path> input_files(const FitArguments& arguments) {
  std::vector<std::filesystem::path> files;
  const bool scores_file = published_sum(arguments.score) == nullptr;
  for (const std::string& file : {arguments.table, arguments.layers, scores_file ? arguments.score : ""})
    if (std::filesystem::is_regular_file(file)) files.emplace_back(file);
  return files;
}

void refuse_with_score(const FitArguments& arguments) {
  for (const auto& [name, given] :
       {std::pair("gaussians", &arguments.gaussians), std::pair("tolerance", &arguments.tolerance),
        std::pair("norm", &arguments.norm), std::pair("weights", &arguments.weights),
        std::pair("variances", &arguments.variances), std::pair("min-variance", &arguments.min_variance),
        std::pair("max-variance", &arguments.max_variance), std::pair("seed", &arguments.seed)})
    refuse_with(*given, name, "goes with a fit, and --score fits nothing");
}

using FileTexts = std::vector<std::pair<std::filesystem::path, std::string>>;

void check_outputs(const std::vector<std::filesystem::path>& paths) {
  std::set<std::filesystem::path> seen;
  for (const std::filesystem::path& path : paths) {
    if (path.empty()) continue;
    check_out(path);
    if (!seen.insert(std::filesystem::weakly_canonical(path)).second)
      throw_input_error({path.string()}, "is named twice: each output needs a file of its own");
  }
}

// All of them or none, but for a rename that fails after others: whole beside their places first, renamed
// when the last is there.
void write_together(const FileTexts& files) {
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> written;
  try {
    for (const auto& [path, text] : files) {
      if (path.empty()) continue;
      written.emplace_back(temporary_sibling(path), path);
      write_text_file(written.back().first, text);
    }
    for (const auto& [temporary, path] : written) commit_temporary(temporary, path);
  } catch (const std::exception&) {
    std::error_code ignored;
    for (const auto& [temporary, path] : written) std::filesystem::remove(temporary, ignored);
    throw;
  }
}

}  // namespace

int fit(const FitArguments& arguments) {
  const bool scores = !arguments.score.empty();
  if (scores) refuse_with_score(arguments);
  if (!scores && arguments.gaussians.empty())
    throw_input_error(option("gaussians"), "is missing: how many, or auto with a --tolerance");
  if (!scores && arguments.out.empty()) throw_input_error(option("out"), "is missing: the FIT.json to write");
  FitSpec asked;
  if (scores) {
    asked.file = arguments.score;
    asked.keep_albedo = keeps_albedo(arguments);
  } else {
    asked = fit_of(arguments);
  }
  check_outputs({arguments.out, arguments.glsl, arguments.cpp, arguments.svg});
  const DiffusionProfile profile = make_diffusion_profile(
      profile_of(arguments),
      [](const std::string& path, const SourceLocation&) { return std::filesystem::path(path); });
  const Stopwatch watch;
  const GaussianFit found = scores ? score(profile, gaussians_named(arguments.score), asked.keep_albedo)
                                   : fit_profile(profile, asked);
  const double took_ms = watch.milliseconds();

  nlohmann::json fitted = fit_json(profile, asked, found);
  fitted["provenance"] = file_provenance(input_files(arguments));
  const std::string json = fitted.dump(2) + "\n";
  const FileTexts files = {{arguments.out, json},
                           {arguments.glsl, fit_glsl(profile, asked, found)},
                           {arguments.cpp, fit_cpp(profile, asked, found)},
                           {arguments.svg, arguments.svg.empty() ? "" : fit_plot_svg(json)}};
  write_together(files);
  fmt::print("{}", fit_table(profile, asked, found));
  fmt::print("{} in {:.0f} ms\n", scores ? "scored" : "fitted", took_ms);
  for (const auto& [path, text] : files)
    if (!path.empty()) fmt::print("{}\n", path.string());
  return 0;
}

}  // namespace truescatter::cli
