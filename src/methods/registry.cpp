#include <algorithm>

#include "methods/method.h"

namespace truescatter {

#include "registry.inc"

const std::vector<Method>& all_methods() {
  static const std::vector<Method> methods = rows();
  return methods;
}

const Method& find_method(std::string_view name, const SourceLocation& where) {
  const std::vector<Method>& methods = all_methods();
  const auto found =
      std::find_if(methods.begin(), methods.end(), [&](const Method& m) { return m.name == name; });
  if (found != methods.end()) return *found;
  std::vector<std::string_view> names;
  for (const Method& m : methods) names.push_back(m.name);
  throw_input_error(where, "there is no method '{}'; there are: {}", name, fmt::join(names, ", "));
}

}  // namespace truescatter
