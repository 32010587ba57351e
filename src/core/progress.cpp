#include "core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace truescatter {

Progress::Progress(std::string name, std::size_t total)
    : name_(std::move(name)), total_(total), terminal_(isatty(STDERR_FILENO) == 1) {
  if (!terminal_) fmt::print(stderr, "{} ...\n", name_);
}

Progress::~Progress() {
  fmt::print(stderr, "{}{}: {:.1f} s\n", terminal_ ? "\r\x1b[K" : "", name_, elapsed_seconds());
}

double Progress::elapsed_seconds() const { return watch_.seconds(); }

void Progress::advance(std::size_t steps) {
  done_ += steps;
  if (!terminal_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now = watch_.seconds();
  if (now - last_print_seconds_ < 0.1) return;
  last_print_seconds_ = now;
  print_line();
}

void Progress::print_line() {
  const double fraction = total_ > 0 ? static_cast<double>(done_) / static_cast<double>(total_) : 1.0;
  const double left_seconds = fraction > 0.0 ? elapsed_seconds() * (1.0 - fraction) / fraction : 0.0;
  fmt::print(stderr, "\r\x1b[K{}: {:3.0f} %, {:.0f} s left", name_, 100.0 * fraction, left_seconds);
  std::fflush(stderr);
}

}  // namespace truescatter
