#include "core/json_text.h"

#include <algorithm>

#include "core/error.h"

namespace truescatter {
namespace {

using nlohmann::json;

// The place of the byte that the library counts from 1.
SourceLocation place_in(const std::string& file, std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte > 0 ? byte - 1 : 0);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  return {file, static_cast<int>(line), static_cast<int>(before.size() - line_start) + 1};
}

// Without the library's preamble, "[json...] parse error at line 1, column 2: ", which says where in its own
// way.
std::string_view complaint(std::string_view message) {
  const std::size_t preamble = message.find("] ");
  if (preamble != std::string_view::npos) message = message.substr(preamble + 2);
  if (!message.starts_with("parse error")) return message;
  const std::size_t reason = message.find(": ");
  return reason == std::string_view::npos ? message : message.substr(reason + 2);
}

}  // namespace

json parse_json(const std::string& file, std::string_view text) {
  try {
    return json::parse(text);
  } catch (const json::parse_error& error) {
    throw_input_error(place_in(file, text, error.byte), "this is not valid JSON: {}",
                      complaint(error.what()));
  } catch (const json::exception& error) {
    throw_input_error({file}, "this is not valid JSON: {}", complaint(error.what()));
  }
}

}  // namespace truescatter
