#include "experiment/input_files.h"

#include <filesystem>

#include "core/content_hash.h"
#include "experiment/own_method.h"

namespace truescatter {
namespace {

class InputFiles {
 public:
  void add(const ExperimentSpec& spec) {
    const SceneSpec& scene = spec.scene;
    add(spec, scene.mesh, scene.mesh_where);
    add(spec, scene.skin_mask, scene.skin_mask_where);
    add(spec, scene.transmitter_mask, scene.transmitter_mask_where);
    add(spec, scene.normal_map, scene.normal_map_where);
    add(spec, scene.albedo, scene.albedo_where);
    if (spec.composite) add(spec, spec.composite->regions, spec.composite->regions_where);
    for (const LightSpec& light : spec.lights) add(spec, light.map, light.map_where);
    for (const ProfileSpec& profile : spec.profiles) {
      if (profile.of) add(spec, profile.of->layers, profile.of->file_where);
      if (profile.of) add(spec, profile.of->table, profile.of->file_where);
      if (profile.fit) add(spec, profile.fit->file, profile.fit->where);
    }
    for (const MethodSpec& method : spec.methods) {
      if (method.own) add_method(spec, method);
    }
  }

  std::map<std::string, std::string> hashes;

 private:
  void add(const ExperimentSpec& spec, const std::string& path, const SourceLocation& where) {
    if (path.empty() || path.starts_with(kBuiltinPrefix) || hashes.count(path) != 0) return;
    hashes.emplace(path, hash_of_file(resolve_path(spec, path, where)));
  }

  void add_method(const ExperimentSpec& spec, const MethodSpec& method) {
    const OwnMethodSpec& own = *method.own;
    for (const std::string& path : own.include) add(spec, path, own.include_where);
    for (const OwnMethodSpec::Pass& pass : own.passes) add(spec, pass.shader, pass.shader_where);
    if (own.image.empty()) return;
    for (const ViewSpec& view : spec.views) {
      for (const ProfileSpec& profile : spec.profiles) {
        const std::filesystem::path picture = picture_path(spec, method, view.name, profile.name);
        if (!std::filesystem::exists(picture)) continue;
        hashes.emplace(own.image + " (" + view.name + ", " + profile.name + ")", hash_of_file(picture));
      }
    }
  }
};

}  // namespace

std::map<std::string, std::string> input_hashes(const ExperimentSpec& spec) {
  InputFiles files;
  files.add(spec);
  if (spec.sweep) {
    for (const ExperimentSpec& point : spec.sweep->point) files.add(point);
  }
  return std::move(files.hashes);
}

}  // namespace truescatter
