#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/error.h"

namespace truescatter {

// A knob of a method: a number in a range (whole if `whole`), or one word of a list.
struct SettingSpec {
  std::string_view name;  // with its unit
  std::string_view help;
  double default_number = 0.0;
  double minimum = 0.0;
  double maximum = 0.0;
  bool whole = false;
  std::vector<std::string_view> choices = {};  // not empty: a word; the first is the default
};

using SettingValue = std::variant<double, std::string>;

// Values for every setting of a method, each checked against its spec.
class Settings {
 public:
  // Fills in the defaults. Throws Error (input) at `where[name]` for an unknown name, a value of the wrong
  // kind or out of range; the message lists what is allowed.
  Settings(std::string_view method, const std::vector<SettingSpec>& specs,
           const std::map<std::string, SettingValue>& given,
           const std::map<std::string, SourceLocation>& where = {});

  double number(std::string_view name) const;
  int whole(std::string_view name) const;
  const std::string& word(std::string_view name) const;
  const std::map<std::string, SettingValue>& values() const { return values_; }

 private:
  std::map<std::string, SettingValue> values_;
};

}  // namespace truescatter
