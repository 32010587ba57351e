#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/parse_number.h"

namespace truescatter {

// Walks over the words of a text, line by line, and knows where it is. '#' begins a comment; lines without
// a word are skipped; a backslash at the end joins a line with the next. Internal to the loaders.
class TextLines {
 public:
  TextLines(std::string name, std::string_view text);

  // Moves to the next line that has words. False at the end.
  bool next();

  const std::vector<std::string_view>& words() const { return words_; }
  SourceLocation where() const { return {name_, line_, 0}; }
  int line() const { return line_; }
  // What has not been walked over yet: the binary part behind a text header.
  std::string_view rest() const { return rest_; }

 private:
  bool take_line();

  std::string name_;
  std::string_view rest_;
  std::vector<std::string_view> words_;
  int line_ = 0;
  int lines_taken_ = 0;
};

}  // namespace truescatter
