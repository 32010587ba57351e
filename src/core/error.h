#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace truescatter {

// What an error means to the caller of the program; the value is the exit code (README, Commands).
enum class ErrorKind {
  input = 2,  // wrong usage or input: the user can mend it
  run = 3,    // the run failed: an audit, a driver, a full disk
};

// Where in the user's input an error lies. Lines and columns count from 1; 0 means "not known".
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;
  std::string excerpt = {};  // the lines that show the place, underlined; empty: there are none

  // "file:line:column", without the parts that are not known.
  std::string str() const {
    std::string text = file;
    if (line > 0) text += fmt::format(":{}", line);
    if (line > 0 && column > 0) text += fmt::format(":{}", column);
    return text;
  }
};

// The only exception type that the project throws. The message names the offending value and the rule
// that it breaks; `where` names the file and line, and shows them. Our own mistakes are assertions, not
// errors.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, SourceLocation where, const std::string& message)
      : std::runtime_error((where.file.empty() ? message : where.str() + ": " + message) +
                           (where.excerpt.empty() ? "" : "\n" + where.excerpt)),
        kind_(kind),
        where_(std::move(where)) {}

  ErrorKind kind() const { return kind_; }
  int exit_code() const { return static_cast<int>(kind_); }
  const SourceLocation& where() const { return where_; }

 private:
  ErrorKind kind_;
  SourceLocation where_;
};

template <typename... Args>
[[noreturn]] void throw_input_error(SourceLocation where, fmt::format_string<Args...> format,
                                    Args&&... args) {
  throw Error(ErrorKind::input, std::move(where), fmt::format(format, std::forward<Args>(args)...));
}

template <typename... Args>
[[noreturn]] void throw_run_error(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(ErrorKind::run, {}, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace truescatter
