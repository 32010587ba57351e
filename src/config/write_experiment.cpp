#include <sstream>
#include <string_view>
#include <type_traits>

#include "config/experiment_spec.h"
#include "config/toml_reader.h"

namespace truescatter {
namespace {

// Numbers have the fewest digits that give the same double.
template <typename Number>
requires std::is_arithmetic_v<Number> std::string line(const std::string& key, Number number) {
  return fmt::format("{} = {}\n", key, number);
}
std::string line(const std::string& key, const Vec3d& v) {
  return fmt::format("{} = [{}, {}, {}]\n", key, v.x(), v.y(), v.z());
}
std::string line(const std::string& key, const std::string& text) {
  std::ostringstream stream;
  stream << key << " = " << toml::value(text) << "\n";
  return stream.str();
}

std::string line(const std::string& key, const std::vector<std::string>& texts) {
  std::vector<std::string> quoted;
  for (const std::string& text : texts) {
    std::ostringstream stream;
    stream << toml::value(text);
    quoted.push_back(stream.str());
  }
  return fmt::format("{} = [{}]\n", key, fmt::join(quoted, ", "));
}

std::string line(const std::string& key, const std::vector<double>& numbers) {
  return fmt::format("{} = [{}]\n", key, fmt::join(numbers, ", "));
}

// A path that names the same file from wherever it is read. One that starts with a variable does
// (expanded_path).
std::string portable_path(const ExperimentSpec& spec, const std::string& path) {
  const bool keep = path.empty() || path.starts_with(kBuiltinPrefix) || path.starts_with("${") ||
                    std::filesystem::path(path).is_absolute();
  return keep ? path : std::filesystem::absolute(spec.file.parent_path() / path).lexically_normal().string();
}

std::string own_method_toml(const ExperimentSpec& spec, const OwnMethodSpec& own) {
  std::string text = line("title", own.title) + line("source", own.source);
  if (!own.image.empty())
    return text + line("image", portable_path(spec, own.image)) + line("layer", own.layer);
  std::vector<std::string> include;
  for (const std::string& path : own.include) include.push_back(portable_path(spec, path));
  return text + line("run", own.run) + line("include", include);
}

std::string own_tables_toml(const ExperimentSpec& spec, const OwnMethodSpec& own) {
  std::string text = "[method.target]\n" +
                     line("metric", std::string(own.geodesic ? "geodesic" : "euclidean")) +
                     line("normalised", own.normalised) + line("visible_only", own.visible_only) +
                     line("transmittance", own.transmittance);
  if (own.r_max_mm) text += line("r_max_mm", *own.r_max_mm);
  for (const OwnMethodSpec::Pass& pass : own.passes) {
    text +=
        "[[method.pass]]\n" + line("shader", portable_path(spec, pass.shader)) + line("inputs", pass.inputs);
    if (pass.settings.empty()) continue;
    text += "[method.pass.settings]\n";
    for (const auto& [key, value] : pass.settings) text += line(key, value);
  }
  return text;
}

std::string method_toml(const ExperimentSpec& spec, const MethodSpec& method) {
  std::string text = "\n[[method]]\n" + line("name", method.name) + line("label", method.label);
  if (method.own) text += own_method_toml(spec, *method.own);
  if (!method.settings.empty()) text += "[method.settings]\n";
  for (const auto& [key, value] : method.settings) {
    std::visit([&, k = key](const auto& v) { text += line(k, v); }, value);
  }
  if (method.own) text += own_tables_toml(spec, *method.own);
  return text;
}

std::string profile_model_toml(const ExperimentSpec& spec, const ProfileModelSpec& of) {
  std::string text = "[profile.of]\n" + line("model", of.model);
  if (!of.table.empty()) {
    text += line("table", portable_path(spec, of.table));
  } else if (!of.layers.empty()) {
    text += line("layers", portable_path(spec, of.layers));
  } else if (!of.material.empty()) {
    text += line("material", of.material);
  } else {
    text += line("sigma_a", of.sigma_a_per_mm) + line("sigma_s_prime", of.sigma_s_prime_per_mm) +
            line("eta", of.eta);
  }
  if (of.thickness_mm > 0.0) text += line("thickness_mm", of.thickness_mm);
  if (of.model == "burley") text += line("scaling", of.scaling);
  return text + line("truth", of.truth) + line("tolerance", of.tolerance);
}

std::string fit_toml(const ExperimentSpec& spec, const FitSpec& fit) {
  std::string text = "[profile.fit]\n";
  if (!fit.file.empty()) return text + line("file", portable_path(spec, fit.file));
  text += fit.gaussians > 0 ? line("gaussians", fit.gaussians)
                            : line("gaussians", std::string("auto")) + line("tolerance", fit.tolerance);
  text += line("norm", fit.norm) + line("weights", std::string(fit.nonnegative ? "non-negative" : "free")) +
          line("energy", std::string(fit.keep_albedo ? "albedo" : "free")) +
          line("variances", std::string(fit.shared_variances ? "shared" : "per-channel"));
  if (fit.min_variance_mm2) text += line("min_variance_mm2", *fit.min_variance_mm2);
  if (fit.max_variance_mm2) text += line("max_variance_mm2", *fit.max_variance_mm2);
  return text + line("seed", fit.seed);
}

std::string profile_toml(const ExperimentSpec& spec, const ProfileSpec& profile) {
  std::string text = "\n[[profile]]\n" + line("name", profile.name);
  const std::string of = profile.of ? profile_model_toml(spec, *profile.of) : "";
  if (profile.builtin) return text + of;
  if (profile.fit) {
    if (profile.r_max_mm > 0.0) text += line("r_max_mm", profile.r_max_mm);
    return text + fit_toml(spec, *profile.fit) + of;
  }
  text += line("delta_weight", profile.delta_weight) + line("r_max_mm", profile.r_max_mm);
  for (const auto& gaussian : profile.gaussians) {
    text += "[[profile.gaussian]]\n" + line("variance_mm2", gaussian.variance_mm2) +
            line("weight", gaussian.weight);
  }
  return text + of;
}

std::string scene_toml(const ExperimentSpec& spec) {
  const SceneSpec& scene = spec.scene;
  const auto portable = [&](const std::string& path) { return portable_path(spec, path); };
  std::string text = "\n[scene]\n" + line("mesh", portable(scene.mesh));
  if (!scene.mesh.starts_with(kBuiltinPrefix)) {
    text += line("unit_mm", scene.unit_mm) + line("normals", scene.normals) +
            line("loop_subdivisions", scene.loop_subdivisions) + line("flip_v", scene.flip_v);
  }
  if (!scene.skin_mask.empty()) text += line("skin_mask", portable(scene.skin_mask));
  if (!scene.transmitter_mask.empty()) text += line("transmitter_mask", portable(scene.transmitter_mask));
  if (!scene.normal_map.empty()) {
    text += line("normal_map", portable(scene.normal_map)) +
            line("normal_map_strength", scene.normal_map_strength) +
            line("normal_map_green", scene.normal_map_green);
  }
  if (!scene.albedo.empty()) {
    text += line("albedo", portable(scene.albedo)) + line("texturing", scene.texturing);
    if (scene.texturing == "mix") text += line("texturing_mix", scene.texturing_mix);
  }
  if (!scene.obtain.empty()) text += line("obtain", scene.obtain);
  if (!scene.parameters.empty()) text += "[scene.parameters]\n";
  for (const auto& [key, value] : scene.parameters) text += line(key, value);
  for (const CharacterSpec& character : scene.characters) {
    text += "[[scene.character]]\n" + line("position_mm", character.position_mm) +
            line("rotation_deg", character.rotation_deg);
  }
  return text;
}

std::string light_toml(const ExperimentSpec& spec, const LightSpec& light) {
  std::string text = "\n[[light]]\n" + line("type", light.type);
  if (light.type == "environment") {
    text += line("map", portable_path(spec, light.map)) + line("rotation_deg", light.rotation_deg) +
            line("occlusion", light.occlusion);
    if (light.occlusion) text += line("occlusion_rays", light.occlusion_rays);
    return text + line("color", light.color);
  }
  if (light.type == "directional") {
    text += line("direction", light.direction);
  } else {
    text += line("position_mm", light.position_mm) + line("reference_mm", light.reference_mm);
  }
  return text + line("color", light.color) + line("shadows", light.shadows);
}

std::string view_toml(const ViewSpec& view) {
  return "\n[[view]]\n" + line("name", view.name) + line("eye_mm", view.eye_mm) +
         line("target_mm", view.target_mm) + line("up", view.up) + line("fov_deg", view.fov_deg) +
         line("width_px", view.width_px) + line("height_px", view.height_px);
}

// Whether a sweep's key names a file.
bool names_file(std::string_view key) {
  constexpr std::array<std::string_view, 11> kFiles = {
      "mesh", "skin_mask", "transmitter_mask", "normal_map", "albedo", "map",
      "file", "table",     "layers",           "regions",    "image"};
  const std::size_t dot = key.rfind('.');
  const std::string_view last = dot == std::string_view::npos ? key : key.substr(dot + 1);
  return std::find(kFiles.begin(), kFiles.end(), last) != kFiles.end();
}

// A sweep's value as TOML; of a key that may name a file, a text is its path (an albedo may be numbers too).
std::string portable_value(const ExperimentSpec& spec, const std::string& key, const std::string& value) {
  if (!names_file(key)) return value;
  std::istringstream stream("value = " + value + "\n");
  const toml::value read = toml::find(toml::parse(stream, "a sweep's value"), "value");
  return read.is_string() ? inline_text(toml::value(portable_path(spec, read.as_string().str))) : value;
}

std::string sweep_toml(const ExperimentSpec& spec, const SweepSpec& sweep) {
  std::vector<std::string> values;
  for (const std::vector<std::string>& value : sweep.values) {
    std::vector<std::string> portable;
    for (std::size_t k = 0; k < value.size(); ++k)
      portable.push_back(portable_value(spec, sweep.keys[k], value[k]));
    const std::string text = fmt::format("{}", fmt::join(portable, ", "));
    values.push_back(sweep.keys.size() == 1 ? text : "[" + text + "]");
  }
  return "\n[sweep]\n" + line("key", sweep.keys) + fmt::format("values = [{}]\n", fmt::join(values, ", ")) +
         line("axis_values", sweep.axis) + line("title", sweep.title) + line("unit", sweep.unit) +
         line("difficulty", sweep.difficulty) + line("scale", sweep.scale);
}

std::string stability_toml(const StabilitySpec& stability) {
  std::string text = "\n[stability]\n";
  if (!stability.view.empty()) text += line("view", stability.view);
  text += line("points", stability.points) + line("seed", stability.seed);
  if (stability.orbit_views > 0) {
    text +=
        "[stability.orbit]\n" + line("degrees", stability.orbit_deg) + line("views", stability.orbit_views);
  }
  if (!stability.dolly_factors.empty())
    text += "[stability.dolly]\n" + line("factors", stability.dolly_factors);
  if (stability.jitter_views > 0) text += "[stability.jitter]\n" + line("views", stability.jitter_views);
  return text;
}

std::string composite_toml(const ExperimentSpec& spec, const CompositeSpec& composite) {
  std::string text = "\n[composite]\n" + line("exposure", composite.exposure) + line("tone", composite.tone) +
                     line("albedo", composite.albedo) + line("specular", composite.specular);
  if (composite.regions.empty()) {
    text += line("intensity", composite.intensity) + line("roughness", composite.roughness);
  } else {
    text += line("regions", portable_path(spec, composite.regions));
  }
  return text + line("f0", composite.f0) + line("beckmann", composite.beckmann) +
         line("pixels_per_degree", composite.pixels_per_degree);
}

}  // namespace

std::string to_toml(const ExperimentSpec& spec) {
  std::string text = "# Every default written out; running this file repeats the run.\n";
  text += line("name", spec.name) + line("question", spec.question) + line("expectation", spec.expectation) +
          line("source", spec.source);
  text += scene_toml(spec);
  for (const LightSpec& light : spec.lights) text += light_toml(spec, light);
  text +=
      "\n[shading]\n" + line("tolerance", spec.shading.tolerance) + line("floor_mm", spec.shading.floor_mm);
  if (!spec.scene.normal_map.empty()) text += line("normal_map_edge_mm", spec.shading.normal_map_edge_mm);
  if (spec.scene.albedo_exponent_before() > 0.0) text += line("albedo_edge_mm", spec.shading.albedo_edge_mm);
  for (const ViewSpec& view : spec.views) text += view_toml(view);
  for (const ProfileSpec& profile : spec.profiles) text += profile_toml(spec, profile);
  for (const MethodSpec& method : spec.methods) text += method_toml(spec, method);
  text += "\n[truth]\n" + line("tolerance", spec.truth.tolerance) +
          line("audit_points", spec.truth.audit_points) + line("seed", spec.truth.seed) +
          line("mask_truth", spec.truth.mask_truth) + line("geodesic", spec.truth.geodesic) +
          line("visible_only", spec.truth.visible_only) + line("light_paths", spec.truth.light_paths) +
          line("cache", spec.truth.cache);
  text += "\n[metrics]\n" + line("seam", spec.metrics.seam) + line("leak", spec.metrics.leak);
  if (spec.composite) text += composite_toml(spec, *spec.composite);
  text += "\n[timing]\n" + line("warm_up", spec.timing.warm_up) + line("repeats", spec.timing.repeats);
  for (const ThresholdSpec& threshold : spec.thresholds) {
    text += "\n[[threshold]]\n" + line("method", threshold.method) + line("metric", threshold.metric) +
            line("maximum", threshold.maximum);
  }
  for (const LadderSpec& ladder : spec.ladders) {
    text += "\n[[ladder]]\n" + line("name", ladder.name);
    for (const LadderSpec::Rung& rung : ladder.rungs) {
      text += "[[ladder.rung]]\n" +
              (rung.truth.empty() ? line("method", rung.method) : line("truth", rung.truth)) +
              line("assumption", rung.assumption);
    }
  }
  if (spec.stability) text += stability_toml(*spec.stability);
  if (spec.sweep) text += sweep_toml(spec, *spec.sweep);
  return text;
}

}  // namespace truescatter
