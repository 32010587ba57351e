#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <optional>

#include "arguments.h"
#include "commands.h"
#include "config/experiment_spec.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/parse_number.h"
#include "experiment/provenance.h"
#include "experiment/result_folder.h"
#include "experiment/run_experiment.h"
#include "experiment/scene_needs.h"
#include "report/advice.h"
#include "report/report.h"
#include "report/results_file.h"

namespace truescatter::cli {
namespace {

using nlohmann::json;

// The frames in which the standard methods are weighed, of which the dense ones take seconds at a portrait's
// size.
constexpr int kStandardFramePx = 160;

double share(const std::string& text) {
  const bool percent = text.ends_with('%');
  const std::string number = percent ? text.substr(0, text.size() - 1) : text;
  const double value = positive(number, "error", "an error");
  if (!percent && value >= 1.0) {
    throw_input_error(option("error"), "\"{}\": without a % an error is a share, below 1; \"{}%\" is percent",
                      text, text);
  }
  return percent ? value / 100.0 : value;
}

AdviceRequest request_of(const AdviseArguments& arguments) {
  AdviceRequest request;
  if (!arguments.error.empty()) request.error = share(arguments.error);
  request.metric = one_of(arguments.metric, "metric", {"rmse", "halo-peak", "p99"});
  if (arguments.budget.empty()) return request;
  std::string number = arguments.budget;
  for (const std::string unit : {"fetches", "ms"}) {
    if (!number.ends_with(unit)) continue;
    request.by_fetches = unit == "fetches";
    number.resize(number.size() - unit.size());
    break;
  }
  while (number.ends_with(' ')) number.pop_back();
  request.budget = positive(number, "budget", "a budget");
  return request;
}

// The experiment with what nobody looks at left out, where its methods are not its own.
ExperimentSpec advised(ExperimentSpec spec) {
  if (!spec.standard_methods) return spec;
  spec.truth.geodesic = "off";
  spec.truth.light_paths = 0;
  for (ViewSpec& view : spec.views) {
    const int longest = std::max(view.width_px, view.height_px);
    if (longest <= kStandardFramePx) continue;
    view.width_px = std::max(1, view.width_px * kStandardFramePx / longest);
    view.height_px = std::max(1, view.height_px * kStandardFramePx / longest);
  }
  return spec;
}

json run_and_read(const ExperimentSpec& spec, const AdviseArguments& arguments, TruthCache* cache) {
  // Without --out the folder is never published, and goes with the object, or with the next one's.
  const bool keep = !arguments.out.empty();
  const std::filesystem::path folder =
      keep ? arguments.out : std::filesystem::temp_directory_path() / "truescatter-advise";
  if (!keep) discard_leftovers(folder);
  ResultFolder results(folder);
  RunOptions options;
  options.gl = arguments.gl;
  options.memory_limit_bytes = memory_limit(arguments.memory_limit);
  run_experiment(spec, results.working(), cache, {}, options);
  json read = read_results(results.working());
  if (!keep) return read;
  write_report(results.working());
  results.publish();
  return read;
}

json model_of(const ExperimentSpec& spec, const AdviseArguments& arguments, double error, TruthCache* cache) {
  NeedOptions options;
  options.gl = arguments.gl;
  options.cache = cache;
  options.memory_limit_bytes = memory_limit(arguments.memory_limit);
  const json needs = scene_needs(spec, options);
  return {{"parts", model_advice(needs, error)}, {"measured", needs}};
}

// The same for a result, whose experiment may have lost its files since.
json model_of_result(const AdviseArguments& arguments, double error) {
  const std::filesystem::path resolved = arguments.source / "experiment.resolved.toml";
  const auto missing = [](const std::string& why) {
    return json{{"parts", nullptr}, {"reason", why + "; advise on the experiment itself measures it"}};
  };
  if (!std::filesystem::exists(resolved)) return missing("there is no " + resolved.string());
  try {
    const ExperimentSpec spec = read_experiment(resolved);
    const std::unique_ptr<TruthCache> cache = spec.truth.cache ? open_user_cache() : nullptr;
    return model_of(spec, arguments, error, cache.get());
  } catch (const Error& problem) {
    if (problem.kind() != ErrorKind::input) throw;
    return missing(problem.what());
  }
}

}  // namespace

int advise(const AdviseArguments& arguments) {
  const AdviceRequest request = request_of(arguments);
  const JobLimit limit(arguments.jobs);
  json found;
  if (std::filesystem::is_directory(arguments.source)) {
    if (!arguments.memory_limit.empty())
      throw_input_error(option("memory-limit"), "is for an experiment; this is a result folder");
    if (!arguments.out.empty())
      throw_input_error(option("out"), "is for an experiment; this is a result folder");
    const json results = read_results(arguments.source);
    found = advice(results, request);
    found["provenance"] = results.value("provenance", json());
    found["model"] = model_of_result(arguments, request.error);
  } else {
    const ExperimentSpec own = read_experiment_or_standard(arguments.source);
    const ExperimentSpec spec = advised(own);
    const std::unique_ptr<TruthCache> cache = spec.truth.cache ? open_user_cache() : nullptr;
    const json results = run_and_read(spec, arguments, cache.get());
    found = advice(results, request);
    found["provenance"] = results.at("provenance");
    found["standard_methods"] = spec.standard_methods;
    found["model"] = model_of(own, arguments, request.error, cache.get());
  }
  found["advised_by"] = program_provenance();
  fmt::print("{}", arguments.json ? found.dump(1) + "\n" : advice_text(found));
  return found.at("meets").get<bool>() ? 0 : 1;
}

}  // namespace truescatter::cli
