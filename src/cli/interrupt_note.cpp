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
  for (const int signal_number : kSignals) {
    // What the caller has switched off (nohup) stays off.
    if (std::signal(signal_number, say_and_end) == SIG_IGN) std::signal(signal_number, SIG_IGN);
  }
}

InterruptNote::~InterruptNote() {
  for (const int signal_number : kSignals) std::signal(signal_number, SIG_DFL);
}

}  // namespace truescatter::cli
