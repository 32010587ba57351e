#include "experiment/scene_setup.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/image_io.h"
#include "core/progress.h"
#include "experiment/builtin_mesh.h"
#include "experiment/mesh_checks.h"
#include "scene/builtin.h"

namespace truescatter {
namespace {

constexpr std::size_t kResidualSamples = 20000;
constexpr std::string_view kHeadRegions = "builtin:head";

bool is_builtin(const SceneSpec& scene) { return scene.mesh.starts_with(kBuiltinPrefix); }

// `use(name, parameters, locations)` of the scene's built-in.
template <typename Use>
auto with_builtin(const SceneSpec& scene, const Use& use) {
  return use(scene.mesh.substr(kBuiltinPrefix.size()),
             BuiltinParameters(scene.parameters.begin(), scene.parameters.end()),
             BuiltinLocations{scene.mesh_where, scene.parameters_where});
}

Mesh load_mesh_file(const ExperimentSpec& spec, int loop_subdivisions) {
  const SceneSpec& scene = spec.scene;
  LoadOptions options;
  options.unit_mm = scene.unit_mm;
  options.loop_subdivisions = loop_subdivisions;
  options.flip_v = scene.flip_v;
  if (scene.normals == "file") options.normals = NormalSource::file;
  if (scene.normals == "angle-weighted") options.normals = NormalSource::angle_weighted;
  const std::filesystem::path path = resolve_path(spec, scene.mesh, scene.mesh_where);
  Mesh mesh = load_mesh(path, options);
  std::vector<std::size_t> all(mesh.triangle_count());
  std::iota(all.begin(), all.end(), std::size_t{0});
  refuse_repeated_triangles(mesh, all, {path.string()});
  const std::vector<int> components = label_components(
      mesh.triangle_count(), [&](std::size_t t) { return mesh.triangles[t]; },
      [](std::size_t) { return true; });
  refuse_parted_surface(mesh, all, components, {path.string()});
  return mesh;
}

Mesh load_scene_mesh(const ExperimentSpec& spec, const KeptValues& kept) {
  if (is_builtin(spec.scene)) {
    return with_builtin(spec.scene, [&](const auto& name, const auto& parameters, const auto& where) {
      return builtin_mesh(name, parameters, where, kept);
    });
  }
  return load_mesh_file(spec, spec.scene.loop_subdivisions);
}

std::vector<CharacterPlace> places_of(const SceneSpec& scene) {
  std::vector<CharacterPlace> places;
  for (const CharacterSpec& character : scene.characters)
    places.push_back({character.position_mm, character.rotation_deg});
  return places;
}

// An image that a key names: what is wrong with it is told at the key.
Image read_image_of(const std::filesystem::path& path, const SourceLocation& where) {
  try {
    return read_linear_colours(path);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::input) throw;
    throw_input_error(where, "{}", error.what());
  }
}

// The map of an environment, built in or from a file.
Image load_environment(const ExperimentSpec& spec, const LightSpec& light) {
  if (light.map.starts_with(kBuiltinPrefix))
    return builtin_environment_map(light.map.substr(kBuiltinPrefix.size()), light.map_where);
  const std::filesystem::path path = resolve_path(spec, light.map, light.map_where);
  Image map = read_image_of(path, light.map_where);
  const auto refuse = [&](const std::string& rule) {
    throw_input_error(light.map_where, "'light.map' {}, but {} {}", rule, path.string(),
                      fmt::format("is {} x {} pixels of {} channel{}", map.width(), map.height(),
                                  map.channels(), map.channels() == 1 ? "" : "s"));
  };
  if (map.channels() < 3) refuse("needs red, green and blue");
  if (map.width() != 2 * map.height()) refuse("must be twice as wide as high (longitude by latitude)");
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (map.rgb(x, y).allFinite() && map.rgb(x, y).minCoeff() >= 0.0) continue;
      throw_input_error(light.map_where,
                        "'light.map' must be finite and not negative, but {} is not at column {}, row {}",
                        path.string(), x, y);
    }
  }
  return map;
}

Light light_of(const ExperimentSpec& experiment, const LightSpec& spec) {
  Light light;
  light.color = spec.color;
  if (spec.type == "environment") {
    light.kind = LightKind::environment;
    light.environment = project_environment(load_environment(experiment, spec), spec.rotation_deg);
    light.shadows = spec.occlusion;
    light.occlusion_rays = spec.occlusion_rays;
    return light;
  }
  light.kind = spec.type == "point" ? LightKind::point : LightKind::directional;
  light.direction = spec.direction;
  light.position_mm = spec.position_mm;
  light.reference_mm = spec.reference_mm;
  light.shadows = spec.shadows;
  return light;
}

// A texture in UV that an experiment names.
struct TextureKey {
  std::string_view key;
  const std::string& path;
  const SourceLocation& where;
};

// Its image as `read` gives it, which must have `channels` channels or more; empty where none is named.
Image load_texture(const ExperimentSpec& spec, bool has_uvs, const TextureKey& texture, int channels,
                   Image (*read)(const std::filesystem::path&)) {
  if (texture.path.empty()) return {};
  if (!has_uvs) {
    throw_input_error(texture.where, "'{}' is a texture in UV, but {} has no UVs", texture.key,
                      spec.scene.mesh);
  }
  const std::filesystem::path path = resolve_path(spec, texture.path, texture.where);
  Image image = read(path);
  if (image.channels() < channels) {
    throw_input_error(texture.where, "'{}' needs red, green and blue, but {} has {} channel{}", texture.key,
                      path.string(), image.channels(), image.channels() == 1 ? "" : "s");
  }
  const auto is_finite = [](float value) { return std::isfinite(value); };
  if (!std::all_of(image.data().begin(), image.data().end(), is_finite)) {
    throw_input_error(texture.where, "'{}' must be finite, but {} holds a value that is not", texture.key,
                      path.string());
  }
  return image;
}

Image read_as_stored(const std::filesystem::path& path) { return read_image(path); }

SkinMask load_mask(const ExperimentSpec& spec, bool has_uvs, const TextureKey& texture) {
  if (texture.path.empty()) return {};
  return SkinMask(load_texture(spec, has_uvs, texture, 1, read_as_stored));
}

SkinMask load_skin_mask(const ExperimentSpec& spec, bool has_uvs) {
  return load_mask(spec, has_uvs, {"scene.skin_mask", spec.scene.skin_mask, spec.scene.skin_mask_where});
}

// White on what transmits, of the skin.
SkinMask load_transmitter_mask(const ExperimentSpec& spec, bool has_uvs) {
  return load_mask(
      spec, has_uvs,
      {"scene.transmitter_mask", spec.scene.transmitter_mask, spec.scene.transmitter_mask_where});
}

// By the centroids of the triangles, which are not cut along this mask.
void mark_transmitters(ShadingMesh& shading, const SkinMask& mask) {
  for (ShadingTriangle& triangle : shading.triangles)
    triangle.transmits = mask.is_skin((triangle.uvs[0] + triangle.uvs[1] + triangle.uvs[2]) / 3.0);
}

Image load_normal_image(const ExperimentSpec& spec, bool has_uvs) {
  const SceneSpec& scene = spec.scene;
  return load_texture(spec, has_uvs, {"scene.normal_map", scene.normal_map, scene.normal_map_where}, 3,
                      read_as_stored);
}

NormalMap load_normal_map(const ExperimentSpec& spec, const Mesh& mesh) {
  const SceneSpec& scene = spec.scene;
  if (scene.normal_map.empty()) return {};
  return {mesh,
          load_normal_image(spec, mesh.has_uvs()),
          {scene.normal_map_strength, scene.normal_map_green == "down"}};
}

UvTexture load_albedo(const ExperimentSpec& spec, bool has_uvs) {
  const SceneSpec& scene = spec.scene;
  if (scene.albedo.empty()) return {};
  Image image = load_texture(spec, has_uvs, {"scene.albedo", scene.albedo, scene.albedo_where}, 3,
                             [](const std::filesystem::path& path) { return read_linear_colours(path); });
  if (std::any_of(image.data().begin(), image.data().end(), [](float value) { return value < 0.0F; })) {
    throw_input_error(scene.albedo_where, "'scene.albedo' must not be negative, but {} holds such a value",
                      scene.albedo);
  }
  return UvTexture(std::move(image));
}

// Gloss in UV, as the walkthrough has it: intensity in red, roughness in the last channel, alpha.
UvTexture load_regions(const ExperimentSpec& spec, bool has_uvs) {
  const CompositeSpec& composite = *spec.composite;
  if (composite.regions.empty()) return {};
  if (composite.regions.starts_with(kBuiltinPrefix)) {
    if (composite.regions == kHeadRegions && spec.scene.mesh == kHeadRegions) return {};
    throw_input_error(
        composite.regions_where,
        "'composite.regions' is \"{}\": there are built-in regions of \"{}\" alone, on that mesh",
        composite.regions, kHeadRegions);
  }
  Image image = load_texture(spec, has_uvs, {"composite.regions", composite.regions, composite.regions_where},
                             1, read_as_stored);
  if (std::any_of(image.data().begin(), image.data().end(),
                  [](float value) { return value < 0.0F || value > 1.0F; })) {
    throw_input_error(composite.regions_where,
                      "'composite.regions' must be from 0 to 1, but {} holds a value beyond",
                      composite.regions);
  }
  if (image.channels() != 2 && image.channels() != 4) {
    throw_input_error(
        composite.regions_where,
        "'composite.regions' needs intensity in red and roughness in alpha, but {} has {} channel{}",
        composite.regions, image.channels(), image.channels() == 1 ? "" : "s");
  }
  return UvTexture(std::move(image));
}

std::vector<Light> lights_of(const ExperimentSpec& spec) {
  std::vector<Light> lights;
  for (const LightSpec& light : spec.lights) lights.push_back(light_of(spec, light));
  return lights;
}

// What occlusion leaves of an environment's irradiance at every corner. `known`: the mesh's irradiance is
// this light's.
CornerIrradiance occlusion_share(const PreparedScene& scene, const Light& light, bool known) {
  CornerIrradiance share =
      known ? CornerIrradiance{} : corner_irradiance(scene.shading, Lighting(scene.mesh, {light}));
  share.resize(scene.shading.triangles.size());
  const EnvironmentIrradiance open(light.environment, 1);
  for (std::size_t t = 0; t < share.size(); ++t) {
    const ShadingTriangle& triangle = scene.shading.triangles[t];
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d left = known ? triangle.irradiance[c] : share[t][c];
      const Vec3d all = light.color.cwiseProduct(open.unoccluded(triangle.normals[c]));
      for (Eigen::Index k = 0; k < 3; ++k)
        share[t][c][k] = all[k] > 0.0 ? std::clamp(left[k] / all[k], 0.0, 1.0) : 0.0;
    }
  }
  return share;
}

SceneReflection reflection_of(const ExperimentSpec& spec, const PreparedScene& scene,
                              const std::vector<Light>& lights, const NormalMap& normal_map) {
  SceneReflection reflection{lights, {}, normal_map, {}};
  if (spec.composite) reflection.regions = load_regions(spec, scene.mesh.has_uvs());
  const bool known = lights.size() == 1 && normal_map.empty() && spec.scene.albedo_exponent_before() == 0.0;
  for (const Light& light : lights) {
    if (light.kind == LightKind::environment)
      reflection.shares.push_back(light.shadows ? occlusion_share(scene, light, known) : CornerIrradiance{});
  }
  return reflection;
}

RefinementSettings refinement_of(const ExperimentSpec& spec) {
  RefinementSettings settings{spec.shading.tolerance, spec.shading.floor_mm};
  if (!spec.scene.normal_map.empty()) settings.visible_edge_mm = spec.shading.normal_map_edge_mm;
  if (spec.scene.albedo_exponent_before() > 0.0)
    settings.visible_edge_mm = std::min(settings.visible_edge_mm, spec.shading.albedo_edge_mm);
  if (!std::isfinite(settings.visible_edge_mm)) return settings;
  for (const ViewSpec& view : spec.views) settings.views.push_back(camera_of(view));
  return settings;
}

}  // namespace

PreparedScene prepare_scene(const ExperimentSpec& spec, const std::function<void(const Mesh&)>& admit,
                            bool reflection, const KeptValues& kept) {
  const Progress progress("scene", 1);
  PreparedScene scene;
  scene.mesh = load_scene_mesh(spec, kept);
  scene.mesh_file = {is_builtin(spec.scene)
                         ? spec.scene.mesh
                         : resolve_path(spec, spec.scene.mesh, spec.scene.mesh_where).string()};
  if (scene.mesh.has_uvs()) scene.uvs = inspect_uvs(scene.mesh);  // of one character: all have the same
  scene.places = places_of(spec.scene);
  if (!scene.places.empty()) scene.mesh = place_characters(scene.mesh, scene.places);
  admit(scene.mesh);
  scene.albedo = load_albedo(spec, scene.mesh.has_uvs());
  const SkinMask mask = load_skin_mask(spec, scene.mesh.has_uvs());
  const SkinMask transmitters = load_transmitter_mask(spec, scene.mesh.has_uvs());
  const std::vector<Light> lights = lights_of(spec);
  const NormalMap normal_map = load_normal_map(spec, scene.mesh);
  const SurfaceAlbedo albedo(scene.albedo, spec.scene.albedo_exponent_before());
  const Lighting lighting(scene.mesh, lights, normal_map, albedo);
  if (!std::isfinite(lighting.largest_possible())) {
    throw_input_error({spec.file.string()},
                      "a point light lies on the mesh, where its irradiance has no bound");
  }
  scene.shading = make_shading_mesh(scene.mesh, lighting, mask, refinement_of(spec));
  // Before all that asks for components.
  const bool has_skin = scene.shading.component_count > 0;
  if (spec.truth.mask_truth == "all") scatter_everywhere(scene.shading);
  mark_transmitters(scene.shading, transmitters);
  scene.shading.residual = measure_residual(scene.shading, lighting, kResidualSamples, spec.truth.seed);
  scene.lights = light_fields(scene.shading, scene.mesh, lights, normal_map, albedo);
  if (reflection) scene.reflection = reflection_of(spec, scene, lights, normal_map);
  scene.largest_irradiance = largest_irradiance(scene.shading);
  if (!has_skin) throw_input_error(spec.scene.skin_mask_where, "the mask leaves no skin");
  if (!(scene.largest_irradiance > 0.0)) {
    throw_input_error({spec.file.string()}, "no light reaches the skin: every irradiance is 0");
  }
  return scene;
}

SceneOutline check_scene(const ExperimentSpec& spec) {
  SceneOutline outline;
  if (is_builtin(spec.scene)) {
    const BuiltinParameters parameters = with_builtin(spec.scene, complete_parameters);
    outline.parameters.insert(parameters.begin(), parameters.end());
    outline.has_uvs = true;  // all of them have
    outline.triangles = static_cast<std::size_t>(
        expected_triangles(spec.scene.mesh.substr(kBuiltinPrefix.size()), parameters));
    outline.vertices = outline.triangles / 2;
  } else {
    // Subdivision fails on nothing that loading lets pass.
    const Mesh mesh = load_mesh_file(spec, 0);
    const auto growth = static_cast<std::size_t>(1)
                        << static_cast<unsigned>(2 * spec.scene.loop_subdivisions);
    outline.has_uvs = mesh.has_uvs();
    outline.triangles = growth * mesh.triangle_count();
    outline.vertices = growth * mesh.positions_mm.size();
  }
  const std::size_t characters = std::max<std::size_t>(1, spec.scene.characters.size());
  outline.triangles *= characters;
  outline.vertices *= characters;
  load_skin_mask(spec, outline.has_uvs);
  load_transmitter_mask(spec, outline.has_uvs);
  load_normal_image(spec, outline.has_uvs);
  load_albedo(spec, outline.has_uvs);
  if (spec.composite) load_regions(spec, outline.has_uvs);
  for (const LightSpec& light : spec.lights) light_of(spec, light);
  return outline;
}

Camera camera_of(const ViewSpec& view) {
  return {view.eye_mm, view.target_mm, view.up, view.fov_deg, view.width_px, view.height_px};
}

Surface scattering_surface(const ShadingMesh& shading) {
  Surface surface;
  const auto count = std::count_if(shading.triangles.begin(), shading.triangles.end(),
                                   [](const ShadingTriangle& triangle) { return triangle.scatters; });
  surface.triangles.reserve(static_cast<std::size_t>(count));
  for (const ShadingTriangle& triangle : shading.triangles) {
    if (!triangle.scatters) continue;
    surface.triangles.push_back(
        {{shading.corner(triangle, 0), shading.corner(triangle, 1), shading.corner(triangle, 2)},
         triangle.irradiance,
         triangle.component});
  }
  return surface;
}

GeodesicSurface geodesic_surface(const PreparedScene& scene) {
  std::vector<GeodesicPiece> pieces;
  for (const ShadingTriangle& triangle : scene.shading.triangles) {
    if (!triangle.scatters) continue;
    pieces.push_back({triangle.base, triangle.base_barycentric, triangle.irradiance, triangle.component});
  }
  return {IntrinsicMesh(scene.mesh.positions_mm, scene.mesh.triangles, scene.mesh_file), pieces};
}

}  // namespace truescatter
