#pragma once

#include <string_view>

#include "core/error.h"

namespace truescatter {

// A whole word as a number, a leading '+' allowed. Each throws Error (input) with the word and the rule that
// it breaks; `what` names the number in the message.

// A finite number. What is too small for a double is 0.
double parse_finite(std::string_view word, const SourceLocation& where, std::string_view what);

// A whole number that fits into an int.
int parse_integer(std::string_view word, const SourceLocation& where, std::string_view what);

}  // namespace truescatter
