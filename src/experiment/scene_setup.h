#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/kept_values.h"
#include "irradiance/light_fields.h"
#include "irradiance/shading_mesh.h"
#include "scene/camera.h"
#include "scene/characters.h"
#include "scene/load_mesh.h"
#include "scene/mesh.h"
#include "scene/uv_texture.h"
#include "truth/geodesic_surface.h"
#include "truth/surface.h"

namespace truescatter {

// What the reflection off a scene's surfaces depends on beside its irradiance.
struct SceneReflection {
  std::vector<Light> lights;
  // Of each environment among them the share that occlusion leaves of its irradiance at the corners of the
  // shading mesh, per channel, of the geometry alone: what a normal map tilts is the lobe's. Empty: all of
  // it.
  std::vector<CornerIrradiance> shares;
  NormalMap normal_map;
  UvTexture regions;  // gloss as the walkthrough's map has it; empty where no file is named
};

// A scene ready to be rendered and convolved.
struct PreparedScene {
  Mesh mesh;
  SourceLocation mesh_file;  // for messages: the file, or the built-in scene's name
  ShadingMesh shading;
  std::vector<LightField> lights;   // of `shading`
  double largest_irradiance = 0.0;  // of S at its corners: the unit of tolerances
  std::optional<UvReport> uvs;
  UvTexture albedo;                           // linear RGB; empty where there is none
  std::vector<CharacterPlace> places;         // of its characters; empty: one, where its file has it
  std::optional<SceneReflection> reflection;  // where it was asked for
};

// Loads or generates the mesh, lights it and refines it into the shading mesh.
// Throws Error (input): see load_mesh, mesh_checks.h, make_builtin, resolve_path; a texture without UVs, or
// without the channels that it needs; an environment's map that is none; a dark scene; a point light on the
// mesh.
// `admit` is told of the mesh before it is lit; what it throws is passed on. `reflection`: whether what
// reflection depends on is wanted. `kept`: where a generated mesh may be kept.
PreparedScene prepare_scene(
    const ExperimentSpec& spec, const std::function<void(const Mesh&)>& admit = [](const Mesh&) {},
    bool reflection = false, const KeptValues& kept = {});

// What a scene is known to be before it is generated, lit and refined.
struct SceneOutline {
  bool has_uvs = false;
  std::size_t vertices = 0;                  // of a built-in scene about so many
  std::size_t triangles = 0;                 // likewise
  std::map<std::string, double> parameters;  // of a built-in scene, with its defaults
};

// Checks names and parameters of a built-in scene, and reads a mesh file, textures and environments; computes
// nothing else.
// Throws the Errors that prepare_scene gives for them.
SceneOutline check_scene(const ExperimentSpec& spec);

Camera camera_of(const ViewSpec& view);

// S of a shading mesh as the truth sees it.
Surface scattering_surface(const ShadingMesh& shading);

// The same as geodesics see it: distances run over the scene's mesh, every shading triangle is a piece of one
// of its triangles. Throws Error (input), see IntrinsicMesh, where the mesh leaves geodesics without one
// answer.
GeodesicSurface geodesic_surface(const PreparedScene& scene);

}  // namespace truescatter
