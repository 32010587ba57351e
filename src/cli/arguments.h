#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace truescatter::cli {

// What commands make of the texts that a user gave. Each throws Error (input) that names the option.

SourceLocation option(const std::string& name);

// A finite number above 0.
double positive(std::string_view text, const std::string& name, std::string_view what);

// --memory-limit in bytes, of its GiB; default_memory_limit() where it is empty.
std::uint64_t memory_limit(std::string_view gib);

// The value itself, which is one of those known.
std::string one_of(const std::string& value, const std::string& name, const std::vector<std::string>& known);

// The words between commas, without blanks around them.
std::vector<std::string_view> comma_separated(std::string_view text);

// That a file can be written there: found out before the computing, not after it.
void check_out(const std::filesystem::path& out);

}  // namespace truescatter::cli
