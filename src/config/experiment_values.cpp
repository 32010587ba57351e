#include "config/experiment_values.h"

#include <algorithm>
#include <sstream>

#include "config/toml_reader.h"

namespace truescatter {
namespace {

std::string text_of(const toml::value& value) {
  if (value.is_floating()) return fmt::format("{}", value.as_floating());
  if (value.is_array()) {
    std::vector<std::string> parts;
    for (const toml::value& entry : value.as_array()) parts.push_back(text_of(entry));
    return fmt::format("[{}]", fmt::join(parts, ", "));
  }
  std::ostringstream stream;
  stream << value;
  return stream.str();
}

bool is_array_of_tables(const toml::value& value) {
  if (!value.is_array() || value.as_array().empty()) return false;
  const auto& entries = value.as_array();
  return std::all_of(entries.begin(), entries.end(), [](const toml::value& v) { return v.is_table(); });
}

std::string entry_key(const toml::value& entry, std::size_t index) {
  for (const char* key : {"label", "name"}) {
    if (entry.contains(key) && entry.at(key).is_string()) return entry.at(key).as_string().str;
  }
  return std::to_string(index);
}

void collect(const toml::value& value, const std::string& key, std::map<std::string, std::string>& values) {
  const std::string prefix = key.empty() ? "" : key + ".";
  if (value.is_table()) {
    for (const auto& [name, entry] : value.as_table()) collect(entry, prefix + name, values);
  } else if (is_array_of_tables(value)) {
    const auto& entries = value.as_array();
    for (std::size_t i = 0; i < entries.size(); ++i)
      collect(entries[i], prefix + entry_key(entries[i], i), values);
  } else {
    values[key] = text_of(value);
  }
}

}  // namespace

std::map<std::string, std::string> experiment_values(const std::filesystem::path& file) {
  std::map<std::string, std::string> values;
  collect(read_toml_file(file), "", values);
  return values;
}

}  // namespace truescatter
