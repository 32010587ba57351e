#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gpu/context.h"

namespace truescatter::cli {

// The commands of README, Commands. Each returns the exit code: 0 done, 1 a stated threshold was exceeded;
// usage, input and run failures are thrown as Error.

struct RunArguments {
  std::filesystem::path experiment;
  std::filesystem::path out;  // empty: runs/<experiment's name>
  std::vector<std::string> overrides;
  int jobs = 0;  // 0: all cores
  bool dry_run = false;
  gpu::Backend gl = gpu::Backend::osmesa;
  bool export_inputs = false;  // what methods are given of each view is written too
  bool export_passes = false;  // the textures that methods name on their way are written too
  bool buffers = false;        // these, and what a view has before any method draws
  std::string memory_limit;    // in GiB, as the user gave it; empty: default_memory_limit()
  bool no_cache = false;       // truths are neither taken from the cache nor kept there
  bool resume = false;         // goes on from what a run that was cut off has finished
  std::string part;            // "2/8": this share of the pieces alone; empty: all of them
  bool whole_node = false;  // of a part: nothing else runs on the machine, so that times are fit for charts
};
int run(const RunArguments& arguments);

// One result and report out of the parts of an experiment.
struct MergeArguments {
  std::vector<std::filesystem::path> parts;
  std::filesystem::path out;
};
int merge(const MergeArguments& arguments);

// The truth alone, at given points. Numbers are texts here, as the user gave them.
struct TruthArguments {
  std::filesystem::path mesh;
  std::filesystem::path irradiance;
  std::filesystem::path points;
  std::filesystem::path mask;  // empty: every triangle
  std::filesystem::path out;
  std::string sigma;          // comma-separated; empty: fit
  std::filesystem::path fit;  // a sum of Gaussians in place of sigma
  std::string metric;
  std::string engine;     // empty: fast, or exact where that is set
  std::string r_max;      // empty: not cut
  std::string tolerance;  // empty: the engine's default
  bool exact = false;
  int jobs = 0;  // 0: all cores
};
int truth(const TruthArguments& arguments);

// Gaussians in place of a diffusion profile, or the errors of Gaussians that there are. Numbers are texts
// here, as the user gave them; empty ones were not given.
struct FitArguments {
  std::string profile;
  std::string material;
  std::string sigma_a;
  std::string sigma_s_prime;
  std::string eta;
  std::string thickness;
  std::string layers;
  std::string scaling;
  std::string table;
  std::string gaussians;
  std::string tolerance;
  std::string norm;
  std::string weights;
  std::string energy;
  std::string variances;
  std::string min_variance;
  std::string max_variance;
  std::string seed;
  std::string score;  // a built-in profile or a file of Gaussians: nothing is fitted
  std::filesystem::path out;
  std::filesystem::path glsl;
  std::filesystem::path cpp;
  std::filesystem::path svg;
};
int fit(const FitArguments& arguments);

// Two pictures, or two result folders (old, new).
struct CompareArguments {
  std::filesystem::path test;
  std::filesystem::path truth;
  std::filesystem::path mask;  // empty: every pixel
  std::string halo;            // the widest standard deviation in pixels, as the user gave it; empty: no halo
  bool json = false;
};
int compare(const CompareArguments& arguments);

// The cheapest setting of a result, or of an experiment that is run for it, and what the scene does without.
// Numbers are texts here, as the user gave them.
struct AdviseArguments {
  std::filesystem::path source;  // an experiment or a result folder
  std::string error;             // "2%" or "0.02"; empty: 2 %
  std::string metric = "rmse";
  std::string budget;         // "5", "5ms" or "40fetches"; empty: none
  std::filesystem::path out;  // of the experiment's result; empty: it is not kept
  int jobs = 0;               // 0: all cores
  gpu::Backend gl = gpu::Backend::osmesa;
  std::string memory_limit;  // in GiB, as the user gave it; empty: default_memory_limit()
  bool json = false;
};
int advise(const AdviseArguments& arguments);

int report(const std::filesystem::path& folder);

// What there is: methods with their settings, profiles, built-in scenes.
int list();

}  // namespace truescatter::cli
