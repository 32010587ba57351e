#pragma once

#include <vector>

#include "config/experiment_spec.h"
#include "config/toml_reader.h"

namespace truescatter {

// The most methods that one grid may stand for.
inline constexpr std::size_t kMostGridMethods = 4096;

// The methods that a [method.grid] stands for: one for each combination of its values, an array of numbers or
// of strings for each setting, the last setting (by name) changing fastest. Each has the method's own
// settings beside them, and the label "LABEL_SETTING-VALUE_..." of the settings with more than one value, in
// which a number's '.' is a 'p' (labels name files). Throws Error (input) at the value: no array, an empty
// one, a value of another type, one that is there twice, a setting that the method has already, too many
// methods, a grid for a picture.
std::vector<MethodSpec> expand_grid(const MethodSpec& method, TomlTable grid);

}  // namespace truescatter
