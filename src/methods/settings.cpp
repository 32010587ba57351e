#include "methods/settings.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace truescatter {
namespace {

SettingValue default_value(const SettingSpec& spec) {
  if (!spec.choices.empty()) return std::string(spec.choices.front());
  return spec.default_number;
}

void check(std::string_view method, const SettingSpec& spec, const SettingValue& value,
           const SourceLocation& where) {
  if (!spec.choices.empty()) {
    const auto* word = std::get_if<std::string>(&value);
    if (word == nullptr || std::find(spec.choices.begin(), spec.choices.end(), *word) == spec.choices.end()) {
      throw_input_error(where, "method '{}': '{}' is {}; it must be one of: {}", method, spec.name,
                        word != nullptr ? "\"" + *word + "\"" : fmt::format("{}", std::get<double>(value)),
                        fmt::join(spec.choices, ", "));
    }
    return;
  }
  const auto* number = std::get_if<double>(&value);
  if (number == nullptr) {
    throw_input_error(where, "method '{}': '{}' is \"{}\"; it must be a number", method, spec.name,
                      std::get<std::string>(value));
  }
  if (!(*number >= spec.minimum && *number <= spec.maximum)) {
    throw_input_error(where, "method '{}': '{}' is {}; it must lie in [{}, {}]", method, spec.name, *number,
                      spec.minimum, spec.maximum);
  }
  if (spec.whole && *number != std::floor(*number)) {
    throw_input_error(where, "method '{}': '{}' is {}; it must be a whole number", method, spec.name,
                      *number);
  }
}

}  // namespace

Settings::Settings(std::string_view method, const std::vector<SettingSpec>& specs,
                   const std::map<std::string, SettingValue>& given,
                   const std::map<std::string, SourceLocation>& where) {
  for (const SettingSpec& spec : specs) values_[std::string(spec.name)] = default_value(spec);
  for (const auto& [name, value] : given) {
    const auto at = where.find(name);
    const SourceLocation location = at != where.end() ? at->second : SourceLocation{};
    const auto spec =
        std::find_if(specs.begin(), specs.end(), [&](const SettingSpec& s) { return s.name == name; });
    if (spec == specs.end()) {
      std::vector<std::string_view> names;
      for (const SettingSpec& s : specs) names.push_back(s.name);
      throw_input_error(location, "method '{}' has no setting '{}'; it has: {}", method, name,
                        names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")));
    }
    check(method, *spec, value, location);
    values_[name] = value;
  }
}

double Settings::number(std::string_view name) const {
  const auto at = values_.find(std::string(name));
  assert(at != values_.end());
  return std::get<double>(at->second);
}

int Settings::whole(std::string_view name) const { return static_cast<int>(std::lround(number(name))); }

const std::string& Settings::word(std::string_view name) const {
  const auto at = values_.find(std::string(name));
  assert(at != values_.end());
  return std::get<std::string>(at->second);
}

}  // namespace truescatter
