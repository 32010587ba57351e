#include "core/parse_number.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace truescatter {
namespace {

// std::from_chars takes no plus sign.
std::string_view without_plus(std::string_view word) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

}  // namespace

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
