#include "config/toml_reader.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "core/file.h"

namespace truescatter {
namespace {

const toml::value& empty_table() {
  static const toml::value table = toml::table{};
  return table;
}

double as_number(const toml::value& value, const std::string& name) {
  double number = std::nan("");
  if (value.is_integer()) {
    number = static_cast<double>(value.as_integer());
  } else if (value.is_floating()) {
    number = value.as_floating();
  } else {
    fail_at(value, fmt::format("'{}' must be a number", name));
  }
  if (!std::isfinite(number)) fail_at(value, fmt::format("'{}' must be finite", name));
  return number;
}

Vec3d as_vec3(const toml::value& value, const std::string& name) {
  if (!value.is_array() || value.as_array().size() != 3) {
    fail_at(value, fmt::format("'{}' must be an array of three numbers", name));
  }
  Vec3d v;
  for (std::size_t i = 0; i < 3; ++i) v[static_cast<Eigen::Index>(i)] = as_number(value.as_array()[i], name);
  return v;
}

}  // namespace

toml::value read_toml_file(const std::filesystem::path& file) {
  const std::string text = read_text_file(file);
  try {
    std::istringstream stream(text);
    return toml::parse(stream, file.string());
  } catch (const toml::exception& error) {
    // The column that toml11 gives is that of the line's beginning; the underlined text below shows the
    // place.
    std::string message = error.what();
    if (const std::size_t reason = message.find(": ");
        message.starts_with("[error]") && reason < message.find('\n')) {
      message.erase(0, reason + 2);
    }
    throw Error(ErrorKind::input, {file.string(), static_cast<int>(error.location().line())},
                "not valid TOML: " + message);
  }
}

void fail_at(const toml::value& value, const std::string& message) {
  throw Error(ErrorKind::input, TomlTable::location_of(value), message);
}

std::string inline_text(const toml::value& value) {
  std::vector<std::string> parts;
  if (value.is_floating()) return fmt::format("{}", value.as_floating());
  if (value.is_array()) {
    for (const toml::value& entry : value.as_array()) parts.push_back(inline_text(entry));
    return fmt::format("[{}]", fmt::join(parts, ", "));
  }
  if (value.is_table()) {
    for (const auto& [key, entry] : value.as_table()) parts.push_back(key + " = " + inline_text(entry));
    return fmt::format("{{{}}}", fmt::join(parts, ", "));
  }
  std::ostringstream stream;
  stream << value;
  return stream.str();
}

TomlTable::TomlTable(const toml::value& value, std::string path) : value_(&value), path_(std::move(path)) {
  if (!value.is_table()) fail_at(value, fmt::format("'{}' must be a table", path_));
}

SourceLocation TomlTable::location_of(const toml::value& value) {
  const toml::source_location location = value.location();
  if (location.file_name() == "unknown file") return {};  // an absent table
  if (location.file_name().starts_with("--set ")) return {location.file_name()};
  SourceLocation where{location.file_name(), static_cast<int>(location.line()),
                       static_cast<int>(location.column())};
  const std::string number = fmt::format("{}", where.line);
  const std::string line = location.line_str();
  const auto before = std::min(line.size(), static_cast<std::size_t>(std::max(0, where.column - 1)));
  // Tabs stay tabs, and what goes on in other lines is not underlined.
  std::string pad = line.substr(0, before);
  std::replace_if(
      pad.begin(), pad.end(), [](char c) { return c != '\t'; }, ' ');
  const std::size_t length =
      std::clamp<std::size_t>(location.region(), 1, std::max<std::size_t>(1, line.size() - before));
  where.excerpt = fmt::format(" {} | {}\n {} | {}^{}", number, line, std::string(number.size(), ' '), pad,
                              std::string(length - 1, '~'));
  return where;
}

SourceLocation TomlTable::where(const std::string& key) const {
  const auto& table = value_->as_table();
  const auto at = table.find(key);
  return at != table.end() ? location_of(at->second) : location_of(*value_);
}

std::string TomlTable::full_name(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

const toml::value* TomlTable::find(const std::string& key) {
  known_.insert(key);
  const auto& table = value_->as_table();
  const auto at = table.find(key);
  return at != table.end() ? &at->second : nullptr;
}

bool TomlTable::has(const std::string& key) const { return value_->as_table().count(key) > 0; }

void TomlTable::fail(const std::string& key, const std::string& message) const {
  const auto& table = value_->as_table();
  const auto at = table.find(key);
  fail_at(at != table.end() ? at->second : *value_, message);
}

void TomlTable::fail_missing(const std::string& key) const {
  fail_at(*value_, fmt::format("'{}' is missing", full_name(key)));
}

std::string TomlTable::text(const std::string& key) {
  const toml::value* value = find(key);
  if (value == nullptr) fail_missing(key);
  if (!value->is_string()) fail_at(*value, fmt::format("'{}' must be a string", full_name(key)));
  return value->as_string().str;
}

std::string TomlTable::text(const std::string& key, const std::string& fallback) {
  return find(key) == nullptr ? fallback : text(key);
}

std::vector<std::string> TomlTable::texts(const std::string& key) {
  const toml::value* value = find(key);
  std::vector<std::string> result;
  if (value == nullptr) return result;
  if (!value->is_array()) fail_at(*value, fmt::format("'{}' must be an array of strings", full_name(key)));
  for (const toml::value& entry : value->as_array()) {
    if (!entry.is_string()) fail_at(entry, fmt::format("'{}' must hold strings only", full_name(key)));
    result.push_back(entry.as_string().str);
  }
  return result;
}

std::string TomlTable::one_of(const std::string& key, const std::string& fallback,
                              const std::vector<std::string>& allowed) {
  const std::string word = text(key, fallback);
  if (std::find(allowed.begin(), allowed.end(), word) == allowed.end()) {
    fail(key, fmt::format("'{}' is \"{}\"; it must be one of: {}", full_name(key), word,
                          fmt::join(allowed, ", ")));
  }
  return word;
}

double TomlTable::number(const std::string& key, double minimum, double maximum) {
  const toml::value* value = find(key);
  if (value == nullptr) fail_missing(key);
  const double number = as_number(*value, full_name(key));
  if (!(number >= minimum && number <= maximum)) {
    fail_at(*value,
            fmt::format("'{}' is {}; it must lie in [{}, {}]", full_name(key), number, minimum, maximum));
  }
  return number;
}

std::vector<double> TomlTable::numbers(const std::string& key, double minimum, double maximum) {
  const toml::value* value = find(key);
  std::vector<double> result;
  if (value == nullptr) return result;
  if (!value->is_array()) fail_at(*value, fmt::format("'{}' must be an array of numbers", full_name(key)));
  for (const toml::value& entry : value->as_array()) {
    const double number = as_number(entry, full_name(key));
    if (!(number >= minimum && number <= maximum)) {
      fail_at(entry, fmt::format("'{}' has {}; its numbers must lie in [{}, {}]", full_name(key), number,
                                 minimum, maximum));
    }
    result.push_back(number);
  }
  return result;
}

double TomlTable::number(const std::string& key, double fallback, double minimum, double maximum) {
  return find(key) == nullptr ? fallback : number(key, minimum, maximum);
}

int TomlTable::whole(const std::string& key, int fallback, int minimum, int maximum) {
  const double value = number(key, fallback, minimum, maximum);
  if (value != std::floor(value))
    fail(key, fmt::format("'{}' is {}; it must be a whole number", full_name(key), value));
  return static_cast<int>(value);
}

bool TomlTable::flag(const std::string& key, bool fallback) {
  const toml::value* value = find(key);
  if (value == nullptr) return fallback;
  if (!value->is_boolean()) fail_at(*value, fmt::format("'{}' must be true or false", full_name(key)));
  return value->as_boolean();
}

Vec3d TomlTable::vec3(const std::string& key) {
  const toml::value* value = find(key);
  if (value == nullptr) fail_missing(key);
  return as_vec3(*value, full_name(key));
}

Vec3d TomlTable::vec3(const std::string& key, const Vec3d& fallback) {
  return find(key) == nullptr ? fallback : vec3(key);
}

Vec3d TomlTable::rgb(const std::string& key, const Vec3d& fallback) {
  return find(key) == nullptr ? fallback : rgb(key);
}

Vec3d TomlTable::rgb(const std::string& key) {
  const toml::value* value = find(key);
  if (value == nullptr) fail_missing(key);
  if (value->is_array()) return as_vec3(*value, full_name(key));
  return Vec3d::Constant(as_number(*value, full_name(key)));
}

TomlTable TomlTable::table(const std::string& key) {
  const toml::value* value = find(key);
  return {value != nullptr ? *value : empty_table(), full_name(key)};
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) {
  const toml::value* value = find(key);
  std::vector<TomlTable> result;
  if (value == nullptr) return result;
  if (!value->is_array())
    fail_at(*value, fmt::format("'{0}' must be an array of tables ([[{0}]])", full_name(key)));
  for (const toml::value& entry : value->as_array()) result.emplace_back(entry, full_name(key));
  return result;
}

const toml::value& TomlTable::raw(const std::string& key) {
  const toml::value* value = find(key);
  if (value == nullptr) fail_missing(key);
  return *value;
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  for (const auto& entry : value_->as_table()) names.push_back(entry.first);
  std::sort(names.begin(), names.end());
  return names;
}

void TomlTable::finish() const {
  for (const std::string& key : keys()) {
    if (known_.count(key) == 0) {
      fail(key, fmt::format("unknown key '{}'; known here: {}", full_name(key), fmt::join(known_, ", ")));
    }
  }
}

}  // namespace truescatter
