#include "config/experiment_spec.h"

#include "core/file.h"

namespace truescatter {

std::filesystem::path resolve_path(const ExperimentSpec& spec, const std::string& path,
                                   const SourceLocation& where) {
  const std::string hint = spec.scene.obtain.empty() ? "" : "\n" + spec.scene.obtain;
  std::string expanded;
  try {
    expanded = expand_environment(path);
  } catch (const Error& error) {
    throw_input_error(where, "{}{}", error.what(), hint);
  }
  std::filesystem::path result(expanded);
  // A variable's value was typed in a shell: relative to where that stands.
  const bool from_shell = path.starts_with("${");
  if (result.is_relative() && !from_shell) result = spec.file.parent_path() / result;
  if (!std::filesystem::exists(result)) throw_input_error(where, "no such file: {}{}", result.string(), hint);
  return result;
}

}  // namespace truescatter
