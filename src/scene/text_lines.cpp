#include "scene/text_lines.h"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <system_error>
#include <utility>

namespace truescatter {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

// std::from_chars takes no plus sign.
std::string_view without_plus(std::string_view word) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

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

double parse_finite(std::string_view word, const SourceLocation& where, std::string_view what) {
  const std::string_view digits = without_plus(word);
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool whole = end == digits.data() + digits.size();
  if (error == std::errc::result_out_of_range && whole) {
    // Too small for a double is as good as zero; too large is not finite.
    const bool tiny =
        digits.find("e-") != std::string_view::npos || digits.find("E-") != std::string_view::npos;
    if (tiny) return 0.0;
  } else if (error != std::errc() || !whole) {
    throw_input_error(where, "\"{}\" is not a number: {} must be a finite number", word, what);
  }
  if (error != std::errc() || !std::isfinite(value)) {
    throw_input_error(where, "\"{}\" is not finite: {} must be a finite number", word, what);
  }
  return value;
}

int parse_integer(std::string_view word, const SourceLocation& where, std::string_view what) {
  const std::string_view digits = without_plus(word);
  int value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    throw_input_error(where, "\"{}\" is not a whole number that {} can be", word, what);
  }
  return value;
}

}  // namespace truescatter
