#include "scene/text_lines.h"

#include <cstddef>
#include <utility>

namespace truescatter {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

}  // namespace

TextLines::TextLines(std::string name, std::string_view text) : name_(std::move(name)), rest_(text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (rest_.substr(0, kByteOrderMark.size()) == kByteOrderMark) rest_.remove_prefix(kByteOrderMark.size());
}

bool TextLines::next() {
  while (!rest_.empty()) {
    words_.clear();
    line_ = lines_taken_ + 1;
    while (take_line()) {
    }
    if (!words_.empty()) return true;
  }
  words_.clear();
  return false;
}

// Appends the words of one line of the text. True if a backslash asks for another.
bool TextLines::take_line() {
  const std::size_t end = rest_.find('\n');
  std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  ++lines_taken_;
  line = line.substr(0, line.find('#'));
  bool goes_on = false;
  while (!line.empty()) {
    const std::size_t start = line.find_first_not_of(kBlanks);
    if (start == std::string_view::npos) break;
    line.remove_prefix(start);
    const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
    line.remove_prefix(word.size());
    goes_on = word == "\\";
    if (!goes_on) words_.push_back(word);
  }
  return goes_on && !rest_.empty();
}

}  // namespace truescatter
