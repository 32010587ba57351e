#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <toml.hpp>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace truescatter {

// Parses a TOML file. Throws Error (input) that names the file, and the line where its syntax is wrong.
toml::value read_toml_file(const std::filesystem::path& file);

// A value as TOML that fits on one line; numbers have the fewest digits that give the same double.
std::string inline_text(const toml::value& value);

// A table of a TOML file that remembers which keys were asked for, so that unknown ones are errors.
class TomlTable {
 public:
  // `path`: the table's dotted name, for messages; empty for the root.
  TomlTable(const toml::value& value, std::string path);

  bool has(const std::string& key) const;
  // Each getter throws Error (input) at the value if it is of another type or breaks the stated rule; without
  // a default, a missing key is an error.
  std::string text(const std::string& key);
  std::string text(const std::string& key, const std::string& fallback);
  std::vector<std::string> texts(const std::string& key);  // an array of strings; empty if missing
  std::string one_of(const std::string& key, const std::string& fallback,
                     const std::vector<std::string>& allowed);
  std::vector<double> numbers(const std::string& key, double minimum, double maximum);  // empty if missing
  double number(const std::string& key, double fallback, double minimum, double maximum);
  double number(const std::string& key, double minimum, double maximum);
  int whole(const std::string& key, int fallback, int minimum, int maximum);
  bool flag(const std::string& key, bool fallback);
  Vec3d vec3(const std::string& key);
  Vec3d vec3(const std::string& key, const Vec3d& fallback);
  // A number for all three channels, or three.
  Vec3d rgb(const std::string& key);
  Vec3d rgb(const std::string& key, const Vec3d& fallback);
  TomlTable table(const std::string& key);                // empty if missing
  std::vector<TomlTable> tables(const std::string& key);  // empty if missing
  const toml::value& raw(const std::string& key);
  std::vector<std::string> keys() const;

  SourceLocation where() const { return location_of(*value_); }
  SourceLocation where(const std::string& key) const;
  // An error about the value of a key, with the line underlined.
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;
  // Keys that may be there, asked for or not.
  void allow(const std::set<std::string>& keys) { known_.insert(keys.begin(), keys.end()); }
  // Throws on a key that nobody asked for, listing those that there are.
  void finish() const;

  // A value of a command line's override has its "--set ..." for a file, and neither line nor column.
  static SourceLocation location_of(const toml::value& value);

 private:
  const toml::value* find(const std::string& key);
  std::string full_name(const std::string& key) const;
  [[noreturn]] void fail_missing(const std::string& key) const;

  const toml::value* value_;
  std::string path_;
  std::set<std::string> known_;
};

// Throws Error (input) at a value: "file:line:column: message" and the line with the value underlined.
[[noreturn]] void fail_at(const toml::value& value, const std::string& message);

}  // namespace truescatter
