#include "interrupt_note.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace truescatter::cli {
namespace {

constexpr std::array<int, 3> kSignals = {SIGINT, SIGTERM, SIGHUP};

// A signal's handler can be given nothing, and may not allocate: the one thing here that outlives a function.
std::array<char, 256> line_to_write;
std::size_t line_length = 0;

void say_and_end(int signal_number) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line_to_write.data(), line_length);
  std::signal(signal_number, SIG_DFL);
  std::raise(signal_number);
}

}  // namespace

InterruptNote::InterruptNote(const std::string& text) {
  const std::string line = "\ntruescatter: interrupted; " + text + "\n";
  line_length = std::min(line.size(), line_to_write.size());
  std::copy_n(line.begin(), line_length, line_to_write.begin());
  struct sigaction note {};
  note.sa_handler = say_and_end;
  sigemptyset(&note.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    // What the caller has switched off (nohup) stays off.
    if (before_[i].sa_handler != SIG_IGN) sigaction(kSignals[i], &note, nullptr);
  }
}

InterruptNote::~InterruptNote() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

}  // namespace truescatter::cli
