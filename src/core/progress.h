#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <string>

#include "core/stopwatch.h"

namespace truescatter {

// Progress of one stage on standard error: one line rewritten with a percentage and the estimated time left
// on a terminal, plain lines (start and end) otherwise. `advance` may be called from any thread.
class Progress {
 public:
  // `total`: number of steps. The stage's name is printed as given.
  Progress(std::string name, std::size_t total);
  // Prints the closing line with the time the stage took.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::size_t steps = 1);
  double elapsed_seconds() const;

 private:
  void print_line();

  std::string name_;
  std::size_t total_;
  std::atomic<std::size_t> done_{0};
  Stopwatch watch_;
  double last_print_seconds_ = 0.0;
  std::mutex mutex_;
  bool terminal_;
};

}  // namespace truescatter
