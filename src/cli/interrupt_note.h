#pragma once

#include <array>
#include <csignal>
#include <string>

namespace truescatter::cli {

// As long as it lives, SIGINT, SIGTERM and SIGHUP end the program at once, as they do without it, after a
// line on standard error: "truescatter: interrupted; <text>". Every file of ours appears whole or not at all,
// so that nothing has to be waited for. One at a time.
class InterruptNote {
 public:
  explicit InterruptNote(const std::string& text);
  ~InterruptNote();
  InterruptNote(const InterruptNote&) = delete;
  InterruptNote& operator=(const InterruptNote&) = delete;

 private:
  std::array<struct sigaction, 3> before_{};
};

}  // namespace truescatter::cli
