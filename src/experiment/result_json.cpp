#include "experiment/result_json.h"

#include <set>

#include "experiment/fit_file.h"

namespace truescatter {
namespace {

using nlohmann::json;

json certificate_json(const Certificate& certificate, const AuditSample& audited) {
  json classes = json::object();
  for (const auto& [name, count] : audited.classes) classes[name] = count;
  return {{"audited", certificate.audited},       {"classes", classes},
          {"max_error", certificate.max_error},   {"tolerance", certificate.tolerance},
          {"tail_bound", certificate.tail_bound}, {"open_share_95", certificate.open_share},
          {"weight", certificate.weight},         {"approximation", certificate.approximation}};
}

// What every truth says of itself.
void put_truth(json& object, const std::string& view, const Profile& profile, const TruthImage& truth,
               const AuditSample& audited) {
  object["view"] = view;
  object["profile"] = profile.name;
  object["seconds"] = truth.seconds;
  object["cached"] = truth.cached;
  object["uncertainty"] = truth.certificate.uncertainty();
  object["certificate"] = certificate_json(truth.certificate, audited);
}

}  // namespace

json vector_json(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

json composite_json(const CompositeSpec& composite) {
  json object = {{"exposure", composite.exposure},
                 {"tone", composite.tone},
                 {"albedo", vector_json(composite.albedo)},
                 {"specular", composite.specular},
                 {"pixels_per_degree", composite.pixels_per_degree}};
  if (!composite.specular) return object;
  object["f0"] = composite.f0;
  object["beckmann"] = composite.beckmann;
  if (composite.regions.empty()) {
    object["intensity"] = composite.intensity;
    object["roughness"] = composite.roughness;
  } else {
    object["regions"] = composite.regions;
  }
  return object;
}

json target_json(const OwnTarget& target) {
  json object = {{"metric", target.geodesic ? "geodesic" : "euclidean"},
                 {"normalised", target.normalised},
                 {"visible_only", target.visible_only},
                 {"transmittance", target.transmittance}};
  object["r_max_mm"] = target.r_max_mm ? json(*target.r_max_mm) : json();
  return object;
}

json settings_json(const Settings& settings) {
  json object = json::object();
  for (const auto& [name, value] : settings.values()) {
    std::visit([&, key = name](const auto& v) { object[key] = v; }, value);
  }
  return object;
}

json profile_json(const Profile& profile) {
  json terms = json::array();
  for (const GaussianTerm& term : profile.terms) {
    terms.push_back({{"variance_mm2", vector_json(term.variance_mm2)}, {"weight", vector_json(term.weight)}});
  }
  return {{"name", profile.name},
          {"title", profile.title},
          {"source", profile.source},
          {"delta_weight", vector_json(profile.delta_weight)},
          {"gaussians", terms},
          {"total_weight", vector_json(profile.total_weight())},
          {"widest_std_dev_mm", profile.widest_std_dev_mm()},
          {"r_max_mm", profile.r_max_mm}};
}

json scene_json(const ExperimentSpec& spec, const PreparedScene& scene) {
  std::size_t skin = 0;
  std::set<int> components_of_skin;
  for (const ShadingTriangle& triangle : scene.shading.triangles) {
    if (!triangle.skin) continue;
    ++skin;
    components_of_skin.insert(triangle.component);
  }
  json object = {{"mesh", spec.scene.mesh},
                 {"characters", scene.mesh.characters},
                 {"triangles", scene.mesh.triangle_count()},
                 {"area_mm2", surface_area_mm2(scene.mesh)},
                 {"shading_triangles", scene.shading.triangles.size()},
                 {"skin_triangles", skin},
                 {"skin_components", components_of_skin.size()},
                 {"mask_truth", spec.truth.mask_truth},
                 {"largest_irradiance", scene.largest_irradiance},
                 {"irradiance_residual",
                  {{"mean", scene.shading.residual.mean},
                   {"p99", scene.shading.residual.p99},
                   {"tolerance", spec.shading.tolerance},
                   {"floor_mm", spec.shading.floor_mm}}}};
  if (!spec.scene.normal_map.empty()) {
    object["normal_map"] = {{"file", spec.scene.normal_map},
                            {"strength", spec.scene.normal_map_strength},
                            {"green", spec.scene.normal_map_green},
                            {"edge_mm", spec.shading.normal_map_edge_mm}};
  }
  if (!spec.scene.albedo.empty()) {
    object["albedo"] = spec.scene.albedo;
    const double before = spec.scene.albedo_exponent_before();
    object["texturing"] = {{"where", spec.scene.texturing}, {"exponent_before", before}};
    if (before > 0.0) object["texturing"]["edge_mm"] = spec.shading.albedo_edge_mm;
  }
  if (!scene.uvs) {
    object["uv"] = nullptr;
    return object;
  }
  const UvReport& uv = *scene.uvs;
  object["uv"] = {{"flipped", uv.flipped},
                  {"zero_area", uv.zero_area},
                  {"overlapping", uv.overlapping},
                  {"outside_unit_square", uv.outside_unit_square},
                  {"mm_per_unit_median", uv.mm_per_unit_median},
                  {"mm_per_unit_p05", uv.mm_per_unit_p05},
                  {"mm_per_unit_p95", uv.mm_per_unit_p95},
                  {"anisotropy_p95", uv.anisotropy_p95}};
  return object;
}

json truth_json(const std::string& view, const PlannedTruth& planned, const TruthImage& truth,
                const AuditSample& audited) {
  json object = target_json(planned.target);
  object["id"] = truth_id(view, *planned.profile, planned.target);
  put_truth(object, view, *planned.profile, truth, audited);
  object["headline"] = planned.is_headline();
  object["own_target_of"] = planned.own_target_of;
  object["extra"] = planned.extra;
  return object;
}

json profile_fit_json(const DiffusionProfile& profile, const FitSpec& asked, const GaussianFit& fit) {
  json object = fit_json(profile, asked, fit);
  object.erase("curve");
  object.erase("schema");
  return object;
}

json profile_model_json(const ProfileModel& model) {
  const ProfileModelSpec& spec = model.spec;
  json object = {{"model", spec.model},
                 {"title", model.title},
                 {"sigma_a_per_mm", vector_json(spec.sigma_a_per_mm)},
                 {"sigma_s_prime_per_mm", vector_json(spec.sigma_s_prime_per_mm)},
                 {"eta", spec.eta},
                 {"albedo", vector_json(model.albedo)},
                 {"mixture",
                  {{"gaussians", gaussian_levels(model.mixture).size()},
                   {"tolerance", spec.tolerance},
                   {"error_bound", vector_json(model.error_bound)}}}};
  object["material"] = spec.material.empty() ? json() : json(spec.material);
  object["thickness_mm"] = spec.model == "multipole" ? json(spec.thickness_mm) : json();
  return object;
}

json model_truth_json(const std::string& view, const Profile& profile, const ProfileModel& model,
                      bool normalised, const ProfileTruth& truth, const AuditSample& audited) {
  json object = target_json({false, normalised, std::nullopt});
  object["id"] = model_truth_id(view, profile, normalised);
  put_truth(object, view, profile, normalised ? truth.normalised : truth.raw, audited);
  object["headline"] = false;
  object["own_target_of"] = json::array();
  object["extra"] = false;
  object["of"] = profile_model_json(model);
  object["radial_check"] = {{"points", truth.check.points},
                            {"max_difference", truth.check.max_difference},
                            {"allowed", truth.check.allowed}};
  return object;
}

}  // namespace truescatter
