#include "config/method_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>

namespace truescatter {
namespace {

struct GridValue {
  std::variant<double, std::string> value;
  SourceLocation where;
};

struct GridSetting {
  std::string name;
  std::vector<GridValue> values;
};

double grid_number(const toml::value& entry, const std::string& name) {
  if (!entry.is_integer() && !entry.is_floating())
    fail_at(entry, fmt::format("'{}' must hold numbers or strings", name));
  const double number = entry.is_integer() ? static_cast<double>(entry.as_integer()) : entry.as_floating();
  if (!std::isfinite(number)) fail_at(entry, fmt::format("'{}' must hold finite numbers", name));
  return number;
}

GridSetting read_setting(const std::string& key, const toml::value& array) {
  const std::string name = "method.grid." + key;
  if (!array.is_array() || array.as_array().empty())
    fail_at(array, fmt::format("'{}' must be an array of at least one number or string", name));
  GridSetting setting{key, {}};
  for (const toml::value& entry : array.as_array()) {
    GridValue value{{}, TomlTable::location_of(entry)};
    if (entry.is_string()) {
      value.value = entry.as_string().str;
    } else {
      value.value = grid_number(entry, name);
    }
    const bool twice = std::any_of(setting.values.begin(), setting.values.end(),
                                   [&](const GridValue& other) { return other.value == value.value; });
    if (twice) fail_at(entry, fmt::format("'{}' holds this value twice", name));
    setting.values.push_back(std::move(value));
  }
  return setting;
}

std::string label_part(const std::variant<double, std::string>& value) {
  std::string text = std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
  std::replace(text.begin(), text.end(), '.', 'p');
  text.erase(std::remove(text.begin(), text.end(), '+'), text.end());
  return text;
}

// Every method of `methods` once with each of the setting's values.
std::vector<MethodSpec> varied(const std::vector<MethodSpec>& methods, const GridSetting& setting) {
  std::vector<MethodSpec> all;
  for (const MethodSpec& method : methods) {
    for (const GridValue& value : setting.values) {
      all.push_back(method);
      all.back().settings[setting.name] = value.value;
      all.back().settings_where[setting.name] = value.where;
      if (setting.values.size() > 1)
        all.back().label += fmt::format("_{}-{}", setting.name, label_part(value.value));
    }
  }
  return all;
}

}  // namespace

std::vector<MethodSpec> expand_grid(const MethodSpec& method, TomlTable grid) {
  if (method.own && !method.own->image.empty())
    throw Error(ErrorKind::input, grid.where(),
                "'method.grid' is for GLSL and built-in methods; a picture has none");
  std::vector<MethodSpec> methods = {method};
  for (const std::string& key : grid.keys()) {
    if (method.settings.contains(key))
      grid.fail(key, fmt::format("'method.grid.{}' is in 'method.settings' too", key));
    const GridSetting setting = read_setting(key, grid.raw(key));
    if (methods.size() * setting.values.size() > kMostGridMethods) {
      grid.fail(key, fmt::format("'method.grid' stands for more than {} methods", kMostGridMethods));
    }
    methods = varied(methods, setting);
  }
  return methods;
}

}  // namespace truescatter
