#include "commands.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arguments.h"
#include "config/experiment_spec.h"
#include "core/error.h"
#include "core/image_io.h"
#include "core/parallel.h"
#include "experiment/memory_estimate.h"
#include "experiment/merge_parts.h"
#include "experiment/metrics_json.h"
#include "experiment/plan.h"
#include "experiment/provenance.h"
#include "experiment/result_folder.h"
#include "experiment/run_experiment.h"
#include "experiment/scene_setup.h"
#include "experiment/sweep.h"
#include "gpu/context.h"
#include "interrupt_note.h"
#include "irradiance/environment.h"
#include "methods/method.h"
#include "metrics/flip.h"
#include "profile/layered.h"
#include "profile/medium.h"
#include "profile/profile.h"
#include "report/changes.h"
#include "report/report.h"
#include "scene/builtin.h"

namespace truescatter::cli {
namespace {

void require_same_size(const Image& a, const std::filesystem::path& a_path, const Image& b,
                       const std::filesystem::path& b_path) {
  if (a.width() == b.width() && a.height() == b.height()) return;
  throw_input_error({a_path.string()}, "is {} x {} pixels, but {} is {} x {}; they must agree", a.width(),
                    a.height(), b_path.string(), b.width(), b.height());
}

// A dash where there is no number.
std::string number_text(const nlohmann::json& of, const char* key) {
  return of.at(key).is_number() ? fmt::format("{:.6g}", of.at(key).get<double>()) : "-";
}

void print_stats(const std::string& name, const nlohmann::json& stats) {
  const auto text = [&](const char* key) { return number_text(stats, key); };
  fmt::print("{:<10} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12}\n", name, text("bias"),
             text("mae"), text("rmse"), text("rel_rmse"), text("p50"), text("p95"), text("p99"), text("max"));
}

void print_halo(const nlohmann::json& halo) {
  const auto line = [&](const std::string& name, const nlohmann::json& of) {
    fmt::print("{:<10} {:>12} {:>12} {:>12} {:>12} {:>12}\n", name, number_text(of, "peak"),
               number_text(of, "width_px"), number_text(of, "energy"), number_text(of, "contrast"),
               of.at("pixels").dump());
  };
  fmt::print("{:<10} {:>12} {:>12} {:>12} {:>12} {:>12}\n", "halo", "peak", "width_px", "energy", "contrast",
             "pixels");
  line("luminance", halo);
  for (const char* channel : {"r", "g", "b"}) line(channel, halo.at("channels").at(channel));
  fmt::print(
      "delta: distance in pixels to the nearest pixel of the mask's edge (beside one outside), in bins of "
      "{:.4g} "
      "px; relative error of a bin sum e / sum truth; peak its largest magnitude; width_px the smallest "
      "delta "
      "beyond which every bin up to 6 s is within 1 %; energy sum |e| / sum truth within 3 s; contrast RMSE "
      "within 3 s / RMSE beyond 6 s; pixels: those within 3 s\n",
      halo.at("profile").at("bin_px").get<double>());
}

bool is_folder(const std::filesystem::path& path) { return std::filesystem::is_directory(path); }

void refuse_mix(const std::filesystem::path& folder, const std::filesystem::path& file) {
  if (!is_folder(folder)) return;
  if (!std::filesystem::exists(file)) throw_input_error({file.string()}, "no such folder");
  throw_input_error({}, "{} is a folder and {} is a file; compare takes two pictures or two result folders",
                    folder.string(), file.string());
}

double halo_std_dev_px(const CompareArguments& arguments) {
  if (arguments.mask.empty())
    throw_input_error(option("halo"), "needs --mask: a halo lies beside the mask's edge");
  return positive(arguments.halo, "halo", "a standard deviation in pixels");
}

int compare_folders(const CompareArguments& arguments) {
  if (!arguments.mask.empty()) throw_input_error({}, "--mask is for pictures; these are result folders");
  if (!arguments.halo.empty()) throw_input_error({}, "--halo is for pictures; these are result folders");
  nlohmann::json changes = result_changes(arguments.test, arguments.truth);
  changes["compared_by"] =
      file_provenance({arguments.test / "results.json", arguments.truth / "results.json"});
  fmt::print("{}", arguments.json ? changes.dump(1) + "\n" : changes_text(changes));
  return 0;
}

constexpr const char* kHowToGoOn = "what is finished is kept; the same command with --resume goes on from it";

void keep_for_resume(ResultFolder& results) {
  results.keep();
  fmt::print(stderr, "note: {}\n", kHowToGoOn);
}

RunOptions options_of(const RunArguments& arguments) {
  RunOptions options{arguments.gl,
                     arguments.export_inputs,
                     arguments.export_passes,
                     arguments.buffers,
                     memory_limit(arguments.memory_limit),
                     arguments.resume};
  if (arguments.part.empty()) return options;
  options.part = parse_part(arguments.part);
  options.times_shared = options.part->count > 1 && !arguments.whole_node;
  return options;
}

RunOutcome run_in(ResultFolder& results, const ExperimentSpec& spec, const RunArguments& arguments,
                  const RunOptions& options) {
  const std::unique_ptr<TruthCache> cache =
      spec.truth.cache && !arguments.no_cache ? open_user_cache() : nullptr;
  try {
    RunOutcome outcome = run_experiment(spec, results.working(), cache.get(), {}, options);
    if (!options.part) write_report(results.working());
    results.publish(options.part.has_value());
    return outcome;
  } catch (const Error& error) {
    // The disk may have room again, and the driver another mood; what an experiment says wrong stays wrong.
    if (error.kind() == ErrorKind::run) keep_for_resume(results);
    throw;
  } catch (const std::exception&) {  // no memory, or what a library has to say
    keep_for_resume(results);
    throw;
  }
}

// The exit code.
int say_exceeded(const RunOutcome& outcome) {
  for (const std::string& line : outcome.exceeded) fmt::print(stderr, "exceeded: {}\n", line);
  return outcome.exceeded.empty() ? 0 : 1;
}

PartRequest request_of(const RunOptions& options) {
  return {*options.part, exports_of(options), std::string(gpu::name_of(options.gl)), options.times_shared};
}

// A result replaces a folder as a whole.
void refuse_part_as_destination(const std::filesystem::path& out,
                                const std::vector<std::filesystem::path>& parts) {
  for (const std::filesystem::path& part : parts) {
    if (overlap(out, part))
      throw_input_error({out.string()}, "is, holds or lies in {}, a part that is to be merged",
                        part.string());
  }
}

std::filesystem::path default_folder(const ExperimentSpec& spec, const std::optional<ExperimentPart>& part) {
  const std::string share = part ? fmt::format(".part-{}-of-{}", part->index, part->count) : "";
  return std::filesystem::path("runs") / (spec.name + share);
}

int dry_run(const ExperimentSpec& spec, const RunOptions& options, const std::filesystem::path& folder) {
  const std::vector<ExperimentSpec> points = sweep_points(spec);
  std::vector<Plan> plans;
  std::string text;
  for (const ExperimentSpec& point : points) {
    plans.push_back(make_plan(point, options.export_inputs));
    const Plan& plan = plans.back();
    refuse_beyond_memory(point, plan, {}, options.memory_limit_bytes);
    check_shaders(plan, options.gl);
    const SceneOutline scene = check_scene(point);
    refuse_beyond_memory(point, plan, size_of(scene), options.memory_limit_bytes);
    text += describe_plan(point, plan, scene) + describe_memory(point, plan, size_of(scene));
  }
  const std::vector<ScenePlan> scenes = scene_plans(points, plans);
  check_destination(folder);
  check_kind_of_result(folder, options.part.has_value());
  const bool finished = options.part && is_finished_part(folder, request_of(options), spec);
  fmt::print("{}{}output {}: {}\n", text, describe_pieces(spec, scenes, options.part, finished, folder),
             folder.string(), std::filesystem::exists(folder) ? "replaces what is there" : "a new folder");
  return 0;
}

}  // namespace

int run(const RunArguments& arguments) {
  const JobLimit limit(arguments.jobs);
  const ExperimentSpec spec = read_experiment(arguments.experiment, arguments.overrides);
  const RunOptions options = options_of(arguments);
  const std::filesystem::path folder =
      arguments.out.empty() ? default_folder(spec, options.part) : arguments.out;
  if (arguments.dry_run) return dry_run(spec, options, folder);
  check_kind_of_result(folder, options.part.has_value());
  if (options.part && options.resume && is_finished_part(folder, request_of(options), spec)) {
    fmt::print(stderr, "part {} is finished already\n", options.part->str());
    fmt::print("{}\n", folder.string());
    return 0;
  }
  ResultFolder results(folder, arguments.resume);
  const InterruptNote note(kHowToGoOn);
  const RunOutcome outcome = run_in(results, spec, arguments, options);
  fmt::print("{}\n", (options.part ? folder : folder / "report.html").string());
  return say_exceeded(outcome);
}

int merge(const MergeArguments& arguments) {
  refuse_part_as_destination(arguments.out, arguments.parts);
  check_kind_of_result(arguments.out, false);
  const std::vector<PartResult> parts = read_parts(arguments.parts);
  ResultFolder results(arguments.out);
  const RunOutcome outcome = merge_parts(parts, results.working());
  write_report(results.working());
  results.publish();
  fmt::print("{}\n", (arguments.out / "report.html").string());
  return say_exceeded(outcome);
}

int compare(const CompareArguments& arguments) {
  if (is_folder(arguments.test) && is_folder(arguments.truth)) return compare_folders(arguments);
  refuse_mix(arguments.test, arguments.truth);
  refuse_mix(arguments.truth, arguments.test);
  const Image test = read_rgb(arguments.test);
  const Image truth = read_rgb(arguments.truth);
  require_same_size(test, arguments.test, truth, arguments.truth);
  Image mask(truth.width(), truth.height(), 1, 1.0F);
  if (!arguments.mask.empty()) {
    mask = read_image(arguments.mask);
    require_same_size(mask, arguments.mask, truth, arguments.truth);
  }
  nlohmann::json stats = error_stats_json(test, truth, mask);
  put_number(stats, "flip", mean_inside(flip_map(truth, test), mask), "no pixel to measure");
  put_number(stats, "flip_hdr", mean_inside(HdrFlipReference(truth, mask).map(test), mask),
             "no pixel to measure");
  if (!arguments.halo.empty()) stats["halo"] = mask_halo_json(test, truth, mask, halo_std_dev_px(arguments));
  if (arguments.json) {
    std::vector<std::filesystem::path> pictures = {arguments.test, arguments.truth};
    if (!arguments.mask.empty()) pictures.push_back(arguments.mask);
    stats["provenance"] = file_provenance(pictures);
    fmt::print("{}\n", stats.dump(1));
    return 0;
  }
  fmt::print("{:<10} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12}\n", "", "bias", "mae", "rmse",
             "rel_rmse", "p50", "p95", "p99", "max");
  print_stats("luminance", stats);
  for (const char* channel : {"r", "g", "b"}) print_stats(channel, stats.at("channels").at(channel));
  fmt::print(
      "e = test - truth over n pixels; bias (1/n) sum e; mae (1/n) sum |e|; rmse sqrt((1/n) sum e^2); "
      "rel_rmse rmse / "
      "sqrt((1/n) sum truth^2); p50, p95, p99 quantiles of |e| (nearest rank); max largest |e|; luminance of "
      "Rec. "
      "709\nFLIP: mean of LDR-FLIP, 1 as the display's white; HDR-FLIP: mean of its largest over exposures "
      "(both "
      "0 to 1, 67 pixels a degree)\n");
  fmt::print("{} pixels; errors are test - truth; FLIP {}, HDR-FLIP {}\n", stats.at("pixels").dump(),
             stats.at("flip").dump(), stats.at("flip_hdr").dump());
  if (stats.contains("halo")) print_halo(stats.at("halo"));
  return 0;
}

int report(const std::filesystem::path& folder) {
  write_report(folder);
  fmt::print("{}\n", (folder / "report.html").string());
  return 0;
}

int list() {
  fmt::print("methods\n");
  for (const Method& method : all_methods()) {
    fmt::print("  {:<18} {} ({}){}\n", method.name, method.title, method.source,
               method.needs_uvs ? "; needs UVs" : "");
    for (const SettingSpec& s : method.settings) {
      if (s.choices.empty()) {
        fmt::print("      {} = {} in [{}, {}]: {}\n", s.name, s.default_number, s.minimum, s.maximum, s.help);
      } else {
        fmt::print("      {} = {}: {}\n", s.name, fmt::join(s.choices, " | "), s.help);
      }
    }
  }
  fmt::print("profiles\n");
  for (const Profile& profile : builtin_profiles()) fmt::print("  {:<22} {}\n", profile.name, profile.source);
  fmt::print("published sums of Gaussians, to score with fit --score\n");
  for (const Profile& sum : published_sums()) fmt::print("  {:<28} {}\n", sum.name, sum.source);
  fmt::print("materials (1/mm)\n");
  for (const Material& m : materials()) {
    fmt::print("  {:<22} sigma_s' {}, {}, {}; sigma_a {}, {}, {}; eta {}\n", m.name,
               m.sigma_s_prime_per_mm[0], m.sigma_s_prime_per_mm[1], m.sigma_s_prime_per_mm[2],
               m.sigma_a_per_mm[0], m.sigma_a_per_mm[1], m.sigma_a_per_mm[2], m.eta);
  }
  for (const LayeredMaterial& m : layered_materials())
    fmt::print("  {:<22} {} layers, for the multipole\n", m.name, m.channels[0].size());
  fmt::print("built-in environments\n");
  for (const BuiltinEnvironment& environment : builtin_environments())
    fmt::print("  builtin:{:<10} {}\n", environment.name, environment.summary);
  fmt::print("built-in scenes\n");
  for (const BuiltinScene& scene : builtin_scenes()) {
    fmt::print("  builtin:{:<10} {}\n", scene.name, scene.summary);
    for (const BuiltinParameter& p : scene.parameters) {
      fmt::print("      {} = {} in [{}, {}]: {}\n", p.name, p.default_value, p.minimum, p.maximum, p.help);
    }
  }
  return 0;
}

}  // namespace truescatter::cli
