#include "experiment/view_runner.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/image_io.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/stopwatch.h"
#include "experiment/draw_method.h"
#include "experiment/frame_files.h"
#include "experiment/ladder.h"
#include "experiment/light_path_sample.h"
#include "experiment/lit_alone.h"
#include "experiment/map_files.h"
#include "experiment/memory_estimate.h"
#include "experiment/metrics_json.h"
#include "experiment/own_method.h"
#include "experiment/pass_files.h"
#include "experiment/profile_truth.h"
#include "experiment/result_json.h"
#include "experiment/stability.h"
#include "experiment/uv_view.h"
#include "experiment/view_buffers.h"
#include "experiment/view_composite.h"
#include "experiment/view_truth.h"
#include "gpu/timer.h"
#include "metrics/contours.h"
#include "metrics/error_stats.h"
#include "metrics/map_picture.h"

namespace truescatter {
namespace {

using nlohmann::json;

struct Measured {
  Image exitance;
  json cost;
  json passes;  // the files of the textures that the method names; null where none are written
};

std::size_t skin_pixels(const Image& mask) {
  return static_cast<std::size_t>(
      std::count_if(mask.data().begin(), mask.data().end(), [](float v) { return v > 0.0F; }));
}

// What a method is drawn for: how many pixels its cost is shared by, and the stem of its files' names.
struct DrawnView {
  std::size_t skin_pixels;
  std::string stem;
};

Measured draw_and_time(const Setup& setup, const MethodInputs& inputs, const Method& method,
                       const DrawnView& view) {
  const Stopwatch watch;
  const PreparedMethod prepared = method.prepare(inputs);
  setup.context.finish();
  const double setup_ms = watch.milliseconds();
  Passes passes(setup.context);
  const Passes::Counts counts = passes.count([&] { prepared.render(passes); });
  const gpu::FrameTimes times = gpu::time_frames(
      setup.context, [&] { prepared.render(passes); }, setup.spec.timing.warm_up, setup.spec.timing.repeats);
  setup.context.check(std::string(method.name).c_str());
  Measured measured;
  measured.exitance = gpu::read_texture(setup.context, *prepared.output, 3);
  if (!setup.passes.empty()) {
    measured.passes = json::array();
    passes.record([&] { prepared.render(passes); },
                  [&](const NamedTexture& texture) {
                    measured.passes.push_back(write_named_texture(setup.passes, view.stem, texture,
                                                                  setup.exposure(), setup.origin));
                  });
  }
  const double per_pixel = view.skin_pixels > 0 ? 1.0 / static_cast<double>(view.skin_pixels) : 0.0;
  measured.cost = {{"frame_ms",
                    {{"median", times.median_ms},
                     {"min", times.min_ms},
                     {"max", times.max_ms},
                     {"repeats", times.repeats}}},
                   {"setup_ms", setup_ms},
                   {"passes", counts.passes},
                   {"fetches_per_pixel", counts.texels_read * per_pixel},
                   {"bytes_per_pixel", counts.bytes_read * per_pixel}};
  if (setup.times_shared) measured.cost["frame_ms"]["shared"] = true;
  return measured;
}

// A user's shader may divide by zero: metrics of that would be no numbers.
void check_finite(const std::string& method, const Image& exitance, const Image& mask) {
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y, 0) == 0.0F || exitance.rgb(x, y).allFinite()) continue;
      throw_input_error({}, "method '{}': its exitance at column {}, row {} is not finite", method, x, y);
    }
  }
}

// Where the colour bar lies in this view's error maps.
json color_bar_json(const Camera& camera) {
  const ColorBar bar = color_bar(camera.width_px, camera.height_px);
  return {{"left_px", bar.left_px},
          {"top_px", bar.top_px},
          {"width_px", bar.width_px},
          {"height_px", bar.height_px}};
}

// Views of one camera differ in size alone.
json camera_json(const ViewSpec& view) {
  return {{"eye_mm", vector_json(view.eye_mm)},
          {"target_mm", vector_json(view.target_mm)},
          {"up", vector_json(view.up)},
          {"fov_deg", view.fov_deg}};
}

// A truth of a profile in one view.
struct ViewedTruth {
  PlannedTruth planned;
  std::string missing;  // why there is none; empty: there is
  TruthImage image;
  Image mask;  // the pixels that are measured against it
};

// How far a truth of the visible surface may be from that of exactly what is seen, over the pixels that are
// measured, in units of the largest irradiance; 0 for others.
struct VisibilityBound {
  double rms = 0.0;
  double max = 0.0;
};

VisibilityBound visibility_bound(const ViewedTruth& truth) {
  VisibilityBound bound;
  if (truth.image.visibility_bound.empty()) return bound;
  double squares = 0.0;
  for (std::size_t i = 0; i < truth.mask.data().size(); ++i) {
    if (truth.mask.data()[i] == 0.0F) continue;
    const double b = truth.image.visibility_bound.data()[i];
    squares += b * b;
    bound.max = std::max(bound.max, b);
  }
  const std::size_t pixels = skin_pixels(truth.mask);
  if (pixels > 0) bound.rms = std::sqrt(squares / static_cast<double>(pixels));
  return bound;
}

// All of them, each assembled once; the headline first.
struct ProfileTruths {
  std::vector<ViewedTruth> all;

  const ViewedTruth& headline() const { return all.front(); }
  const ViewedTruth& of(const OwnTarget& target) const {
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const ViewedTruth& t) { return t.planned.target == target; });
    assert(found != all.end());
    return *found;
  }
};

// The truth of the profile that a profile approximates.
struct ViewedModel {
  const ProfileModel& model;
  const ProfileTruth& truth;
  Image mask;  // the pixels that are measured against it, and against the headline
};

// The truth as a person sees it.
struct SeenTruth {
  Image picture;  // of the display, linear
  FlipReference flip;
};

// What every method is compared with under one profile.
struct Comparison {
  const Profile& profile;
  const ProfileTruths& truths;
  const FlipReference& flip;
  const HdrFlipReference& flip_hdr;
  const ViewedModel* model;  // null where the profile approximates nothing
  const SeenTruth* seen;     // null without [composite]
};

// What of the albedo comes after the scattering, a^exponent, behind every pixel; empty without one.
Image albedo_of_view(const PreparedScene& scene, const FrameImages& images, double exponent) {
  if (scene.albedo.empty() || exponent == 0.0) return {};
  Image albedo(images.mask.width(), images.mask.height(), 3);
  for (int y = 0; y < albedo.height(); ++y) {
    for (int x = 0; x < albedo.width(); ++x) {
      const PixelSurface& at = images.surface_at(x, y);
      if (at.triangle < 0) continue;
      const ShadingTriangle& triangle = scene.shading.triangles[static_cast<std::size_t>(at.triangle)];
      Vec2d uv = Vec2d::Zero();
      for (std::size_t c = 0; c < 3; ++c)
        uv += at.barycentric[static_cast<Eigen::Index>(c)] * triangle.uvs[c];
      albedo.set_rgb(x, y, power(scene.albedo.rgb(uv), exponent));
    }
  }
  return albedo;
}

class ViewRunner {
 public:
  ViewRunner(const Setup& setup, const ViewSpec& view)
      : setup_(setup),
        view_(view),
        name_(view.name),
        frame_(render_frame(setup.context, setup.surface, setup.scene.shading, camera_of(view))),
        images_(read_frame(setup.context, frame_)),
        median_depth_mm_(median_skin_depth_mm(images_)),
        planned_(planned_truths(setup.plan, setup.surface.has_uvs())),
        truth_(setup.scene, images_),
        contours_(
            find_contours({images_.mask, images_.position, images_.face_normal, frame_.camera.focal_px()})) {
    if (setup.spec.metrics.seam && setup.scene.mesh.has_uvs())
      uv_view_ = uv_view(setup.scene.mesh, setup.scene.shading, frame_.camera, images_);
    albedo_ = albedo_of_view(setup.scene, images_, 1.0 - setup.spec.scene.albedo_exponent_before());
  }

  // Computes what of this view is not finished yet.
  void run() {
    if (truth_.points().size() == 0)
      throw_input_error({setup_.spec.file.string()}, "view '{}' sees no skin", name_);
    const bool view_kept = is_kept({Piece::Kind::view, name_});
    const bool all_kept = std::all_of(setup_.plan.profiles.begin(), setup_.plan.profiles.end(),
                                      [&](const Profile& profile) { return is_kept(profile); });
    if (view_kept && all_kept) return;
    prepare_pictures(!view_kept);
    if (all_kept) return;
    compute_truths();
    if (setup_.spec.metrics.leak) measure_leaks();
    Progress progress(fmt::format("view {}: methods", name_),
                      setup_.plan.profiles.size() * setup_.plan.methods.size());
    for (const Profile& profile : setup_.plan.profiles) {
      if (is_kept(profile)) {
        progress.advance(setup_.plan.methods.size());
      } else {
        measure_profile(profile, progress);
      }
    }
  }

 private:
  bool is_kept(const Piece& piece) const { return setup_.pieces.has(piece); }

  // All pieces of this profile in this view.
  bool is_kept(const Profile& profile) const {
    const Plan& plan = setup_.plan;
    return is_kept(truth_piece(profile)) &&
           std::all_of(plan.methods.begin(), plan.methods.end(),
                       [&](const PlannedMethod& m) { return is_kept(run_piece(profile, m.label)); }) &&
           std::all_of(plan.ladders.begin(), plan.ladders.end(),
                       [&](const LadderSpec& l) { return is_kept(ladder_piece(profile, l)); });
  }

  Piece truth_piece(const Profile& profile) const { return {Piece::Kind::truth, name_, profile.name}; }
  Piece run_piece(const Profile& profile, const std::string& label) const {
    return {Piece::Kind::run, name_, profile.name, label};
  }
  Piece ladder_piece(const Profile& profile, const LadderSpec& ladder) const {
    return {Piece::Kind::ladder, name_, profile.name, ladder.name};
  }

  // What is reflected is needed for the composite, and for the buffers that the view's piece names.
  void prepare_pictures(bool keep) {
    const CompositeSpec* composite = setup_.spec.composite ? &*setup_.spec.composite : nullptr;
    const CompositeSpec* specular = composite != nullptr && composite->specular ? composite : nullptr;
    std::optional<ReflectionPictures> reflected;
    if (specular != nullptr || (setup_.buffers && keep)) {
      reflected = reflection_pictures(setup_.scene, *setup_.scene.reflection, images_, frame_.view, specular);
    }
    if (composite != nullptr) {
      composite_.emplace(*composite, setup_.scene.largest_irradiance, *setup_.compositor, frame_, images_,
                         reflected ? &*reflected : nullptr, albedo_);
    }
    if (keep) keep_view(reflected ? &*reflected : nullptr);
  }

  // `reflected` is there where buffers are wanted.
  void keep_view(const ReflectionPictures* reflected) {
    json view = {{"name", name_},
                 {"width_px", frame_.camera.width_px},
                 {"height_px", frame_.camera.height_px},
                 {"skin_pixels", truth_.points().size()},
                 {"median_skin_depth_mm", median_depth_mm_},
                 {"mm_per_px", mm_per_px()},
                 {"camera", camera_json(view_)},
                 {"color_bar", color_bar_json(frame_.camera)},
                 {"memory_estimate_bytes", memory_estimate()},
                 {"files", {{"irradiance", "maps/" + name_ + ".irradiance.png"}}}};
    if (!setup_.inputs.empty()) {
      write_frame(setup_.inputs, name_, frame_.camera, images_, setup_.origin);
      view["files"]["inputs"] = "inputs/" + name_ + ".exr";
      view["files"]["camera"] = "inputs/" + name_ + ".json";
    }
    if (setup_.buffers) {
      view["files"]["buffers"] = write_view_buffers(
          setup_.passes, name_,
          {*setup_.scene.reflection, *reflected, images_, composite_ ? &*composite_ : nullptr},
          setup_.exposure(), setup_.origin);
    }
    const Piece piece{Piece::Kind::view, name_};
    write_view_maps(setup_.pieces.picture(piece), {images_.irradiance, images_.mask, albedo_}, setup_.origin);
    setup_.pieces.keep(
        piece,
        {{"view", view}, {"scene", scene_json(setup_.spec, setup_.scene)}, {"exposure", setup_.exposure()}});
  }

  std::uint64_t memory_estimate() const {
    return estimate_memory(setup_.spec, setup_.plan, view_, size_of(setup_.scene), job_count()).bytes();
  }

  double mm_per_px() const { return median_depth_mm_ / frame_.camera.focal_px(); }

  // What a truth is known to, in units of irradiance.
  double known_light() const { return setup_.spec.truth.tolerance * setup_.scene.largest_irradiance; }

  void compute_truths() {
    std::vector<ViewTruth::Request> requests;
    for (const PlannedTruth& truth : planned_) {
      if (missing(truth).empty() && !truth.target.transmittance)
        requests.push_back({truth.profile, truth.target});
    }
    for (const auto& [name, model] : setup_.plan.models) requests.push_back(request_of(model));
    const bool visible_only = std::any_of(requests.begin(), requests.end(),
                                          [](const auto& request) { return request.target.visible_only; });
    const VisibleSurface visible =
        visible_only ? visible_surface(setup_.scene, frame_.camera) : VisibleSurface{};
    truth_.compute(
        requests, setup_.spec.truth,
        [&](LayerKind kind, const ViewPoints& points) {
          return setup_.truths.source(kind, points, &visible);
        },
        setup_.truths.geodesic());
    for (const auto& [name, model] : setup_.plan.models) {
      // Who keeps the truth's piece says how it was checked.
      const bool checked = is_kept({Piece::Kind::truth, name_, name});
      profile_truths_.emplace(name,
                              profile_truth(model, truth_, checked ? nullptr : &setup_.truths.surface()));
    }
  }

  // Why there is no such truth; empty: there is.
  std::string missing(const PlannedTruth& truth) const {
    return truth.not_computed.empty() ? setup_.truths.obstacle(truth.target) : truth.not_computed;
  }

  void measure_profile(const Profile& profile, Progress& progress) {
    const ProfileTruths truths = assemble(profile);
    const TruthImage& headline = truths.headline().image;
    const FlipReference flip(exposed(headline.rgb, setup_.exposure()));
    const HdrFlipReference flip_hdr(headline.rgb, truths.headline().mask, known_light());
    const std::optional<ViewedModel> model = view_model(profile, truths.headline());
    const ViewedModel* of = model ? &*model : nullptr;
    const std::optional<SeenTruth> seen = see(headline.rgb);
    if (!is_kept(truth_piece(profile))) keep_truths(profile, truths, of, seen ? &*seen : nullptr);
    for (const PlannedMethod& m : setup_.plan.methods) {
      if (!is_kept(run_piece(profile, m.label)))
        keep_run(m, {profile, truths, flip, flip_hdr, of, seen ? &*seen : nullptr});
      progress.advance();
    }
    for (const LadderSpec& ladder : setup_.plan.ladders) {
      if (!is_kept(ladder_piece(profile, ladder))) keep_ladder(ladder, profile, truths);
    }
  }

  std::optional<SeenTruth> see(const Image& truth) const {
    if (!composite_) return std::nullopt;
    Image picture = composite_->picture(truth);
    FlipReference flip(picture, setup_.spec.composite->pixels_per_degree);
    return SeenTruth{std::move(picture), std::move(flip)};
  }

  ProfileTruths assemble(const Profile& profile) {
    ProfileTruths truths;
    for (const PlannedTruth& planned : planned_) {
      if (planned.profile != &profile) continue;
      ViewedTruth truth{planned, missing(planned), {}, {}};
      if (truth.missing.empty()) {
        truth.image = planned.target.transmittance
                          ? light_paths(profile, planned.target.r_max_mm).truth(planned.target)
                          : truth_.image({&profile, planned.target});
        if (planned.target.transmittance && !truth.image.certificate.passed()) {
          truth.missing = fmt::format(
              "its quadrature changes by {:.3g} of the largest irradiance as its parts are halved, and "
              "{:.3g} is allowed",
              truth.image.certificate.max_error, truth.image.certificate.tolerance);
        }
        // What the headline counts apart is not measured at all. A raw truth divides by no mass.
        truth.mask = truths.all.empty() ? images_.mask : truths.headline().mask;
        if (planned.target.normalised)
          truth.mask = measured_mask(std::move(truth.mask), truth.image.smallest_mass);
      }
      truths.all.push_back(std::move(truth));
    }
    return truths;
  }

  // Made when they are first asked for; the last one is kept.
  const LightPathSample& light_paths(const Profile& profile, std::optional<double> r_max_mm = {}) {
    const double parted_mm = r_max_mm.value_or(profile.r_max_mm);
    if (!light_paths_ || light_paths_of_ != std::pair(&profile, parted_mm)) {
      const auto points = static_cast<std::size_t>(setup_.spec.truth.transmittance_points());
      light_paths_.emplace(LightPathInputs{setup_.scene, setup_.truths, truth_, profile, parted_mm, points,
                                           setup_.spec.truth.seed});
      light_paths_of_ = {&profile, parted_mm};
    }
    return *light_paths_;
  }

  json light_paths_json(const Profile& profile) {
    const std::string obstacle = setup_.truths.obstacle(OwnTarget{.geodesic = true});
    return obstacle.empty() ? light_paths(profile).parts(name_, setup_.spec.truth.tolerance)
                            : json{{"view", name_},
                                   {"profile", profile.name},
                                   {"r_max_mm", profile.r_max_mm},
                                   {"not_computed", obstacle}};
  }

  // At how many pixels a truth is known.
  std::size_t points_of(const OwnTarget& target) const {
    const auto sampled = static_cast<std::size_t>(setup_.spec.truth.transmittance_points());
    const std::size_t all = truth_.points().size();
    return target.transmittance ? std::min(sampled, all) : all;
  }

  void keep_truths(const Profile& profile, const ProfileTruths& truths, const ViewedModel* model,
                   const SeenTruth* seen) {
    json kept = {{"truths", truths_json(profile, truths, seen)},
                 {"fit_errors", json::array()},
                 {"light_paths", json::array()}};
    if (setup_.spec.truth.light_paths > 0) kept["light_paths"].push_back(light_paths_json(profile));
    if (model != nullptr) add_model(profile, truths.headline(), *model, kept);
    setup_.pieces.keep(truth_piece(profile), kept);
  }

  // The truths of a profile's Gaussians, the headline's pictures written.
  json truths_json(const Profile& profile, const ProfileTruths& truths, const SeenTruth* seen) {
    const std::string stem = truth_piece(profile).stem();
    json all = json::array();
    for (const ViewedTruth& viewed : truths.all) {
      if (!viewed.missing.empty()) continue;
      json truth = truth_json(name_, viewed.planned, viewed.image, truth_.audited());
      truth["points"] = points_of(viewed.planned.target);
      if (viewed.planned.target.transmittance)
        truth["certificate"]["classes"] = {{"random", truth["certificate"]["audited"]}};
      if (viewed.planned.target.visible_only) {
        const VisibilityBound bound = visibility_bound(viewed);
        truth["visibility_bound"] = {{"rms", bound.rms}, {"max", bound.max}};
      }
      truth["low_mass_pixels"] = points_of(viewed.planned.target) - skin_pixels(viewed.mask);
      if (viewed.planned.is_headline()) {
        truth["files"] = {{"picture", "maps/" + stem + ".png"}, {"exr", "maps/" + stem + ".exr"}};
        if (seen != nullptr) truth["files"]["composite"] = "maps/" + composite_file(stem);
      }
      all.push_back(truth);
    }
    const TruthImage& headline = truths.headline().image;
    write_truth_maps(setup_.pieces.maps() / (stem + ".exr"),
                     {headline.rgb,
                      headline.smallest_mass,
                      images_.irradiance,
                      images_.mask,
                      {},
                      seen != nullptr ? seen->picture : Image()},
                     setup_.origin);
    return all;
  }

  std::optional<ViewedModel> view_model(const Profile& profile, const ViewedTruth& headline) const {
    const ProfileModel* model = setup_.plan.model_of(profile);
    if (model == nullptr) return std::nullopt;
    const ProfileTruth& truth = profile_truths_.at(profile.name);
    return ViewedModel{*model, truth, measured_mask(headline.mask, truth.normalised.smallest_mass)};
  }

  // The two truths of the profile itself, and the error of its Gaussians: the headline against it.
  void add_model(const Profile& profile, const ViewedTruth& headline, const ViewedModel& viewed, json& kept) {
    const std::string stem = profile_truth_stem(truth_piece(profile));
    const TruthImage& itself = viewed.truth.normalised;
    for (const bool normalised : {true, false}) {
      json truth = model_truth_json(name_, profile, viewed.model, normalised, viewed.truth, truth_.audited());
      truth["points"] = truth_.points().size();
      truth["low_mass_pixels"] =
          normalised ? skin_pixels(images_.mask) - skin_pixels(viewed.mask) : std::size_t{0};
      if (normalised)
        truth["files"] = {{"picture", "maps/" + stem + ".png"}, {"exr", "maps/" + stem + ".exr"}};
      kept["truths"].push_back(truth);
    }
    json fit = {{"view", name_},
                {"profile", profile.name},
                {"fit", truth_id(name_, profile, OwnTarget{})},
                {"truth", model_truth_id(name_, profile, true)},
                {"compared", "fit - profile, each normalised to send back its own albedo of even light"},
                {"metrics", error_stats_json(headline.image.rgb, itself.rgb, viewed.mask)},
                {"files", {{"signed", "maps/" + stem + ".signed.png"}}}};
    put_distinguishable(fit, itself.certificate.uncertainty() + headline.image.certificate.uncertainty());
    kept["fit_errors"].push_back(fit);
    write_truth_maps(setup_.pieces.maps() / (stem + ".exr"),
                     {itself.rgb,
                      itself.smallest_mass,
                      images_.irradiance,
                      images_.mask,
                      signed_error(headline.image.rgb, itself.rgb, images_.mask),
                      {}},
                     setup_.origin);
  }

  void keep_run(const PlannedMethod& planned, const Comparison& against) {
    const Piece piece = run_piece(against.profile, planned.label);
    json run = {{"scene", setup_.spec.scene.mesh},
                {"view", name_},
                {"method", planned.method->name},
                {"label", planned.label},
                {"title", planned.method->title},
                {"source", planned.method->source},
                {"profile", against.profile.name},
                {"settings", settings_json(planned.settings)},
                {"truth", truth_id(name_, against.profile, OwnTarget{})}};
    const std::string skipped = why_skipped(planned, against.profile);
    if (skipped.empty()) {
      measure_method(planned, against, piece, run);
    } else {
      run["skipped"] = skipped;
    }
    setup_.pieces.keep(piece, run);
  }

  // Empty: it is not.
  std::string why_skipped(const PlannedMethod& planned, const Profile& profile) const {
    if (is_skipped(planned, setup_.surface.has_uvs())) return "this method needs UVs, and the mesh has none";
    return missing_picture(setup_.spec, planned, name_, profile.name);
  }

  void measure_method(const PlannedMethod& planned, const Comparison& against, const Piece& piece,
                      json& run) {
    const Measured measured = measure(planned, against.profile);
    run["cost"] = measured.cost;
    if (measured.cost.is_null()) run["cost_reason"] = "a picture made elsewhere: nothing of it ran here";
    add_metrics(run, measured.exitance, against);
    if (setup_.spec.metrics.leak) add_leak(run, planned, against.truths.headline());
    const OwnTarget own = planned.method->own_target(against.profile, planned.settings);
    run["own_target"] = error_against(against.truths.of(own), measured.exitance);
    if (own.transmittance)
      add_headline_there(run["own_target"], against.truths.of(own), measured.exitance, against);
    for (const ViewedTruth& truth : against.truths.all) {
      if (truth.planned.extra) run["extra_targets"].push_back(error_against(truth, measured.exitance));
    }
    if (against.model != nullptr) run["profile_error"] = profile_error(measured.exitance, against);
    add_maps(run, piece.stem(), measured.exitance, against);
    if (!measured.passes.is_null()) run["files"]["passes"] = measured.passes;
  }

  // A ladder's rungs, or why one of them is missing.
  struct Rungs {
    std::vector<LadderRung> all;
    Image mask;  // what every truth among them measures
    std::string missing;
  };

  // `drawn` receives the runs' pictures, which the rungs refer to.
  Rungs rungs_of(const LadderSpec& ladder, const Profile& profile, const ProfileTruths& truths,
                 std::list<Image>& drawn) const {
    Rungs rungs{{}, truths.headline().mask, ""};
    for (const LadderSpec::Rung& rung : ladder.rungs) {
      if (rung.truth.empty()) {
        const Piece piece = run_piece(profile, rung.method);
        if (setup_.pieces.read(piece).contains("skipped"))
          return {{}, {}, fmt::format("'{}' was not run", rung.method)};
        drawn.push_back(read_exr_layer(setup_.pieces.maps() / (piece.stem() + ".exr"), ""));
        rungs.all.push_back({rung.name(), rung.assumption, &drawn.back()});
        continue;
      }
      const ViewedTruth& truth = truths.of(rung_target(rung, profile));
      if (!truth.missing.empty()) return {{}, {}, truth.missing};
      rungs.all.push_back({rung.name(), rung.assumption, &truth.image.rgb});
      rungs.mask = measured_mask(std::move(rungs.mask), truth.image.smallest_mass);
    }
    return rungs;
  }

  // Every run of this profile is kept.
  void keep_ladder(const LadderSpec& ladder, const Profile& profile, const ProfileTruths& truths) {
    const Piece piece = ladder_piece(profile, ladder);
    json result = {{"view", name_}, {"profile", profile.name}, {"name", ladder.name}};
    std::list<Image> drawn;
    const Rungs rungs = rungs_of(ladder, profile, truths, drawn);
    if (!rungs.missing.empty()) {
      result["skipped"] = rungs.missing;
      setup_.pieces.keep(piece, result);
      return;
    }
    const Image& first = *rungs.all.front().exitance;
    const FlipReference flip(exposed(first, setup_.exposure()));
    const HdrFlipReference flip_hdr(first, rungs.mask, known_light());
    const std::list<LadderStep> steps = ladder_steps(rungs.all, rungs.mask);
    result.update(ladder_json(rungs.all, steps,
                              {first, rungs.mask, contours_, profile.widest_std_dev_mm(), mm_per_px(), flip,
                               setup_.exposure(), flip_hdr}));
    for (std::size_t r = 1; r < rungs.all.size(); ++r)
      result["rungs"][r]["files"] = {{"signed", "maps/" + step_file(piece.stem(), rungs.all[r].name)}};
    const std::string file = piece.stem() + ".exr";
    write_ladder_maps(setup_.pieces.maps() / file, images_.mask, steps, setup_.origin);
    result["files"] = {{"exr", "maps/" + file}};
    setup_.pieces.keep(piece, result);
  }

  Measured measure(const PlannedMethod& planned, const Profile& profile) const {
    if (planned.pictures != nullptr)
      return {read_picture(picture_path(setup_.spec, *planned.pictures, name_, profile.name),
                           *planned.pictures, view_),
              nullptr,
              {}};
    const MethodInputs inputs{setup_.context,   frame_,  setup_.surface,
                              median_depth_mm_, profile, planned.settings};
    Measured measured = draw_and_time(setup_, inputs, *planned.method,
                                      {truth_.points().size(), run_piece(profile, planned.label).stem()});
    if (planned.method->check) check_finite(planned.method->name, measured.exitance, images_.mask);
    return measured;
  }

  void add_metrics(json& run, const Image& exitance, const Comparison& against) const {
    const ViewedTruth& truth = against.truths.headline();
    run["metrics"] = metrics_json(
        exitance, {truth.image.rgb, truth.mask, contours_, against.profile.widest_std_dev_mm(), mm_per_px(),
                   against.flip, setup_.exposure(), against.flip_hdr, uv_view_ ? &*uv_view_ : nullptr});
    if (setup_.spec.metrics.seam && !uv_view_) {
      run["metrics"]["seam"] = nullptr;
      run["metrics"]["seam_reason"] = "the mesh has no UVs";
    }
    put_distinguishable(run, truth);
    if (setup_.spec.scene.albedo.empty()) return;
    // What leaves the surface with all of its albedo: in this, texturing before and after can be compared.
    run["textured"] = {{"metrics", error_stats_json(textured(exitance, albedo_),
                                                    textured(truth.image.rgb, albedo_), truth.mask)}};
  }

  // The connected pieces of skin that are seen.
  std::set<int> seen_surfaces() const {
    std::set<int> surfaces;
    for (std::size_t i = 0; i < images_.surface.size(); ++i) {
      if (images_.mask.data()[i] != 0.0F) surfaces.insert(component_at(i));
    }
    return surfaces;
  }

  int component_at(std::size_t pixel) const {
    return setup_.scene.shading.triangles[static_cast<std::size_t>(images_.surface[pixel].triangle)]
        .component;
  }

  // Every method under every profile once for each surface in view, with the others dark.
  void measure_leaks() {
    const std::set<int> surfaces = seen_surfaces();
    if (surfaces.size() < 2) return;
    Progress progress(fmt::format("view {}: leaks", name_), surfaces.size());
    for (const int component : surfaces) {
      const ShadingMesh lit = lit_alone(setup_.scene.shading, component);
      const SurfaceBuffers surface(setup_.context, lit, lit_alone(setup_.scene.lights, lit, component));
      const Frame frame = render_frame(setup_.context, surface, lit, frame_.camera);
      Image dark = images_.mask;
      for (std::size_t i = 0; i < images_.surface.size(); ++i) {
        if (dark.data()[i] != 0.0F && component_at(i) == component) dark.data()[i] = 0.0F;
      }
      for (const Profile& profile : setup_.plan.profiles) {
        for (const PlannedMethod& planned : setup_.plan.methods) {
          if (planned.pictures != nullptr || is_skipped(planned, surface.has_uvs())) continue;
          if (is_kept(run_piece(profile, planned.label))) continue;
          const Image exitance = draw_method(
              *planned.method, {setup_.context, frame, surface, median_depth_mm_, profile, planned.settings});
          leaks_[{profile.name, planned.label}].push_back(measure_dark(component, exitance, dark));
        }
      }
      progress.advance();
    }
  }

  void add_leak(json& run, const PlannedMethod& planned, const ViewedTruth& truth) {
    const auto found = leaks_.find({truth.planned.profile->name, planned.label});
    if (found == leaks_.end()) {
      run["metrics"]["leak"] = nullptr;
      run["metrics"]["leak_reason"] = planned.pictures != nullptr
                                          ? "a picture made elsewhere cannot be drawn again with other light"
                                          : "the view shows one surface alone";
      return;
    }
    for (LitAlone& surface : found->second) {
      for (std::size_t i = 0; i < images_.surface.size(); ++i) {
        if (truth.mask.data()[i] == 0.0F || component_at(i) != surface.component) continue;
        const std::span<const float> rgb = truth.image.rgb.data().subspan(3 * i, 3);
        surface.lit_light += luminance(Vec3d(rgb[0], rgb[1], rgb[2]));
      }
    }
    run["metrics"]["leak"] = leak_json(found->second, setup_.scene.largest_irradiance);
  }

  // Below the truth's uncertainty nothing can be told from the truth; nor below the doubt about what is
  // visible, taken as the RMSE is, over the same pixels.
  void put_distinguishable(json& measured, const ViewedTruth& truth) const {
    put_distinguishable(measured, truth.image.certificate.uncertainty() + visibility_bound(truth).rms);
  }
  // `uncertainty` in units of the largest irradiance.
  void put_distinguishable(json& measured, double uncertainty) const {
    const json rmse = measured["metrics"]["rmse"];
    measured["distinguishable"] =
        rmse.is_number() ? json(rmse.get<double>() > uncertainty * setup_.scene.largest_irradiance) : json();
    if (!rmse.is_number()) measured["distinguishable_reason"] = "no pixel to measure";
  }

  // The error against the profile itself, and apart from it the method's against its Gaussians, over the
  // same pixels: with the fit error, the first is the sum of the other two at every one.
  json profile_error(const Image& exitance, const Comparison& against) const {
    const TruthImage& itself = against.model->truth.normalised;
    const Image& mask = against.model->mask;
    json error = target_json(OwnTarget{});
    error["truth"] = model_truth_id(name_, against.profile, true);
    error["metrics"] = error_stats_json(exitance, itself.rgb, mask);
    put_distinguishable(error, itself.certificate.uncertainty());
    json convolution = {{"truth", truth_id(name_, against.profile, OwnTarget{})},
                        {"metrics", error_stats_json(exitance, against.truths.headline().image.rgb, mask)}};
    put_distinguishable(convolution, against.truths.headline());
    error["convolution"] = convolution;
    return error;
  }

  // The error against a truth that is not the headline.
  json error_against(const ViewedTruth& truth, const Image& exitance) const {
    json error = target_json(truth.planned.target);
    if (!truth.missing.empty()) {
      error["truth"] = nullptr;
      error["metrics"] = nullptr;
      error["metrics_reason"] = truth.missing;
      return error;
    }
    error["truth"] = truth_id(name_, *truth.planned.profile, truth.planned.target);
    error["metrics"] = error_stats_json(exitance, truth.image.rgb, truth.mask);
    put_distinguishable(error, truth);
    return error;
  }

  // The headline's error over the pixels of a sample, so that the two can be compared.
  static void add_headline_there(json& own, const ViewedTruth& truth, const Image& exitance,
                                 const Comparison& against) {
    if (!truth.missing.empty()) return;
    own["sampled"] = {
        {"points", skin_pixels(truth.mask)},
        {"headline_metrics", error_stats_json(exitance, against.truths.headline().image.rgb, truth.mask)}};
  }

  // Its files, and what of its error is visible.
  void add_maps(json& run, const std::string& stem, const Image& exitance, const Comparison& against) const {
    run["files"] = {{"picture", "maps/" + stem + ".png"},
                    {"magnitude", "maps/" + stem + ".abs.png"},
                    {"signed", "maps/" + stem + ".signed.png"},
                    {"exr", "maps/" + stem + ".exr"}};
    const auto error_from = [&](const Image& truth) { return signed_error(exitance, truth, images_.mask); };
    Image composite;
    Image visible;
    if (against.seen != nullptr) {
      composite = composite_->picture(exitance);
      visible = against.seen->flip.map(composite);
      run["metrics"]["visible"] = visible_json(visible, against.truths.headline().mask);
      run["files"]["composite"] = "maps/" + composite_file(stem);
      run["files"]["visible"] = "maps/" + visible_file(stem);
    }
    write_run_maps(setup_.pieces.maps() / (stem + ".exr"),
                   {exitance, error_from(against.truths.headline().image.rgb), images_.mask,
                    against.model == nullptr ? Image() : error_from(against.model->truth.normalised.rgb),
                    composite, visible},
                   setup_.origin);
  }

  const Setup& setup_;
  const ViewSpec& view_;
  std::string name_;
  Frame frame_;
  FrameImages images_;
  double median_depth_mm_;
  std::vector<PlannedTruth> planned_;
  ViewTruth truth_;
  std::map<std::string, ProfileTruth> profile_truths_;  // by the names of the profiles that approximate them
  // By profile's name and method's label: what the method carries from each surface in view to the others.
  std::map<std::array<std::string, 2>, std::vector<LitAlone>> leaks_;
  ContourMap contours_;
  std::optional<LightPathSample> light_paths_;
  std::pair<const Profile*, double> light_paths_of_;
  std::optional<UvView> uv_view_;           // where the seam's metrics were asked for and the mesh has UVs
  Image albedo_;                            // what of it comes after the scattering; empty where nothing does
  std::optional<ViewComposite> composite_;  // with [composite]
};

// Whether all that ViewRunner would do is done.
bool is_finished(const Setup& setup, const ViewSpec& view) {
  const std::vector<Piece> all = pieces_of(setup.spec, setup.plan);
  return std::all_of(all.begin(), all.end(), [&](const Piece& piece) {
    const bool other =
        piece.view != view.name || piece.kind == Piece::Kind::stability || piece.kind == Piece::Kind::widths;
    return other || setup.pieces.has(piece);
  });
}

}  // namespace

void run_view(const Setup& setup, const ViewSpec& view) {
  if (!is_finished(setup, view)) ViewRunner(setup, view).run();
  const Piece stability{Piece::Kind::stability, view.name};
  if (setup.spec.stability && setup.spec.stability->of(view) && !setup.pieces.has(stability))
    setup.pieces.keep(stability, measure_stability(setup, view));
}

}  // namespace truescatter
