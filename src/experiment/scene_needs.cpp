#include "experiment/scene_needs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/draw_method.h"
#include "experiment/light_path_sample.h"
#include "experiment/metrics_json.h"
#include "experiment/plan.h"
#include "experiment/scene_setup.h"
#include "experiment/scene_truths.h"
#include "experiment/view_truth.h"
#include "methods/frame.h"
#include "metrics/error_stats.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr double kSmallestSeenPx = 0.5;

ViewSpec small_view(ViewSpec view, int frame_px) {
  const double factor = static_cast<double>(frame_px) / std::max(view.width_px, view.height_px);
  if (factor >= 1.0) return view;
  view.width_px = std::max(1, static_cast<int>(std::lround(factor * view.width_px)));
  view.height_px = std::max(1, static_cast<int>(std::lround(factor * view.height_px)));
  return view;
}

ExperimentSpec without_shadows(ExperimentSpec spec) {
  for (LightSpec& light : spec.lights) light.shadows = light.occlusion = false;
  return spec;
}

bool has_shadows(const ExperimentSpec& spec) {
  return std::any_of(spec.lights.begin(), spec.lights.end(), [](const LightSpec& light) {
    return light.type == "environment" ? light.occlusion : light.shadows;
  });
}

// Of `test` from `truth`, relative to the latter.
json difference(const Image& test, const Image& truth, const Image& mask) {
  json entry = json::object();
  put_number(entry, "difference", error_stats(test, truth, mask, Quantity::luminance).rel_rmse,
             "no pixel to measure, or no light");
  return entry;
}

json none(const std::string& reason) { return {{"difference", nullptr}, {"reason", reason}}; }

// A profile's narrowest Gaussians, up to and with this one, left where they fall.
Profile unblurred(const Profile& profile, const std::vector<GaussianLevel>& levels, std::size_t last) {
  Profile reduced = profile;
  reduced.terms.clear();
  for (std::size_t l = 0; l < levels.size(); ++l) {
    if (l <= last) {
      reduced.delta_weight += levels[l].weight;
    } else {
      reduced.terms.push_back({Vec3d::Constant(levels[l].variance_mm2), levels[l].weight});
    }
  }
  return reduced;
}

// A scene lit, on the GPU, with its truths.
struct LitScene {
  LitScene(const ExperimentSpec& spec, const gpu::Context& context,
           const std::function<void(const Mesh&)>& admit)
      : scene(prepare_scene(spec, admit)), buffers(context, scene.shading, scene.lights) {}

  PreparedScene scene;
  SurfaceBuffers buffers;
};

class ViewNeeds {
 public:
  ViewNeeds(const ExperimentSpec& spec, const gpu::Context& context, const LitScene& lit,
            const SceneTruths& truths, const ViewSpec& view, const NeedOptions& options)
      : spec_(spec),
        context_(context),
        lit_(lit),
        truths_(truths),
        view_(view),
        options_(options),
        small_(small_view(view, options.frame_px)),
        frame_(render_frame(context, lit.buffers, lit.scene.shading, camera_of(small_))),
        images_(read_frame(context, frame_)),
        depth_mm_(median_skin_depth_mm(images_)),
        truth_(lit.scene, images_) {}

  // `dark`: the same scene without shadows; null where there are none to leave out.
  json measure(const std::vector<Profile>& profiles, const LitScene* dark) {
    if (truth_.points().size() == 0)
      throw_input_error({spec_.file.string()}, "view '{}' sees no skin", view_.name);
    compute(profiles);
    const json shadows = dark != nullptr ? shadows_of(*dark) : none("no light of the experiment casts any");
    json all = json::array();
    for (const Profile& profile : profiles) {
      all.push_back({{"view", view_.name},
                     {"profile", profile.name},
                     {"width_px", small_.width_px},
                     {"height_px", small_.height_px},
                     {"gaussians", gaussians(profile)},
                     {"layers", layers(profile)},
                     {"shadows", shadows},
                     {"geodesics", geodesics(profile)},
                     {"transmittance", transmittance(profile)}});
    }
    return all;
  }

 private:
  static constexpr OwnTarget kGeodesic = {.geodesic = true};

  void compute(const std::vector<Profile>& profiles) {
    std::vector<ViewTruth::Request> requests;
    for (const Profile& profile : profiles) {
      requests.push_back({&profile, OwnTarget{}});
      if (truths_.obstacle(kGeodesic).empty()) requests.push_back({&profile, kGeodesic});
    }
    truth_.compute(
        requests, spec_.truth,
        [&](LayerKind kind, const ViewPoints& points) { return truths_.source(kind, points); },
        truths_.geodesic());
  }

  Image headline(const Profile& profile) const { return truth_.image({&profile, OwnTarget{}}).rgb; }

  // What a run measures: pixels where no Gaussian loses half of its mass.
  Image measured(const Profile& profile) const {
    return measured_mask(images_.mask, truth_.image({&profile, OwnTarget{}}).smallest_mass);
  }

  json gaussians(const Profile& profile) const {
    const std::vector<GaussianLevel> levels = gaussian_levels(profile);
    const double px_per_mm = camera_of(view_).focal_px() / depth_mm_;
    const Image whole = headline(profile);
    const Image mask = measured(profile);
    json all = json::array();
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const double width_px = levels[l].std_dev_mm() * px_per_mm;
      json entry = difference(headline(unblurred(profile, levels, l)), whole, mask);
      entry["std_dev_mm"] = levels[l].std_dev_mm();
      entry["std_dev_px"] = width_px;
      entry["below_pixel"] = width_px < kSmallestSeenPx;
      all.push_back(entry);
    }
    return all;
  }

  Image draw(const Profile& profile, double layer_count) const {
    const Method& method = find_method("cbf-unnormalised");
    const Settings settings(method.name, method.settings, {{"layers", layer_count}});
    return draw_method(method, {context_, frame_, lit_.buffers, depth_mm_, profile, settings});
  }

  json layers(const Profile& profile) const {
    return difference(draw(profile, 1.0), draw(profile, 2.0), measured(profile));
  }

  json shadows_of(const LitScene& dark) const {
    const Frame frame = render_frame(context_, dark.buffers, dark.scene.shading, frame_.camera);
    return difference(read_frame(context_, frame).irradiance, images_.irradiance, images_.mask);
  }

  json geodesics(const Profile& profile) const {
    const std::string obstacle = truths_.obstacle(kGeodesic);
    if (!obstacle.empty()) return none(obstacle);
    return difference(truth_.image({&profile, kGeodesic}).rgb, headline(profile), measured(profile));
  }

  json transmittance(const Profile& profile) const {
    const std::string obstacle = truths_.obstacle(kGeodesic);
    if (!obstacle.empty()) return none(obstacle);
    const LightPathSample sample(
        {lit_.scene, truths_, truth_, profile, profile.r_max_mm, options_.light_paths, spec_.truth.seed});
    const json parts = sample.parts(view_.name, spec_.truth.tolerance);
    return {{"difference", parts.at("transmittance").at("rms")},
            {"quadrature_error", parts.at("transmittance").at("quadrature_error")},
            {"points", parts.at("points")}};
  }

  const ExperimentSpec& spec_;
  const gpu::Context& context_;
  const LitScene& lit_;
  const SceneTruths& truths_;
  const ViewSpec& view_;
  const NeedOptions& options_;
  ViewSpec small_;
  Frame frame_;
  FrameImages images_;
  double depth_mm_;
  ViewTruth truth_;
};

// Of several sums of Gaussians for one diffusion profile, that of the most.
std::vector<Profile> fullest_profiles(const Plan& plan) {
  const auto title = [&](const Profile& profile) {
    const auto of = plan.approximated.find(profile.name);
    return of != plan.approximated.end() ? of->second.title() : "";
  };
  std::vector<Profile> kept;
  for (const Profile& profile : plan.profiles) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const Profile& other) {
      return !title(profile).empty() && title(other) == title(profile);
    });
    if (same == kept.end()) {
      kept.push_back(profile);
    } else if (profile.terms.size() > same->terms.size()) {
      *same = profile;
    }
  }
  return kept;
}

// Of several sizes of one camera's frame, the largest.
std::vector<ViewSpec> largest_views(const std::vector<ViewSpec>& views) {
  std::vector<ViewSpec> kept;
  for (const ViewSpec& view : views) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const ViewSpec& other) {
      return other.eye_mm == view.eye_mm && other.target_mm == view.target_mm && other.up == view.up &&
             other.fov_deg == view.fov_deg;
    });
    if (same == kept.end()) {
      kept.push_back(view);
    } else if (view.width_px > same->width_px) {
      *same = view;
    }
  }
  return kept;
}

}  // namespace

json scene_needs(const ExperimentSpec& spec, const NeedOptions& options) {
  const Plan plan = make_plan(spec, true);
  const gpu::Context context(options.gl);
  ExperimentSpec drawn = spec;
  for (ViewSpec& view : drawn.views) view = small_view(view, options.frame_px);
  const auto admit = [&](const Mesh& mesh) {
    refuse_beyond_memory(drawn, plan, size_of(mesh), options.memory_limit_bytes);
  };
  const LitScene lit(spec, context, admit);
  std::optional<LitScene> dark;
  if (has_shadows(spec)) dark.emplace(without_shadows(spec), context, admit);
  const SceneTruths truths(lit.scene, spec.truth, true, options.cache);
  json all = json::array();
  const std::vector<Profile> profiles = fullest_profiles(plan);
  for (const ViewSpec& view : largest_views(spec.views)) {
    ViewNeeds needs(spec, context, lit, truths, view, options);
    for (json& entry : needs.measure(profiles, dark ? &*dark : nullptr)) all.push_back(std::move(entry));
  }
  return all;
}

}  // namespace truescatter
