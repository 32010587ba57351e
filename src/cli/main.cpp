#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <string>
#include <vector>

#include "commands.h"
#include "core/error.h"

namespace {

using truescatter::cli::AdviseArguments;
using truescatter::cli::CompareArguments;
using truescatter::cli::FitArguments;
using truescatter::cli::MergeArguments;
using truescatter::cli::RunArguments;
using truescatter::cli::TruthArguments;

constexpr int kUsageError = 2;
constexpr int kRunFailed = 3;

// The parser would only say that a command is missing.
void refuse_unknown_command(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  const std::string known = fmt::format("there are: {} (see --help)", fmt::join(names, ", "));
  if (argc < 2) truescatter::throw_input_error({}, "a command is needed; {}", known);
  const std::string word = argv[1];
  if (word == "--help" || word == "-h" || std::find(names.begin(), names.end(), word) != names.end()) return;
  if (word.starts_with('-'))
    truescatter::throw_input_error({}, "'{}' where a command is needed; {}", word, known);
  truescatter::throw_input_error({}, "there is no command '{}'; {}", word, known);
}

int dispatch(int argc, char** argv) {
  CLI::App app("truescatter: how wrong real-time skin scattering is, where, why, and at what cost",
               "truescatter");
  app.require_subcommand(1);

  RunArguments run_arguments;
  CLI::App* run = app.add_subcommand("run", "Run an experiment and write its report");
  run->add_option("experiment", run_arguments.experiment, "Experiment file (TOML)")->required();
  run->add_option("--out", run_arguments.out, "Folder for the results (default: runs/<name>)");
  run->add_option("--set", run_arguments.overrides, "Override a value: key.key=value (repeatable)")
      ->take_all()
      ->type_size(1)
      ->allow_extra_args(false);
  run->add_option("--jobs", run_arguments.jobs, "Threads for truth and metrics (default: all cores)")
      ->check(CLI::Range(1, 4096));
  run->add_flag("--dry-run", run_arguments.dry_run, "Check the experiment and list what would run");
  std::string gl = "osmesa";
  run->add_option("--gl", gl, "OpenGL by osmesa (software; default) or by egl (a GPU where there is one)")
      ->check(CLI::IsMember({"osmesa", "egl"}));
  run->add_flag(
      "--export-inputs", run_arguments.export_inputs,
      "Write what methods are given of each view as EXR, to inputs/; methods whose picture is not there "
      "yet are skipped");
  run->add_flag("--export-passes", run_arguments.export_passes,
                "Write the textures that methods name on their way as EXR and PNG, to passes/");
  run->add_flag("--buffers", run_arguments.buffers,
                "The same, and what each view has before any method draws: light by light, occlusion, depth, "
                "normals; the report's viewer shows them all");
  run->add_flag("--resume", run_arguments.resume, "Go on from what a run that was cut off has finished")
      ->excludes("--dry-run");
  constexpr const char* kMemoryLimit =
      "Memory in GiB that a run may take: one that is estimated to need more is refused (default: 16, or the "
      "machine's where that is less)";
  run->add_option("--memory-limit", run_arguments.memory_limit, kMemoryLimit);
  CLI::Option* part =
      run->add_option("--part", run_arguments.part,
                      "Compute one share of the pieces alone, INDEX/COUNT: 2/8; merge joins them");
  run->add_flag("--whole-node", run_arguments.whole_node,
                "Nothing else runs on this machine: a part's times are fit for speed charts")
      ->needs(part);
  run->add_flag("--no-cache", run_arguments.no_cache, "Compute every truth, and keep none in the cache");

  TruthArguments truth_arguments;
  CLI::App* truth = app.add_subcommand("truth", "Compute the truth alone, at given points of a mesh");
  truth->add_option("--mesh", truth_arguments.mesh, "Mesh of triangles, in mm")->required();
  truth->add_option("--irradiance", truth_arguments.irradiance, "CSV r,g,b: a row per vertex of the file")
      ->required();
  truth->add_option("--points", truth_arguments.points, "CSV face,b0,b1,b2: faces count from 0")->required();
  truth->add_option("--sigma", truth_arguments.sigma, "Standard deviations in mm: 0.5,1,2");
  truth->add_option("--fit", truth_arguments.fit,
                    "JSON with variances (mm^2) and weights: their sum, in place of --sigma");
  truth->add_option("--metric", truth_arguments.metric, "euclidean or geodesic (default: euclidean)");
  truth->add_option("--r-max", truth_arguments.r_max, "Cut the kernel off at this distance in mm");
  truth->add_option("--engine", truth_arguments.engine,
                    "fast, exact (closed form), brute (plain quadrature) or cgal (the same with geodesic "
                    "distances by CGAL) (default: fast)");
  truth->add_flag("--exact", truth_arguments.exact, "Short for --engine exact");
  truth->add_option(
      "--tolerance", truth_arguments.tolerance,
      "Largest error, in units of the largest irradiance (default: fast 1e-4, brute 1e-10, geodesic brute "
      "and cgal 1e-6; exact goes to rounding)");
  truth->add_option("--mask", truth_arguments.mask, "CSV of one 0 or 1 (skin) per triangle");
  truth->add_option("--jobs", truth_arguments.jobs, "Threads (default: all cores)")
      ->check(CLI::Range(1, 4096));
  truth
      ->add_option(
          "--out", truth_arguments.out,
          "CSV to write: point,sigma,r,g,b,mass, or with --fit point,r,g,b,normalised_r,...,mass_r,...")
      ->required();

  FitArguments fit_arguments;
  CLI::App* fit =
      app.add_subcommand("fit", "Fit Gaussians to a diffusion profile, or score Gaussians against one");
  fit->add_option("--profile", fit_arguments.profile, "dipole, better-dipole, multipole, burley or table")
      ->required();
  fit->add_option("--material", fit_arguments.material, "A material by its name (see list)");
  fit->add_option("--sigma-a", fit_arguments.sigma_a, "Absorption in 1/mm: R,G,B, or one number for all");
  fit->add_option("--sigma-s-prime", fit_arguments.sigma_s_prime, "Reduced scattering in 1/mm: R,G,B");
  fit->add_option("--eta", fit_arguments.eta, "Relative index of refraction, above 1");
  fit->add_option("--thickness", fit_arguments.thickness, "Multipole: the slab's thickness in mm");
  fit->add_option(
      "--layers", fit_arguments.layers,
      "Multipole: CSV thickness_mm,sigma_a_r,..,sigma_s_prime_r,..,eta, a layer a row from the top");
  fit->add_option("--scaling", fit_arguments.scaling,
                  "Burley: searchlight (default), diffuse or diffuse-free-path");
  fit->add_option("--table", fit_arguments.table, "CSV r_mm,r,g,b: R in 1/mm^2 (or r_cm, r_m)");
  fit->add_option("--gaussians", fit_arguments.gaussians, "How many (1 to 16), or auto");
  fit->add_option("--tolerance", fit_arguments.tolerance,
                  "auto: relative error that the worst channel keeps to");
  fit->add_option("--norm", fit_arguments.norm, "r (default), area (default for burley) or r2");
  fit->add_option("--weights", fit_arguments.weights, "non-negative (default) or free");
  fit->add_option("--energy", fit_arguments.energy,
                  "free (default) or albedo: weights sum to the profile's; with --score: scaled to it");
  fit->add_option("--variances", fit_arguments.variances, "shared by the channels (default) or per-channel");
  fit->add_option("--min-variance", fit_arguments.min_variance, "Least variance in mm^2");
  fit->add_option("--max-variance", fit_arguments.max_variance, "Largest variance in mm^2");
  fit->add_option("--seed", fit_arguments.seed, "Of the random starts (default: 1)");
  fit->add_option("--score", fit_arguments.score,
                  "Fit nothing: errors of a published sum (see list) or of a FIT.json's Gaussians");
  fit->add_option("--out", fit_arguments.out, "FIT.json to write");
  fit->add_option("--glsl", fit_arguments.glsl, "GLSL arrays to write");
  fit->add_option("--cpp", fit_arguments.cpp, "C++ array to write");
  fit->add_option("--svg", fit_arguments.svg, "Plot to write");

  CompareArguments compare_arguments;
  CLI::App* compare = app.add_subcommand(
      "compare", "Measure one picture against another, or say what changed between two results");
  compare
      ->add_option("test", compare_arguments.test,
                   "Picture to measure (EXR: its plain R, G, B), or the old result folder")
      ->required();
  compare
      ->add_option("truth", compare_arguments.truth, "Picture to measure against, or the new result folder")
      ->required();
  compare->add_option("--mask", compare_arguments.mask, "Picture that is not 0 where pixels count");
  compare->add_option(
      "--halo", compare_arguments.halo,
      "Measure the halo beside the mask's edge too, for this widest standard deviation in pixels");
  compare->add_flag("--json", compare_arguments.json, "Print JSON");

  AdviseArguments advise_arguments;
  CLI::App* advise = app.add_subcommand(
      "advise", "Say which setting is the cheapest for an error, and what of the model a scene does without");
  advise
      ->add_option("source", advise_arguments.source,
                   "Experiment to run (without methods: a standard set of them), or a result folder")
      ->required();
  advise->add_option("--error", advise_arguments.error, "Largest error: 2% or 0.02 (default: 2%)");
  advise->add_option("--metric", advise_arguments.metric,
                     "rmse (relative; default), p99 (99 % quantile of the error, relative) or halo-peak");
  advise->add_option("--budget", advise_arguments.budget,
                     "Largest cost: 5ms, or 40fetches (per skin pixel): the most accurate within it");
  advise->add_option("--out", advise_arguments.out,
                     "Folder for the experiment's results (default: none are kept)");
  advise->add_option("--jobs", advise_arguments.jobs, "Threads (default: all cores)")
      ->check(CLI::Range(1, 4096));
  advise->add_option("--gl", gl, "OpenGL by osmesa (software; default) or by egl")
      ->check(CLI::IsMember({"osmesa", "egl"}));
  advise->add_option("--memory-limit", advise_arguments.memory_limit, kMemoryLimit);
  advise->add_flag("--json", advise_arguments.json, "Print JSON");

  MergeArguments merge_arguments;
  CLI::App* merge =
      app.add_subcommand("merge", "Join the parts of an experiment (run --part) into one result");
  merge->add_option("parts", merge_arguments.parts, "The parts' folders")->required();
  merge->add_option("--out", merge_arguments.out, "Folder for the results")->required();

  std::string folder;
  CLI::App* report = app.add_subcommand("report", "Write a result folder's report again");
  report->add_option("folder", folder, "Result folder")->required();

  CLI::App* list = app.add_subcommand("list", "List methods, profiles and built-in scenes");

  refuse_unknown_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  run_arguments.gl = gl == "egl" ? truescatter::gpu::Backend::egl : truescatter::gpu::Backend::osmesa;
  advise_arguments.gl = run_arguments.gl;
  if (run->parsed()) return truescatter::cli::run(run_arguments);
  if (truth->parsed()) return truescatter::cli::truth(truth_arguments);
  if (fit->parsed()) return truescatter::cli::fit(fit_arguments);
  if (compare->parsed()) return truescatter::cli::compare(compare_arguments);
  if (advise->parsed()) return truescatter::cli::advise(advise_arguments);
  if (merge->parsed()) return truescatter::cli::merge(merge_arguments);
  if (report->parsed()) return truescatter::cli::report(folder);
  if (list->parsed()) return truescatter::cli::list();
  return kUsageError;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return dispatch(argc, argv);
  } catch (const truescatter::Error& error) {
    fmt::print(stderr, "truescatter: {}\n", error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    fmt::print(stderr, "truescatter: the run failed: {}\n", error.what());
    return kRunFailed;
  }
}
