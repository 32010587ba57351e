#include "config/experiment_values.h"

#include <algorithm>

#include "config/toml_reader.h"

namespace truescatter {
namespace {

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
    values[key] = inline_text(value);
  }
}

}  // namespace

std::map<std::string, std::string> experiment_values(const std::filesystem::path& file) {
  std::map<std::string, std::string> values;
  collect(read_toml_file(file), "", values);
  return values;
}

}  // namespace truescatter
