// What many runs leave behind, in one process and in a cache. scripts/soak reads what it prints.
//
//   soak runs COUNT EXPERIMENT...
//     Runs the experiments in turn, COUNT runs in all: a round without a cache, a round with one that lasts
//     as long as the process. Prints CSV, a line after each run: run, experiment, cached, resident_kib (of
//     the process), heap_kib (of that, what malloc has handed out), files (open descriptors), threads.
//
//   soak entries FOLDER
//     Reads every entry of a folder of cached truths as a run does, and prints how many are whole and how
//     many are damaged: "17 0".
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "core/parse_number.h"
#include "experiment/result_folder.h"
#include "experiment/run_experiment.h"
#include "report/report.h"
#include "support/temp_dir.h"
#include "truth/cache.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kCacheLimitBytes = 64U << 20U;
constexpr const char* kUsage = "soak runs COUNT EXPERIMENT... | soak entries FOLDER";

// The second field of statm: resident pages.
long resident_kib() {
  std::ifstream statm("/proc/self/statm");
  long size_pages = 0;
  long resident_pages = 0;
  if (!(statm >> size_pages >> resident_pages)) throw_run_error({"/proc/self/statm"}, "cannot be read");
  return resident_pages * (sysconf(_SC_PAGESIZE) / 1024);
}

long heap_kib() {
  const struct mallinfo2 heap = mallinfo2();
  return static_cast<long>((heap.uordblks + heap.hblkhd) / 1024);
}

// The listing's own descriptor is among those of fd: it is the same each time.
auto entries_in(const char* folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

// All that `truescatter run` does.
void run_once(const ExperimentSpec& spec, const fs::path& folder, TruthCache* cache) {
  ResultFolder results(folder);
  run_experiment(spec, results.working(), cache);
  write_report(results.working());
  results.publish();
}

void run_in_turn(int count, const std::vector<fs::path>& experiments) {
  const test::TempDir folder;
  TruthCache cache(folder.path() / "cache", kCacheLimitBytes);
  fmt::print("run,experiment,cached,resident_kib,heap_kib,files,threads\n");
  for (int i = 0; i < count; ++i) {
    const std::size_t turn = static_cast<std::size_t>(i);
    const fs::path& file = experiments[turn % experiments.size()];
    const bool cached = turn / experiments.size() % 2 == 1;
    run_once(read_experiment(file), folder.path() / file.stem(), cached ? &cache : nullptr);
    fmt::print("{},{},{:d},{},{},{},{}\n", i + 1, file.stem().string(), cached, resident_kib(), heap_kib(),
               entries_in("/proc/self/fd"), entries_in("/proc/self/task"));
    std::fflush(stdout);
  }
}

// How many bytes an entry has beside its points: an entry without points says so.
std::uintmax_t bytes_beside_points() {
  const test::TempDir folder;
  TruthCache(folder.path(), kCacheLimitBytes).store("0", {});
  return fs::file_size(fs::directory_iterator(folder.path())->path());
}

// A damaged entry is removed as it is found.
void read_entries(const fs::path& folder) {
  const std::uintmax_t beside = bytes_beside_points();
  TruthCache cache(folder, kCacheLimitBytes);
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.path().filename().string().starts_with('.')) entries.push_back(entry.path());
  }
  std::size_t whole = 0;
  for (const fs::path& entry : entries) {
    const std::uintmax_t bytes = fs::file_size(entry);
    const std::uintmax_t points = bytes < beside ? 0 : (bytes - beside) / sizeof(Vec4d);
    if (cache.find(entry.stem().string(), points)) ++whole;
  }
  fmt::print("{} {}\n", whole, entries.size() - whole);
}

int dispatch(std::span<char*> arguments) {
  const std::string what = arguments.size() > 2 ? arguments[1] : "";
  if (what == "runs" && arguments.size() > 3) {
    const int count = parse_integer(arguments[2], {}, "how many runs");
    run_in_turn(count, {arguments.begin() + 3, arguments.end()});
  } else if (what == "entries" && arguments.size() == 3) {
    read_entries(arguments[2]);
  } else {
    throw_input_error({}, "{}", kUsage);
  }
  return 0;
}

}  // namespace
}  // namespace truescatter

int main(int argc, char** argv) {
  try {
    return truescatter::dispatch({argv, static_cast<std::size_t>(argc)});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
