#include "experiment/run_experiment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <list>
#include <optional>

#include "core/file.h"
#include "core/image_io.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "experiment/metrics_json.h"
#include "experiment/plan.h"
#include "experiment/provenance.h"
#include "experiment/results.h"
#include "experiment/scene_setup.h"
#include "experiment/view_truth.h"
#include "gpu/timer.h"
#include "metrics/contours.h"
#include "metrics/error_stats.h"
#include "metrics/map_picture.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr double kSmallMass = 0.5;

// A picture that waits for the error maps' common range.
struct PendingRun {
  std::size_t index;  // of runs[] in results.json
  std::string stem;   // of its files
  Image exitance;
  Image error;
};

struct PendingTruth {
  std::string stem;
  Image rgb;
  Image mass;
};

// Everything of one view that outlives its computation.
struct PendingView {
  std::string name;
  Image irradiance;
  Image mask;      // skin
  Image measured;  // skin with mass enough to be measured
  std::list<PendingTruth> truths;
  std::list<PendingRun> runs;
};

json target_json(const OwnTarget& target) {
  json object = {{"metric", target.geodesic ? "geodesic" : "euclidean"}, {"normalised", target.normalised}};
  object["r_max_mm"] = target.r_max_mm ? json(*target.r_max_mm) : json();
  return object;
}

json certificate_json(const Certificate& certificate) {
  return {{"audited", certificate.audited},
          {"max_error", certificate.max_error},
          {"tolerance", certificate.tolerance},
          {"tail_bound", certificate.tail_bound},
          {"open_share_95", certificate.open_share}};
}

json settings_json(const Settings& settings) {
  json object = json::object();
  for (const auto& [name, value] : settings.values()) {
    std::visit([&, key = name](const auto& v) { object[key] = v; }, value);
  }
  return object;
}

json rgb_json(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

json profile_json(const Profile& profile) {
  json terms = json::array();
  for (const GaussianTerm& term : profile.terms) {
    terms.push_back({{"variance_mm2", rgb_json(term.variance_mm2)}, {"weight", rgb_json(term.weight)}});
  }
  return {{"name", profile.name},
          {"title", profile.title},
          {"source", profile.source},
          {"delta_weight", rgb_json(profile.delta_weight)},
          {"gaussians", terms},
          {"total_weight", rgb_json(profile.total_weight())},
          {"widest_std_dev_mm", profile.widest_std_dev_mm()},
          {"r_max_mm", profile.r_max_mm}};
}

json scene_json(const ExperimentSpec& spec, const PreparedScene& scene) {
  std::size_t skin = 0;
  for (const ShadingTriangle& triangle : scene.shading.triangles) skin += triangle.skin ? 1 : 0;
  json object = {{"mesh", spec.scene.mesh},
                 {"triangles", scene.mesh.triangle_count()},
                 {"area_mm2", surface_area_mm2(scene.mesh)},
                 {"shading_triangles", scene.shading.triangles.size()},
                 {"skin_triangles", skin},
                 {"skin_components", scene.shading.component_count},
                 {"largest_irradiance", scene.largest_irradiance},
                 {"irradiance_residual",
                  {{"mean", scene.shading.residual.mean},
                   {"p99", scene.shading.residual.p99},
                   {"tolerance", spec.shading.tolerance},
                   {"floor_mm", spec.shading.floor_mm}}}};
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

// What stays the same for all runs of an experiment.
struct Setup {
  const ExperimentSpec& spec;
  const Plan& plan;
  const PreparedScene& scene;
  const gpu::Context& context;
  const SurfaceBuffers& surface;
  const Surface& skin;
  const FastEngine& engine;

  double exposure() const { return 1.0 / scene.largest_irradiance; }
};

struct Measured {
  Image exitance;
  json cost;
};

std::size_t skin_pixels(const Image& mask) {
  return static_cast<std::size_t>(
      std::count_if(mask.data().begin(), mask.data().end(), [](float v) { return v > 0.0F; }));
}

Measured draw_and_time(const Setup& setup, const MethodInputs& inputs, const Method& method,
                       std::size_t pixels) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const PreparedMethod prepared = method.prepare(inputs);
  setup.context.finish();
  const double setup_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  Passes passes(setup.context);
  const Passes::Counts counts = passes.count([&] { prepared.render(passes); });
  const gpu::FrameTimes times = gpu::time_frames(
      setup.context, [&] { prepared.render(passes); }, setup.spec.timing.warm_up, setup.spec.timing.repeats);
  setup.context.check(std::string(method.name).c_str());
  Measured measured;
  measured.exitance = gpu::read_texture(setup.context, *prepared.output, 3);
  const double per_pixel = pixels > 0 ? 1.0 / static_cast<double>(pixels) : 0.0;
  measured.cost = {{"frame_ms",
                    {{"median", times.median_ms},
                     {"min", times.min_ms},
                     {"max", times.max_ms},
                     {"repeats", times.repeats}}},
                   {"setup_ms", setup_ms},
                   {"passes", counts.passes},
                   {"fetches_per_pixel", counts.texels_read * per_pixel},
                   {"bytes_per_pixel", counts.bytes_read * per_pixel}};
  return measured;
}

json truth_json(const std::string& view, const Profile& profile, const OwnTarget& target,
                const TruthImage& truth, std::size_t points) {
  json object = target_json(target);
  object["id"] = truth_id(view, profile, target);
  object["view"] = view;
  object["profile"] = profile.name;
  object["seconds"] = truth.seconds;
  object["points"] = points;
  object["uncertainty"] = truth.certificate.uncertainty();
  object["certificate"] = certificate_json(truth.certificate);
  return object;
}

// The pixels that are measured: skin whose smallest mass is at least one half; the others are counted apart.
Image measured_mask(const Image& skin, const Image& mass) {
  Image mask = skin;
  for (std::size_t i = 0; i < mask.data().size(); ++i) {
    if (mass.data()[i] < static_cast<float>(kSmallMass)) mask.data()[i] = 0.0F;
  }
  return mask;
}

class ViewRunner {
 public:
  ViewRunner(const Setup& setup, const ViewSpec& view, json& results)
      : setup_(setup),
        name_(view.name),
        results_(results),
        frame_(render_frame(setup.context, setup.surface, setup.scene.shading, camera_of(view))),
        images_(read_frame(setup.context, frame_)),
        median_depth_mm_(median_skin_depth_mm(images_)),
        truth_(setup.scene, setup.skin, images_),
        contours_(
            find_contours({images_.mask, images_.position, images_.face_normal, frame_.camera.focal_px()})) {
    pending_.name = view.name;
    pending_.irradiance = images_.irradiance;
    pending_.mask = images_.mask;
    pending_.measured = images_.mask;
  }

  PendingView run() {
    results_["views"].push_back({{"name", name_},
                                 {"width_px", frame_.camera.width_px},
                                 {"height_px", frame_.camera.height_px},
                                 {"skin_pixels", truth_.point_count()},
                                 {"median_skin_depth_mm", median_depth_mm_},
                                 {"mm_per_px", mm_per_px()},
                                 {"files", {{"irradiance", "maps/" + name_ + ".irradiance.png"}}}});
    if (truth_.point_count() == 0)
      throw_input_error({setup_.spec.file.string()}, "view '{}' sees no skin", name_);
    compute_truths();
    Progress progress(fmt::format("view {}: methods", name_),
                      setup_.plan.profiles.size() * setup_.plan.methods.size());
    for (const Profile& profile : setup_.plan.profiles) {
      measure_profile(profile, progress);
    }
    return std::move(pending_);
  }

 private:
  double mm_per_px() const { return median_depth_mm_ / frame_.camera.focal_px(); }

  void compute_truths() {
    std::vector<ViewTruth::Request> requests;
    for (const PlannedTruth& truth : planned_truths(setup_.plan)) {
      if (!truth.target.geodesic) requests.push_back({truth.profile, truth.target});
    }
    truth_.compute(requests, setup_.spec.truth, setup_.engine);
  }

  void measure_profile(const Profile& profile, Progress& progress) {
    const TruthImage headline = truth_.image({&profile, OwnTarget{}});
    results_["truths"].push_back(truth_json(name_, profile, OwnTarget{}, headline, truth_.point_count()));
    const std::string stem = name_ + "." + profile.name;
    const Image mask = measured_mask(images_.mask, headline.smallest_mass);
    const FlipReference flip(exposed(headline.rgb, setup_.exposure()));
    for (const PlannedMethod& m : setup_.plan.methods) {
      measure_method(profile, m, headline, flip, mask);
      progress.advance();
    }
    json& truth = results_["truths"][headline_index(profile)];
    truth["low_mass_pixels"] = skin_pixels(images_.mask) - skin_pixels(mask);
    truth["files"] = {{"picture", "maps/" + stem + ".truth.png"}, {"exr", "maps/" + stem + ".truth.exr"}};
    pending_.truths.push_back({stem + ".truth", headline.rgb, headline.smallest_mass});
    // Maps show what is measured under every profile.
    for (std::size_t i = 0; i < mask.data().size(); ++i) {
      pending_.measured.data()[i] = std::min(pending_.measured.data()[i], mask.data()[i]);
    }
  }

  std::size_t headline_index(const Profile& profile) const {
    const std::string id = truth_id(name_, profile, OwnTarget{});
    std::size_t i = 0;
    while (results_["truths"][i]["id"] != id) ++i;
    return i;
  }

  void measure_method(const Profile& profile, const PlannedMethod& planned, const TruthImage& headline,
                      const FlipReference& flip, const Image& mask) {
    const Method& method = *planned.method;
    json run = {{"scene", setup_.spec.scene.mesh},
                {"view", name_},
                {"method", method.name},
                {"label", planned.label},
                {"title", method.title},
                {"source", method.source},
                {"profile", profile.name},
                {"settings", settings_json(planned.settings)},
                {"truth", truth_id(name_, profile, OwnTarget{})}};
    if (method.needs_uvs && !setup_.surface.has_uvs()) {
      run["skipped"] = "this method needs UVs, and the mesh has none";
      results_["runs"].push_back(run);
      return;
    }
    const MethodInputs inputs{setup_.context,   frame_,  setup_.surface,
                              median_depth_mm_, profile, planned.settings};
    Measured measured = draw_and_time(setup_, inputs, method, truth_.point_count());
    run["cost"] = measured.cost;
    run["metrics"] = metrics_json(
        measured.exitance,
        {headline.rgb, mask, contours_, profile.widest_std_dev_mm(), mm_per_px(), flip, setup_.exposure()});
    // Below the truth's uncertainty nothing can be told from the truth.
    const double uncertainty = headline.certificate.uncertainty() * setup_.scene.largest_irradiance;
    const json& rmse = run["metrics"]["rmse"];
    run["distinguishable"] = rmse.is_number() ? json(rmse.get<double>() > uncertainty) : json();
    if (!rmse.is_number()) run["distinguishable_reason"] = "no pixel to measure";
    add_own_target(run, profile, planned, headline, measured.exitance, mask);
    const std::string stem = name_ + "." + profile.name + "." + planned.label;
    run["files"] = {{"picture", "maps/" + stem + ".png"},
                    {"magnitude", "maps/" + stem + ".abs.png"},
                    {"signed", "maps/" + stem + ".signed.png"},
                    {"exr", "maps/" + stem + ".exr"}};
    pending_.runs.push_back({results_["runs"].size(), stem, measured.exitance,
                             signed_error(measured.exitance, headline.rgb, images_.mask)});
    results_["runs"].push_back(run);
  }

  void add_own_target(json& run, const Profile& profile, const PlannedMethod& planned,
                      const TruthImage& headline, const Image& exitance, const Image& mask) {
    const OwnTarget target = planned.method->own_target(profile, planned.settings);
    json own = target_json(target);
    const std::string id = truth_id(name_, profile, target);
    own["truth"] = id;
    if (target.geodesic) {
      own["truth"] = nullptr;
      own["metrics"] = nullptr;
      own["metrics_reason"] = "its target is geodesic, and this version computes Euclidean truths only";
    } else if (target == OwnTarget{}) {
      own["metrics"] = error_stats_json(exitance, headline.rgb, mask);
    } else {
      const TruthImage truth = truth_.image({&profile, target});
      own["metrics"] = error_stats_json(exitance, truth.rgb, mask);
      const json& truths = results_["truths"];
      const bool known =
          std::any_of(truths.begin(), truths.end(), [&](const json& t) { return t["id"] == id; });
      if (!known)
        results_["truths"].push_back(truth_json(name_, profile, target, truth, truth_.point_count()));
    }
    run["own_target"] = own;
  }

  const Setup& setup_;
  std::string name_;
  json& results_;
  Frame frame_;
  FrameImages images_;
  double median_depth_mm_;
  ViewTruth truth_;
  ContourMap contours_;
  PendingView pending_;
};

// One fixed range for every error map of the experiment: the median over the runs of the 99 % quantile,
// rounded up. The worst method's maps saturate; scaled to the worst, the good ones would be black.
double common_range(const json& results) {
  std::vector<double> quantiles;
  for (const json& run : results["runs"]) {
    if (run.contains("metrics") && run["metrics"]["p99"].is_number()) {
      quantiles.push_back(run["metrics"]["p99"].get<double>());
    }
  }
  if (quantiles.empty()) return 1.0;
  const auto middle = quantiles.begin() + static_cast<std::ptrdiff_t>(quantiles.size() / 2);
  std::nth_element(quantiles.begin(), middle, quantiles.end());
  return *middle > 0.0 ? round_range(*middle) : 1.0;
}

using Job = std::function<void()>;

// What has to be written for one view; each job is one file.
void add_jobs(const PendingView& view, const std::filesystem::path& maps, double range, double exposure,
              std::vector<Job>& jobs) {
  jobs.emplace_back([&view, maps, exposure] {
    write_png(maps / (view.name + ".irradiance.png"), display_picture(view.irradiance, exposure));
  });
  for (const PendingTruth& truth : view.truths) {
    jobs.emplace_back([&truth, maps, exposure] {
      write_png(maps / (truth.stem + ".png"), display_picture(truth.rgb, exposure));
    });
    jobs.emplace_back([&view, &truth, maps] {
      write_exr(
          maps / (truth.stem + ".exr"),
          {{"", &truth.rgb}, {"mass", &truth.mass}, {"irradiance", &view.irradiance}, {"mask", &view.mask}});
    });
  }
  for (const PendingRun& run : view.runs) {
    jobs.emplace_back([&run, maps, exposure] {
      write_png(maps / (run.stem + ".png"), display_picture(run.exitance, exposure));
    });
    jobs.emplace_back([&view, &run, maps, range] {
      write_png(maps / (run.stem + ".abs.png"),
                map_picture(run.error, view.measured, MapKind::magnitude, range, "|ERROR| LUMINANCE"));
    });
    jobs.emplace_back([&view, &run, maps, range] {
      write_png(maps / (run.stem + ".signed.png"),
                map_picture(run.error, view.measured, MapKind::signed_error, range, "ERROR LUMINANCE"));
    });
    jobs.emplace_back([&view, &run, maps] {
      write_exr(maps / (run.stem + ".exr"),
                {{"", &run.exitance}, {"error", &run.error}, {"mask", &view.mask}});
    });
  }
}

}  // namespace

RunOutcome run_experiment(const ExperimentSpec& spec, const std::filesystem::path& folder) {
  const Plan plan = make_plan(spec);
  const PreparedScene scene = prepare_scene(spec);
  const gpu::Context context;
  const SurfaceBuffers buffers(context, scene.shading);
  const Surface skin = skin_surface(scene.shading);
  const FastEngine engine(skin, spec.truth.tolerance);
  const Setup setup{spec, plan, scene, context, buffers, skin, engine};

  json results = {{"schema", kResultsSchema},
                  {"experiment",
                   {{"name", spec.name},
                    {"question", spec.question},
                    {"expectation", spec.expectation},
                    {"source", spec.source}}},
                  {"scene", scene_json(spec, scene)},
                  {"profiles", json::array()},
                  {"views", json::array()},
                  {"truths", json::array()},
                  {"runs", json::array()}};
  for (const Profile& profile : plan.profiles) results["profiles"].push_back(profile_json(profile));
  std::list<PendingView> views;
  for (const ViewSpec& view : spec.views) views.push_back(ViewRunner(setup, view, results).run());

  const double range = common_range(results);
  results["maps"] = {{"range", range}, {"quantity", "luminance"}, {"exposure", setup.exposure()}};
  results["provenance"] = provenance(context);
  const std::vector<std::string> exceeded = exceeded_thresholds(results, spec.thresholds);
  results["exceeded"] = exceeded;

  const std::filesystem::path maps = folder / "maps";
  std::error_code failure;
  std::filesystem::create_directories(maps, failure);
  if (failure) throw_run_error("{}: cannot make this folder: {}", maps.string(), failure.message());
  std::vector<Job> jobs;
  for (const PendingView& view : views) add_jobs(view, maps, range, setup.exposure(), jobs);
  {
    Progress progress("maps", jobs.size());
    parallel_for(jobs.size(), [&](std::size_t i) {
      jobs[i]();
      progress.advance();
    });
  }
  write_text_file(folder / "experiment.resolved.toml", to_toml(spec));
  write_text_file(folder / "results.csv", results_csv(results));
  write_text_file(folder / "results.json", results.dump(1) + "\n");
  return {exceeded};
}

}  // namespace truescatter
