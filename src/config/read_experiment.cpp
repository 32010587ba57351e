#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "config/experiment_spec.h"
#include "config/method_grid.h"
#include "config/toml_reader.h"

namespace truescatter {

// Generated: see standard_methods.toml.
namespace standard {
std::string embedded(std::string_view path);
}

namespace {

constexpr double kHuge = std::numeric_limits<double>::max();

// Names of views, profiles and methods become parts of file names.
void check_file_name(const TomlTable& table, const std::string& key, const std::string& full_name,
                     const std::string& name) {
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
  });
  if (!plain) table.fail(key, fmt::format("'{}' names files: letters, digits, '-' and '_' only", full_name));
}

constexpr std::size_t kMostCharacters = 64;

std::vector<CharacterSpec> read_characters(TomlTable& scene) {
  std::vector<CharacterSpec> characters;
  for (TomlTable& table : scene.tables("character")) {
    CharacterSpec character;
    table.allow({"position_mm", "rotation_deg"});
    table.finish();
    character.position_mm = table.vec3("position_mm");
    if (!(character.position_mm.cwiseAbs().maxCoeff() <= 1e6))
      table.fail("position_mm", "'scene.character.position_mm' must lie within 1e6 mm of the origin");
    character.rotation_deg = table.number("rotation_deg", 0.0, -360.0, 360.0);
    table.finish();
    const auto same_place = [&](const CharacterSpec& other) {
      return other.position_mm == character.position_mm && other.rotation_deg == character.rotation_deg;
    };
    if (std::any_of(characters.begin(), characters.end(), same_place))
      table.fail("position_mm", "two characters stand at one place, turned alike");
    characters.push_back(character);
  }
  if (scene.has("character") && (characters.empty() || characters.size() > kMostCharacters)) {
    scene.fail("character", fmt::format("'scene.character' has {} entries: it must have 1 to {}",
                                        characters.size(), kMostCharacters));
  }
  return characters;
}

SceneSpec read_scene(TomlTable table) {
  SceneSpec scene;
  scene.mesh = table.text("mesh");
  scene.mesh_where = table.where("mesh");
  TomlTable parameters = table.table("parameters");
  for (const std::string& key : parameters.keys()) {
    scene.parameters[key] = parameters.number(key, -kHuge, kHuge);
    scene.parameters_where[key] = parameters.where(key);
  }
  scene.unit_mm = table.number("unit_mm", 1.0, 1e-9, 1e9);
  scene.normals = table.one_of("normals", "automatic", {"automatic", "file", "angle-weighted"});
  scene.loop_subdivisions = table.whole("loop_subdivisions", 0, 0, 6);
  scene.flip_v = table.flag("flip_v", false);
  scene.skin_mask = table.text("skin_mask", "");
  scene.skin_mask_where = table.where("skin_mask");
  scene.transmitter_mask = table.text("transmitter_mask", "");
  scene.transmitter_mask_where = table.where("transmitter_mask");
  scene.normal_map = table.text("normal_map", "");
  scene.normal_map_where = table.where("normal_map");
  scene.normal_map_strength = table.number("normal_map_strength", 1.0, 0.0, 100.0);
  scene.normal_map_green = table.one_of("normal_map_green", "up", {"up", "down"});
  for (const char* key : {"normal_map_strength", "normal_map_green"}) {
    if (scene.normal_map.empty() && table.has(key))
      table.fail(key, fmt::format("'scene.{}' needs a 'scene.normal_map'", key));
  }
  scene.albedo = table.text("albedo", "");
  scene.albedo_where = table.where("albedo");
  scene.texturing = table.one_of("texturing", scene.texturing, {"after", "before", "mix"});
  if (scene.albedo.empty() && table.has("texturing"))
    table.fail("texturing", "'scene.texturing' needs a 'scene.albedo'");
  scene.texturing_mix = table.number("texturing_mix", scene.texturing_mix, 0.0, 1.0);
  if (scene.texturing != "mix" && table.has("texturing_mix"))
    table.fail("texturing_mix", "'scene.texturing_mix' needs 'scene.texturing = \"mix\"'");
  scene.characters = read_characters(table);
  scene.obtain = table.text("obtain", "");
  if (scene.mesh.starts_with(kBuiltinPrefix)) {
    for (const char* key : {"unit_mm", "normals", "loop_subdivisions", "flip_v"}) {
      if (table.has(key))
        table.fail(key, fmt::format("'scene.{}' is for mesh files; a built-in scene has none", key));
    }
  } else if (!scene.parameters.empty()) {
    table.fail("parameters", "'scene.parameters' is for built-in scenes; a mesh file has none");
  }
  table.finish();
  return scene;
}

LightSpec read_light(TomlTable table) {
  LightSpec light;
  light.type = table.one_of("type", "directional", {"directional", "point", "environment"});
  if (light.type == "directional") {
    light.direction = table.vec3("direction");
    if (!(light.direction.norm() > 0.0)) table.fail("direction", "'light.direction' must not be zero");
    // What is a unit vector but for rounding stays as it is, so that a resolved experiment reads the same
    // bits.
    if (std::abs(light.direction.squaredNorm() - 1.0) > 1e-14) light.direction.normalize();
  } else if (light.type == "point") {
    light.position_mm = table.vec3("position_mm");
    light.reference_mm = table.number("reference_mm", 1000.0, 1e-6, 1e9);
  } else {
    light.map = table.text("map");
    light.map_where = table.where("map");
    light.rotation_deg = table.number("rotation_deg", 0.0, -360.0, 360.0);
    light.occlusion = table.flag("occlusion", true);
    light.occlusion_rays = table.whole("occlusion_rays", light.occlusion_rays, 16, 65536);
    if (!light.occlusion && table.has("occlusion_rays"))
      table.fail("occlusion_rays", "'light.occlusion_rays' needs 'light.occlusion'");
  }
  light.color = table.rgb("color", Vec3d::Ones());
  if (light.color.minCoeff() < 0.0) table.fail("color", "'light.color' must not be negative");
  if (light.type != "environment") light.shadows = table.flag("shadows", true);
  table.finish();
  return light;
}

ShadingSpec read_shading(TomlTable table, const SceneSpec& scene) {
  ShadingSpec shading;
  shading.tolerance = table.number("tolerance", shading.tolerance, 1e-6, 1.0);
  shading.floor_mm = table.number("floor_mm", shading.floor_mm, 1e-4, 1e6);
  shading.normal_map_edge_mm = table.number("normal_map_edge_mm", shading.floor_mm, 1e-4, 1e6);
  if (scene.normal_map.empty() && table.has("normal_map_edge_mm"))
    table.fail("normal_map_edge_mm", "'shading.normal_map_edge_mm' needs a 'scene.normal_map'");
  shading.albedo_edge_mm = table.number("albedo_edge_mm", shading.floor_mm, 1e-4, 1e6);
  if (scene.albedo_exponent_before() == 0.0 && table.has("albedo_edge_mm")) {
    table.fail("albedo_edge_mm",
               "'shading.albedo_edge_mm' needs a 'scene.albedo' with a part before the scattering "
               "('scene.texturing')");
  }
  table.finish();
  return shading;
}

ViewSpec read_view(TomlTable table) {
  ViewSpec view;
  view.name = table.text("name");
  check_file_name(table, "name", "view.name", view.name);
  view.eye_mm = table.vec3("eye_mm");
  view.target_mm = table.vec3("target_mm", view.target_mm);
  view.up = table.vec3("up", view.up);
  const Vec3d forward = view.target_mm - view.eye_mm;
  if (!(forward.norm() > 0.0)) table.fail("eye_mm", "'view.eye_mm' and 'view.target_mm' are the same point");
  if (!(forward.cross(view.up).norm() > 1e-9 * forward.norm() * view.up.norm())) {
    table.fail(table.has("up") ? "up" : "eye_mm", "'view.up' is parallel to the viewing direction");
  }
  view.fov_deg = table.number("fov_deg", view.fov_deg, 0.01, 170.0);
  view.width_px = table.whole("width_px", view.width_px, 1, 16384);
  view.height_px = table.whole("height_px", view.height_px, 1, 16384);
  table.finish();
  return view;
}

// The material by its name or by its coefficients, never both.
void read_coefficients(TomlTable& table, ProfileModelSpec& of) {
  constexpr double kLargestEta = 10.0;
  of.material = table.text("material", "");
  of.material_where = table.where("material");
  if (table.has("material")) {
    if (of.material.empty()) table.fail("material", "'profile.of.material' must not be empty");
    for (const char* key : {"sigma_a", "sigma_s_prime", "eta"}) {
      if (table.has(key))
        table.fail(key, fmt::format("'profile.of.{}' is the material's: give one or the other", key));
    }
    return;
  }
  of.sigma_a_per_mm = table.rgb("sigma_a");
  if (of.sigma_a_per_mm.minCoeff() < 0.0) table.fail("sigma_a", "'profile.of.sigma_a' must not be negative");
  // The diffusion of what does not absorb reaches infinitely far: only the classical dipole has a total then.
  if (of.model != "classical-dipole" && of.sigma_a_per_mm.minCoeff() <= 0.0) {
    table.fail("sigma_a", fmt::format("'profile.of.sigma_a' must be positive for the {}", of.model));
  }
  of.sigma_s_prime_per_mm = table.rgb("sigma_s_prime");
  if (of.sigma_s_prime_per_mm.minCoeff() <= 0.0)
    table.fail("sigma_s_prime", "'profile.of.sigma_s_prime' must be positive");
  of.eta = table.number("eta", of.eta, 1.0, kLargestEta);
  if (of.eta == 1.0) table.fail("eta", "'profile.of.eta' must be above 1");
}

// A key that belongs to some models only.
void refuse_elsewhere(const TomlTable& table, const std::string& key, const std::string& why) {
  if (table.has(key)) table.fail(key, fmt::format("'profile.of.{}' is {}", key, why));
}

// `fitted`: the profile's Gaussians are fitted to it.
ProfileModelSpec read_profile_model(TomlTable table, bool fitted) {
  ProfileModelSpec of;
  table.text("model");
  of.model = table.one_of("model", "", {"classical-dipole", "better-dipole", "multipole", "burley", "table"});
  of.where = table.where("model");
  if (of.model == "multipole") {
    of.layers = table.text("layers", "");
    of.file_where = table.where("layers");
    if (!of.layers.empty()) {
      for (const char* key : {"thickness_mm", "material", "sigma_a", "sigma_s_prime", "eta"})
        refuse_elsewhere(table, key, "the layers': give one or the other");
    }
  } else {
    refuse_elsewhere(table, "thickness_mm", "for the multipole: a dipole has no far side");
    refuse_elsewhere(table, "layers", "for the multipole");
  }
  if (of.model == "table") {
    of.table = table.text("table");
    of.file_where = table.where("table");
    for (const char* key : {"material", "sigma_a", "sigma_s_prime", "eta"})
      refuse_elsewhere(table, key, "no table's");
  } else {
    refuse_elsewhere(table, "table", "for the model \"table\"");
    if (of.layers.empty()) read_coefficients(table, of);
  }
  if (of.model == "multipole") {
    // A stack of layers, by its list or its name, is only fitted.
    const bool is_slab =
        table.has("thickness_mm") || (of.layers.empty() && (!fitted || !table.has("material")));
    of.thickness_mm = is_slab ? table.number("thickness_mm", 1e-6, 1e6) : 0.0;
  }
  if (of.model == "burley") {
    of.scaling = table.one_of("scaling", of.scaling, {"searchlight", "diffuse", "diffuse-free-path"});
  } else {
    refuse_elsewhere(table, "scaling", "for the model \"burley\"");
  }
  // Mixtures of Gaussians with a proven bound are of image sources.
  const bool has_truth = of.model.ends_with("dipole") || of.thickness_mm > 0.0;
  of.truth = table.flag("truth", has_truth);
  if (of.truth && !has_truth) {
    table.fail("truth", fmt::format("'profile.of.truth': a {} has no truth of its own here, only dipoles and "
                                    "single slabs",
                                    of.model == "multipole" ? "stack of layers" : of.model));
  }
  of.tolerance = table.number("tolerance", of.tolerance, 1e-12, 0.1);
  table.finish();
  return of;
}

FitSpec read_fit_spec(TomlTable table, const std::string& model) {
  FitSpec fit;
  fit.where = table.where();
  fit.file = table.text("file", "");
  if (table.has("file")) {
    if (fit.file.empty()) table.fail("file", "'profile.fit.file' must not be empty");
    fit.where = table.where("file");
    table.finish();  // what was asked of a fit is in its file
    return fit;
  }
  constexpr int kMost = 16;
  const toml::value& gaussians = table.raw("gaussians");
  if (gaussians.is_string()) {
    table.one_of("gaussians", "", {"auto"});
    fit.tolerance = table.number("tolerance", 1e-9, 1.0);
  } else {
    fit.gaussians = table.whole("gaussians", 1, 1, kMost);
    if (table.has("tolerance"))
      table.fail("tolerance", "'profile.fit.tolerance' goes with gaussians = \"auto\"");
  }
  fit.norm = table.one_of("norm", model == "burley" ? "area" : "r", {"r", "area", "r2"});
  fit.norm_where = table.where("norm");
  fit.tolerance_where = table.where("tolerance");
  fit.nonnegative = table.one_of("weights", "non-negative", {"non-negative", "free"}) == "non-negative";
  fit.keep_albedo = table.one_of("energy", "free", {"free", "albedo"}) == "albedo";
  fit.shared_variances = table.one_of("variances", "shared", {"shared", "per-channel"}) == "shared";
  if (table.has("min_variance_mm2")) fit.min_variance_mm2 = table.number("min_variance_mm2", 1e-18, 1e18);
  if (table.has("max_variance_mm2")) fit.max_variance_mm2 = table.number("max_variance_mm2", 1e-18, 1e18);
  fit.seed = table.whole("seed", fit.seed, 0, 1000000000);
  table.finish();
  return fit;
}

ProfileSpec read_profile(TomlTable table) {
  ProfileSpec profile;
  profile.name = table.text("name");
  profile.where = table.where("name");
  check_file_name(table, "name", "profile.name", profile.name);
  if (table.has("of")) profile.of = read_profile_model(table.table("of"), table.has("fit"));
  if (table.has("fit")) {
    profile.fit = read_fit_spec(table.table("fit"), profile.of ? profile.of->model : "");
    if (profile.fit->file.empty() && !profile.of) {
      table.fail("fit", "'profile.fit' needs [profile.of], which says what is fitted, or the file of a fit");
    }
    if (table.has("gaussian"))
      table.fail("gaussian", "a profile is fitted or has [[profile.gaussian]], not both");
    profile.builtin = false;
    profile.r_max_mm = table.has("r_max_mm") ? table.number("r_max_mm", 1e-6, 1e6) : 0.0;
    table.finish();
    return profile;
  }
  if (profile.of && !profile.of->truth) {
    table.fail("of", "'profile.of' is asked for nothing: its truth is off, and there is no [profile.fit]");
  }
  profile.builtin = !table.has("gaussian");
  if (profile.builtin) {
    table.finish();
    return profile;
  }
  profile.delta_weight = table.rgb("delta_weight", Vec3d::Zero());
  for (TomlTable& entry : table.tables("gaussian")) {
    ProfileSpec::Gaussian gaussian;
    gaussian.variance_mm2 = entry.rgb("variance_mm2");
    gaussian.weight = entry.rgb("weight");
    if (gaussian.variance_mm2.minCoeff() <= 0.0) {
      entry.fail("variance_mm2", "'profile.gaussian.variance_mm2' must be positive");
    }
    entry.finish();
    profile.gaussians.push_back(gaussian);
  }
  if (profile.gaussians.empty()) table.fail("gaussian", "a profile needs at least one [[profile.gaussian]]");
  const auto has_weight = [](const ProfileSpec::Gaussian& g) { return !g.weight.isZero(0.0); };
  if (std::none_of(profile.gaussians.begin(), profile.gaussians.end(), has_weight))
    table.fail("gaussian", "a profile needs a [[profile.gaussian]] whose 'weight' is not 0");
  std::stable_sort(profile.gaussians.begin(), profile.gaussians.end(),
                   [](const auto& a, const auto& b) { return a.variance_mm2.x() < b.variance_mm2.x(); });
  double widest_mm2 = 0.0;
  for (const auto& gaussian : profile.gaussians)
    widest_mm2 = std::max(widest_mm2, gaussian.variance_mm2.maxCoeff());
  profile.r_max_mm = table.number("r_max_mm", 3.0 * std::sqrt(widest_mm2), 1e-6, 1e6);
  table.finish();
  return profile;
}

OwnMethodSpec::Pass read_pass(TomlTable table) {
  OwnMethodSpec::Pass pass;
  pass.shader = table.text("shader");
  pass.shader_where = table.where("shader");
  pass.inputs = table.texts("inputs");
  pass.inputs_where = table.where("inputs");
  for (std::size_t i = 0; i < pass.inputs.size(); ++i) {
    if (std::find(pass.inputs.begin(), pass.inputs.begin() + static_cast<std::ptrdiff_t>(i),
                  pass.inputs[i]) != pass.inputs.begin() + static_cast<std::ptrdiff_t>(i))
      table.fail("inputs", fmt::format("'method.pass.inputs' names '{}' twice", pass.inputs[i]));
  }
  TomlTable settings = table.table("settings");
  for (const std::string& key : settings.keys()) {
    pass.settings[key] = settings.number(key, -kHuge, kHuge);
    pass.settings_where[key] = settings.where(key);
  }
  table.finish();
  return pass;
}

void read_target(TomlTable table, OwnMethodSpec& own) {
  own.geodesic = table.one_of("metric", "euclidean", {"euclidean", "geodesic"}) == "geodesic";
  own.normalised = table.flag("normalised", own.normalised);
  if (table.has("r_max_mm")) own.r_max_mm = table.number("r_max_mm", 1e-6, 1e6);
  own.visible_only = table.flag("visible_only", own.visible_only);
  if (own.geodesic && own.visible_only)
    table.fail("visible_only", "'method.target.visible_only' is for the Euclidean metric");
  own.transmittance = table.flag("transmittance", own.transmittance);
  if (own.transmittance && own.visible_only) {
    table.fail("transmittance",
               "'method.target.transmittance' comes from what the view does not see: not with visible_only");
  }
  table.finish();
}

// Each placeholder of a picture's path is one that will be filled in.
void check_image_path(const TomlTable& table, const std::string& path) {
  if (path.empty()) table.fail("image", "'method.image' must not be empty");
  for (std::size_t open = 0; (open = path.find('{', open)) != std::string::npos; ++open) {
    const bool variable = open > 0 && path[open - 1] == '$';
    const std::string rest = path.substr(open);
    if (!variable && !rest.starts_with("{view}") && !rest.starts_with("{profile}"))
      table.fail("image", "'method.image' has a '{' that is none of {view}, {profile} and ${VARIABLE}");
  }
}

// The keys of a method that is not built in.
OwnMethodSpec read_own_method(TomlTable& table, const std::string& name) {
  OwnMethodSpec own;
  check_file_name(table, "name", "method.name", name);
  own.title = table.text("title", name);
  own.source = table.text("source", "this experiment");
  read_target(table.table("target"), own);
  if (table.has("image")) {
    if (table.has("pass")) table.fail("image", "a method is a picture ('image') or GLSL ('pass'), not both");
    own.image = table.text("image");
    own.image_where = table.where("image");
    check_image_path(table, own.image);
    own.layer = table.text("layer", "");
    if (table.has("settings"))
      table.fail("settings", "'method.settings' is for GLSL and built-in methods; a picture has none");
    return own;
  }
  own.run = table.one_of("run", "per-gaussian", {"per-gaussian", "per-term", "once"});
  own.include = table.texts("include");
  own.include_where = table.where("include");
  for (const TomlTable& pass : table.tables("pass")) own.passes.push_back(read_pass(pass));
  if (own.passes.empty()) table.fail("pass", "a method of GLSL needs at least one [[method.pass]]");
  return own;
}

// Names of files, layers and rungs that are not a method's.
void check_label(const TomlTable& table, const char* key, const std::string& label) {
  const bool taken =
      label == "truth" || label == "mask" || label.starts_with("truth-") || label.starts_with("ladder-");
  if (!taken) return;
  table.fail(key, fmt::format("'method.{}' is \"{}\"; \"truth\", \"mask\" and what starts with \"truth-\" or "
                              "\"ladder-\" name what is no method's",
                              key, label));
}

// One, or those that its grid stands for.
std::vector<MethodSpec> read_methods(TomlTable table) {
  MethodSpec method;
  method.name = table.text("name");
  method.where = table.where("name");
  method.label = table.text("label", method.name);
  const char* label_key = table.has("label") ? "label" : "name";
  check_file_name(table, label_key, std::string("method.") + label_key, method.label);
  check_label(table, label_key, method.label);
  table.allow({"image", "pass", "grid"});
  // Keys of the two alone: `run` without a pass is a pass that was forgotten, not an unknown key.
  if (table.has("image") || table.has("pass") || table.has("run"))
    method.own = read_own_method(table, method.name);
  TomlTable settings = table.table("settings");
  for (const std::string& key : settings.keys()) {
    const toml::value& value = settings.raw(key);
    method.settings_where[key] = TomlTable::location_of(value);
    if (value.is_string()) {
      method.settings[key] = value.as_string().str;
    } else {
      method.settings[key] = settings.number(key, -kHuge, kHuge);
    }
  }
  std::vector<MethodSpec> methods = {method};
  if (table.has("grid")) methods = expand_grid(method, table.table("grid"));
  table.finish();
  return methods;
}

TruthSpec read_truth(TomlTable table) {
  TruthSpec truth;
  truth.tolerance = table.number("tolerance", truth.tolerance, 1e-9, 1e-2);
  truth.audit_points = table.whole("audit_points", truth.audit_points, 256, 1000000);
  truth.seed = static_cast<std::uint64_t>(table.whole("seed", 1, 0, 2147483647));
  truth.mask_truth = table.one_of("mask_truth", truth.mask_truth, {"skin", "all"});
  truth.geodesic = table.one_of("geodesic", truth.geodesic, {"own", "extra", "off"});
  truth.visible_only = table.flag("visible_only", truth.visible_only);
  truth.light_paths = table.whole("light_paths", truth.light_paths, 0, 1000000);
  truth.cache = table.flag("cache", truth.cache);
  table.finish();
  return truth;
}

MetricsSpec read_metrics(TomlTable table) {
  MetricsSpec metrics;
  metrics.seam = table.flag("seam", metrics.seam);
  metrics.leak = table.flag("leak", metrics.leak);
  table.finish();
  return metrics;
}

CompositeSpec read_composite(TomlTable table) {
  CompositeSpec composite;
  composite.exposure = table.number("exposure", composite.exposure, 1e-6, 1e6);
  composite.tone = table.one_of("tone", composite.tone, {"filmic", "linear"});
  composite.albedo = table.rgb("albedo", composite.albedo);
  if (composite.albedo.minCoeff() < 0.0) table.fail("albedo", "'composite.albedo' must not be negative");
  composite.specular = table.flag("specular", composite.specular);
  composite.regions = table.text("regions", "");
  composite.regions_where = table.where("regions");
  for (const char* key : {"intensity", "roughness"}) {
    if (!composite.regions.empty() && table.has(key)) {
      table.fail(key,
                 fmt::format("'composite.{}' is for skin without regions: 'composite.regions' has it", key));
    }
  }
  composite.intensity = table.number("intensity", composite.intensity, 0.0, 1.0);
  composite.roughness = table.number("roughness", composite.roughness, 0.1, 1.0);
  composite.f0 = table.number("f0", composite.f0, 0.0, 1.0);
  composite.beckmann = table.one_of("beckmann", composite.beckmann, {"log", "power"});
  composite.pixels_per_degree = table.number("pixels_per_degree", composite.pixels_per_degree, 5.0, 500.0);
  table.finish();
  return composite;
}

TimingSpec read_timing(TomlTable table) {
  TimingSpec timing;
  timing.warm_up = table.whole("warm_up", timing.warm_up, 0, 1000);
  timing.repeats = table.whole("repeats", timing.repeats, 1, 10000);
  table.finish();
  return timing;
}

// `key`, the dotted name of what holds `label`, must name a method of the experiment.
void require_label(const TomlTable& table, const std::string& key, const std::string& label,
                   const std::vector<MethodSpec>& methods) {
  const bool known =
      std::any_of(methods.begin(), methods.end(), [&](const MethodSpec& m) { return m.label == label; });
  if (!known)
    table.fail("method", fmt::format("'{}' is \"{}\", which is no method's label here", key, label));
}

ThresholdSpec read_threshold(TomlTable table) {
  ThresholdSpec threshold;
  threshold.where = table.where();
  threshold.method = table.text("method");
  threshold.metric = table.one_of("metric", "rmse",
                                  {"bias", "mae", "rmse", "rel_rmse", "p50", "p95", "p99", "max",
                                   "visible_mean", "visible_p95", "visible_above_005", "visible_above_01"});
  threshold.maximum = table.number("maximum", 0.0, kHuge);
  table.finish();
  return threshold;
}

LadderSpec read_ladder(TomlTable table, const std::vector<MethodSpec>& methods) {
  LadderSpec ladder;
  ladder.name = table.text("name");
  check_file_name(table, "name", "ladder.name", ladder.name);
  for (TomlTable& entry : table.tables("rung")) {
    LadderSpec::Rung rung;
    if (entry.has("truth") == entry.has("method"))
      entry.fail(entry.has("truth") ? "truth" : "rung", "a rung is either a 'truth' or a 'method'");
    if (entry.has("truth")) {
      rung.truth = entry.one_of("truth", "whole",
                                {"whole", "cut", "cut-visible", "raw-cut", "raw-cut-visible", "geodesic"});
    } else {
      rung.method = entry.text("method");
      require_label(entry, "ladder.rung.method", rung.method, methods);
    }
    rung.assumption = entry.text("assumption");
    entry.finish();
    for (const LadderSpec::Rung& above : ladder.rungs) {
      if (above.name() == rung.name())
        entry.fail(rung.truth.empty() ? "method" : "truth", fmt::format("two rungs are '{}'", rung.name()));
    }
    ladder.rungs.push_back(rung);
  }
  if (ladder.rungs.size() < 2) table.fail("rung", "a ladder needs at least two [[ladder.rung]]");
  table.finish();
  return ladder;
}

StabilitySpec read_stability(TomlTable table, const std::vector<ViewSpec>& views) {
  StabilitySpec stability;
  stability.view = table.text("view", "");
  const auto is_named = [&](const ViewSpec& view) { return view.name == stability.view; };
  if (table.has("view") && std::none_of(views.begin(), views.end(), is_named))
    table.fail("view", fmt::format("'stability.view' is \"{}\", which is no view's name", stability.view));
  if (table.has("orbit")) {
    TomlTable orbit = table.table("orbit");
    stability.orbit_deg = orbit.number("degrees", 1e-6, 360.0);
    stability.orbit_views = orbit.whole("views", 5, 2, 1000);
    orbit.finish();
  }
  if (table.has("dolly")) {
    TomlTable dolly = table.table("dolly");
    stability.dolly_factors = dolly.numbers("factors", 1e-3, 1e3);
    if (stability.dolly_factors.size() < 2)
      dolly.fail("factors", "'stability.dolly.factors' needs at least two");
    dolly.finish();
  }
  if (table.has("jitter")) {
    TomlTable jitter = table.table("jitter");
    stability.jitter_views = jitter.whole("views", 8, 2, 1000);
    jitter.finish();
  }
  if (!table.has("orbit") && !table.has("dolly") && !table.has("jitter"))
    table.fail("orbit", "'stability' needs an 'orbit', a 'dolly' or a 'jitter'");
  stability.points = table.whole("points", stability.points, 0, 100000000);
  stability.seed = static_cast<std::uint64_t>(table.whole("seed", 1, 0, 2147483647));
  table.finish();
  return stability;
}

// The value that an override states. What is not TOML is a string: a bare word spares the quotes inside
// quotes on a shell's command line.
toml::value override_value(const std::string& text, const std::string& literal) {
  const auto parse = [&](const std::string& right_side) {
    std::istringstream stream("value = " + right_side);
    return toml::parse(stream, "--set " + text);
  };
  try {
    const toml::value table = parse(literal);
    if (table.as_table().size() == 1) return table.at("value");
  } catch (const toml::exception&) {
  }
  std::ostringstream quoted;
  quoted << toml::value(literal);
  return parse(quoted.str()).at("value");
}

// "a.b=c": walks the tree, into arrays by index or by an entry's name, and sets the value.
void apply_override(toml::value& root, const std::string& text) {
  const SourceLocation where{"--set " + text};
  const std::size_t equals = text.find('=');
  const std::string keys = text.substr(0, equals);
  std::vector<std::string> path;
  std::stringstream stream(keys);
  for (std::string part; std::getline(stream, part, '.');) path.push_back(part);
  const bool whole =
      std::none_of(path.begin(), path.end(), [](const std::string& part) { return part.empty(); });
  if (equals == std::string::npos || path.empty() || !whole || keys.ends_with('.')) {
    throw_input_error(where, "must have the form key.key=value");
  }

  toml::value* at = &root;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::string& key = path[i];
    if (at->is_array()) {
      auto& entries = at->as_array();
      const bool index =
          !key.empty() && std::all_of(key.begin(), key.end(), [](char c) { return c >= '0' && c <= '9'; });
      toml::value* found = nullptr;
      if (index && key.size() < 9 && std::stoul(key) < entries.size()) found = &entries[std::stoul(key)];
      for (toml::value& entry : entries) {
        if (found == nullptr && entry.is_table() && entry.contains("name") && entry.at("name").is_string() &&
            entry.at("name").as_string().str == key) {
          found = &entry;
        }
      }
      if (found == nullptr)
        throw_input_error(where, "'{}' names no entry of this array ({} entries)", key, entries.size());
      at = found;
    } else {
      if (!at->is_table()) throw_input_error(where, "'{}' is below a value that is not a table", key);
      if (!at->contains(key)) at->as_table()[key] = override_value(text, "{}");
      at = &at->as_table()[key];
    }
  }
  *at = override_value(text, text.substr(equals + 1));
}

double as_axis_value(const toml::value& value) {
  if (value.is_integer()) return static_cast<double>(value.as_integer());
  if (value.is_floating()) return value.as_floating();
  fail_at(value, "'sweep.values' must be numbers, or 'sweep.axis_values' must say what they amount to");
}

// One value, for each key.
std::vector<std::string> read_sweep_value(const toml::value& value, std::size_t keys) {
  if (keys == 1) return {inline_text(value)};
  if (!value.is_array() || value.as_array().size() != keys)
    fail_at(value, fmt::format("'sweep.values' must hold {} values each, one for every key", keys));
  std::vector<std::string> texts;
  for (const toml::value& entry : value.as_array()) texts.push_back(inline_text(entry));
  return texts;
}

void check_axis(const TomlTable& table, const SweepSpec& sweep) {
  const char* key = table.has("axis_values") ? "axis_values" : "values";
  const std::vector<double>& axis = sweep.axis;
  if (axis.size() != sweep.values.size()) {
    table.fail(key, fmt::format("'sweep.axis_values' has {} entries for {} values", axis.size(),
                                sweep.values.size()));
  }
  if (axis.size() < 2) table.fail(key, "'sweep.values' needs at least two");
  for (std::size_t i = 1; i < axis.size(); ++i) {
    if ((axis[i] - axis[i - 1]) * (axis[1] - axis[0]) <= 0.0)
      table.fail(key, fmt::format("'sweep.{}' must grow or fall from each to the next", key));
  }
  if (sweep.scale == "log" && std::min(axis.front(), axis.back()) <= 0.0)
    table.fail(key, fmt::format("'sweep.{}' must be positive on a logarithmic scale", key));
}

SweepSpec read_sweep(TomlTable table) {
  SweepSpec sweep;
  if (!table.has("key")) table.fail("key", "'sweep.key' is missing");
  sweep.keys = table.raw("key").is_string() ? std::vector{table.text("key")} : table.texts("key");
  for (const std::string& key : sweep.keys) {
    if (key == "name" || key == "sweep" || key.starts_with("sweep.") || key.find('=') != std::string::npos)
      table.fail("key", fmt::format("'sweep.key' must not be '{}'", key));
    if (key == "composite" || key.starts_with("composite."))
      table.fail("key",
                 fmt::format("'sweep.key' must not be '{}': a sweep's pictures are composed alike", key));
  }
  if (sweep.keys.empty()) table.fail("key", "'sweep.key' must name a key");
  sweep.where = table.where("key");
  if (!table.has("values") || !table.raw("values").is_array())
    table.fail("values", "'sweep.values' must be an array");
  const auto& values = table.raw("values").as_array();
  for (const toml::value& value : values) sweep.values.push_back(read_sweep_value(value, sweep.keys.size()));
  sweep.axis = table.numbers("axis_values", -kHuge, kHuge);
  if (!table.has("axis_values")) {
    for (const toml::value& value : values) sweep.axis.push_back(as_axis_value(value));
  }
  sweep.title = table.text("title", fmt::format("{}", fmt::join(sweep.keys, ", ")));
  sweep.unit = table.text("unit", "");
  sweep.difficulty = table.one_of("difficulty", sweep.difficulty, {"up", "down"});
  sweep.scale = table.one_of("scale", sweep.scale, {"linear", "log"});
  check_axis(table, sweep);
  table.finish();
  return sweep;
}

// Two entries of an array of tables under one name: an error at the later one. `name_of` gives (key, name).
template <typename NameOf>
void check_distinct(const std::vector<TomlTable>& tables, const std::string& what, const NameOf& name_of) {
  std::set<std::string> seen;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const auto& [key, name] = name_of(i);
    if (!seen.insert(name).second) tables[i].fail(key, fmt::format("two {} '{}'", what, name));
  }
}

ExperimentSpec read_root(TomlTable root, const std::filesystem::path& file) {
  ExperimentSpec spec;
  spec.file = file;
  spec.name = root.text("name", file.stem().string());
  if (spec.name.empty() || spec.name == "." || spec.name == ".." ||
      spec.name.find('/') != std::string::npos) {
    root.fail("name",
              "'name' names the folder of the results: it must not be empty, '.' or '..', nor hold a '/'");
  }
  spec.question = root.text("question", "");
  spec.expectation = root.text("expectation", "");
  spec.source = root.text("source", "");
  if (!root.has("scene")) root.fail("scene", "'scene' is missing: an experiment needs a [scene]");
  spec.scene = read_scene(root.table("scene"));
  for (const TomlTable& table : root.tables("light")) spec.lights.push_back(read_light(table));
  if (spec.lights.empty())
    root.fail("light", "'light' is missing: an experiment needs at least one [[light]]");
  spec.shading = read_shading(root.table("shading"), spec.scene);
  for (const TomlTable& table : root.tables("view")) spec.views.push_back(read_view(table));
  if (spec.views.empty()) root.fail("view", "'view' is missing: an experiment needs at least one [[view]]");
  for (const TomlTable& table : root.tables("profile")) spec.profiles.push_back(read_profile(table));
  if (spec.profiles.empty())
    root.fail("profile", "'profile' is missing: an experiment needs at least one [[profile]]");
  std::vector<TomlTable> methods;  // the one that each method comes from
  for (const TomlTable& table : root.tables("method")) {
    for (MethodSpec& method : read_methods(table)) {
      spec.methods.push_back(std::move(method));
      methods.push_back(table);
    }
  }
  if (spec.methods.empty())
    root.fail("method", "'method' is missing: an experiment needs at least one [[method]]");
  spec.truth = read_truth(root.table("truth"));
  spec.metrics = read_metrics(root.table("metrics"));
  if (root.has("composite")) spec.composite = read_composite(root.table("composite"));
  spec.timing = read_timing(root.table("timing"));
  for (const TomlTable& table : root.tables("threshold")) {
    spec.thresholds.push_back(read_threshold(table));
    if (spec.thresholds.back().metric.starts_with("visible") && !spec.composite) {
      table.fail("metric", fmt::format("'threshold.metric' is \"{}\", which there is with [composite] alone",
                                       spec.thresholds.back().metric));
    }
    require_label(table, "threshold.method", spec.thresholds.back().method, spec.methods);
  }
  for (const TomlTable& table : root.tables("ladder"))
    spec.ladders.push_back(read_ladder(table, spec.methods));
  if (root.has("sweep")) spec.sweep = read_sweep(root.table("sweep"));
  if (root.has("stability")) spec.stability = read_stability(root.table("stability"), spec.views);

  check_distinct(root.tables("view"), "views are named",
                 [&](std::size_t i) { return std::pair("name", spec.views[i].name); });
  check_distinct(root.tables("profile"), "profiles are named",
                 [&](std::size_t i) { return std::pair("name", spec.profiles[i].name); });
  check_distinct(methods, "methods have the label", [&](std::size_t i) {
    return std::pair(methods[i].has("label") ? "label" : "name", spec.methods[i].label);
  });
  check_distinct(root.tables("ladder"), "ladders are named",
                 [&](std::size_t i) { return std::pair("name", spec.ladders[i].name); });
  root.finish();
  return spec;
}

// Whether an experiment names a method other than `none`. What is not well formed is for read_root to say.
bool has_alternatives(const toml::value& root) {
  if (!root.contains("method")) return false;
  const toml::value& methods = root.at("method");
  if (!methods.is_array()) return true;
  return std::any_of(methods.as_array().begin(), methods.as_array().end(), [](const toml::value& method) {
    const bool named = method.is_table() && method.contains("name") && method.at("name").is_string();
    return !named || method.at("name").as_string().str != "none";
  });
}

toml::value standard_methods() {
  const std::string name = "config/standard_methods.toml";
  std::istringstream stream(standard::embedded(name));
  return toml::parse(stream, name).at("method");
}

// What a value makes of the experiment is read as an override is; what is wrong with it is wrong in the file.
ExperimentSpec sweep_point(toml::value root, const SweepSpec& sweep, const std::vector<std::string>& value,
                           const std::filesystem::path& file) {
  root.as_table().erase("sweep");
  try {
    for (std::size_t k = 0; k < value.size(); ++k) apply_override(root, sweep.keys[k] + "=" + value[k]);
    return read_root(TomlTable(root, ""), file);
  } catch (const Error& error) {
    throw Error(error.kind(), sweep.where,
                fmt::format("'sweep' at {}: {}", fmt::join(value, ", "), error.what()));
  }
}

}  // namespace

ExperimentSpec read_experiment_or_standard(const std::filesystem::path& file) {
  toml::value root = read_toml_file(file);
  const bool standard = !has_alternatives(root);
  if (standard) root.as_table()["method"] = standard_methods();
  ExperimentSpec spec = read_root(TomlTable(root, ""), file);
  spec.standard_methods = standard;
  if (spec.sweep)
    throw_input_error(spec.sweep->where,
                      "'sweep': one setting for several scenes is not what is asked for; take it "
                      "out, and give the value that counts in its place");
  return spec;
}

ExperimentSpec read_experiment(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  toml::value root = read_toml_file(file);
  for (const std::string& override_text : overrides) apply_override(root, override_text);
  ExperimentSpec spec = read_root(TomlTable(root, ""), file);
  if (!spec.sweep) return spec;
  for (const std::vector<std::string>& value : spec.sweep->values)
    spec.sweep->point.push_back(sweep_point(root, *spec.sweep, value, file));
  return spec;
}

}  // namespace truescatter
