#include "config/experiment_spec.h"

#include "core/file.h"

namespace truescatter {

namespace {

std::string hint_of(const ExperimentSpec& spec) {
  return spec.scene.obtain.empty() ? "" : "\n" + spec.scene.obtain;
}

}  // namespace

std::filesystem::path expanded_path(const ExperimentSpec& spec, const std::string& path,
                                    const SourceLocation& where) {
  std::string expanded;
  try {
    expanded = expand_environment(path);
  } catch (const Error& error) {
    throw_input_error(where, "{}{}", error.what(), hint_of(spec));
  }
  std::filesystem::path result(expanded);
  // A variable's value was typed in a shell: relative to where that stands.
  const bool from_shell = path.starts_with("${");
  if (result.is_relative() && !from_shell) result = spec.file.parent_path() / result;
  return result;
}

std::filesystem::path resolve_path(const ExperimentSpec& spec, const std::string& path,
                                   const SourceLocation& where) {
  std::filesystem::path result = expanded_path(spec, path, where);
  if (!std::filesystem::exists(result))
    throw_input_error(where, "no such file: {}{}", result.string(), hint_of(spec));
  return result;
}

}  // namespace truescatter
