#include "experiment/own_method.h"

#include <algorithm>

#include "core/file.h"
#include "core/image_io.h"
#include "methods/glsl_method.h"

namespace truescatter {
namespace {

void check_name(const MethodSpec& method) {
  const auto& known = all_methods();
  if (std::any_of(known.begin(), known.end(), [&](const Method& m) { return m.name == method.name; }))
    throw_input_error(method.where, "'{}' is a built-in method: a method of your own needs another name",
                      method.name);
}

gpu::ShaderText read_shader(const ExperimentSpec& spec, const std::string& path,
                            const SourceLocation& where) {
  const std::filesystem::path file = resolve_path(spec, path, where);
  return {file.string(), read_text_file(file)};
}

GlslRun run_of(const OwnMethodSpec& own) {
  if (own.run == "per-term") return GlslRun::per_term;
  return own.run == "once" ? GlslRun::once : GlslRun::per_gaussian;
}

std::vector<gpu::ShaderText> included(const ExperimentSpec& spec, const OwnMethodSpec& own) {
  std::vector<gpu::ShaderText> texts;
  for (const std::string& path : own.include) {
    texts.push_back(path.starts_with(kBuiltinPrefix)
                        ? glsl_library(path.substr(kBuiltinPrefix.size()), own.include_where)
                        : read_shader(spec, path, own.include_where));
  }
  return texts;
}

OwnTarget target_of(const OwnMethodSpec& own) {
  return {own.geodesic, own.normalised, own.r_max_mm, own.visible_only, own.transmittance};
}

Method picture_method(const MethodSpec& method) {
  Method made;
  made.name = method.name;
  made.title = method.own->title;
  made.source = method.own->source;
  made.own_target = [target = target_of(*method.own)](const Profile&, const Settings&) { return target; };
  return made;
}

void replace_all(std::string& text, const std::string& piece, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(piece, at)) != std::string::npos; at += by.size())
    text.replace(at, piece.size(), by);
}

}  // namespace

Method own_method(const ExperimentSpec& spec, const MethodSpec& method) {
  check_name(method);
  const OwnMethodSpec& own = *method.own;
  if (!own.image.empty()) return picture_method(method);
  for (const auto& [name, value] : method.settings) {
    if (!std::holds_alternative<double>(value))
      throw_input_error(method.settings_where.at(name),
                        "'method.settings.{}' must be a number: it is a uniform", name);
  }
  GlslMethod glsl{method.name, own.title, own.source, run_of(own), {}, method.settings_where, target_of(own)};
  for (const OwnMethodSpec::Pass& pass : own.passes) {
    GlslPass made{included(spec, own), pass.inputs, pass.settings, pass.inputs_where, pass.settings_where};
    made.texts.push_back(read_shader(spec, pass.shader, pass.shader_where));
    glsl.passes.push_back(std::move(made));
  }
  return glsl_method(glsl);
}

std::filesystem::path picture_path(const ExperimentSpec& spec, const MethodSpec& method,
                                   const std::string& view, const std::string& profile) {
  std::string path = method.own->image;
  replace_all(path, "{view}", view);
  replace_all(path, "{profile}", profile);
  return expanded_path(spec, path, method.own->image_where);
}

Image read_picture(const std::filesystem::path& file, const MethodSpec& method, const ViewSpec& view) {
  Image picture = read_rgb(file, method.own->layer);
  if (picture.width() == view.width_px && picture.height() == view.height_px) return picture;
  throw_input_error({file.string()}, "is {} x {} pixels, but view '{}' is {} x {}; they must agree",
                    picture.width(), picture.height(), view.name, view.width_px, view.height_px);
}

}  // namespace truescatter
