#include "arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/parse_number.h"
#include "experiment/memory_estimate.h"

namespace truescatter::cli {

SourceLocation option(const std::string& name) { return {"--" + name, 0, 0}; }

double positive(std::string_view text, const std::string& name, std::string_view what) {
  const double value = parse_finite(text, option(name), what);
  if (value <= 0.0) throw_input_error(option(name), "\"{}\": {} must be above 0", text, what);
  return value;
}

std::uint64_t memory_limit(std::string_view gib) {
  constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;
  constexpr double kMostGiB = 1e6;  // more than any machine's, and its bytes are within 64 bits
  if (gib.empty()) return default_memory_limit();
  return static_cast<std::uint64_t>(kGiB *
                                    std::min(positive(gib, "memory-limit", "a limit in GiB"), kMostGiB));
}

std::string one_of(const std::string& value, const std::string& name, const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), value) == known.end()) {
    throw_input_error(option(name), "\"{}\" is not known; there are: {}", value, fmt::join(known, ", "));
  }
  return value;
}

std::vector<std::string_view> comma_separated(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t comma = text.find(',');
    std::string_view word = text.substr(0, comma);
    while (word.starts_with(' ')) word.remove_prefix(1);
    while (word.ends_with(' ')) word.remove_suffix(1);
    words.push_back(word);
    if (comma == std::string_view::npos) return words;
    text.remove_prefix(comma + 1);
  }
}

void check_out(const std::filesystem::path& out) {
  const std::filesystem::path folder = out.has_parent_path() ? out.parent_path() : ".";
  if (!std::filesystem::is_directory(folder))
    throw_input_error({out.string()}, "cannot be written: there is no folder {}", folder.string());
  if (out.filename().empty() || std::filesystem::is_directory(out))
    throw_input_error({out.string()}, "is a folder; the name of a file is needed");
}

}  // namespace truescatter::cli
