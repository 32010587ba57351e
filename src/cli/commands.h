#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace truescatter::cli {

// The commands of DESIGN section 4. Each returns the exit code: 0 done, 1 a stated threshold was exceeded;
// usage, input and run failures are thrown as Error.

struct RunArguments {
  std::filesystem::path experiment;
  std::filesystem::path out;  // empty: runs/<experiment's name>
  std::vector<std::string> overrides;
  int jobs = 0;  // 0: all cores
  bool dry_run = false;
};
int run(const RunArguments& arguments);

// Two pictures, or two result folders (old, new).
struct CompareArguments {
  std::filesystem::path test;
  std::filesystem::path truth;
  std::filesystem::path mask;  // empty: every pixel
  bool json = false;
};
int compare(const CompareArguments& arguments);

int report(const std::filesystem::path& folder);

// What there is: methods with their settings, profiles, built-in scenes.
int list();

}  // namespace truescatter::cli
