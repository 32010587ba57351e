#include "experiment/stability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "core/progress.h"
#include "experiment/draw_method.h"
#include "experiment/metrics_json.h"
#include "experiment/view_truth.h"
#include "metrics/error_spread.h"
#include "metrics/error_stats.h"

namespace truescatter {
namespace {

using nlohmann::json;

// The i-th of Halton's numbers in (0, 1), from i = 1.
double halton(int index, int base) {
  double value = 0.0;
  double digit = 1.0;
  for (int rest = index; rest > 0; rest /= base) {
    digit /= base;
    value += digit * (rest % base);
  }
  return value;
}

Camera turned(Camera camera, double angle_deg) {
  const Eigen::AngleAxisd turn(angle_deg * kPi / 180.0, camera.up.normalized());
  camera.eye_mm = camera.target_mm + turn * (camera.eye_mm - camera.target_mm);
  return camera;
}

Vec3d face_normal(const ShadingMesh& shading, const ShadingTriangle& triangle) {
  const Vec3d a = shading.corner(triangle, 0);
  return (shading.corner(triangle, 1) - a).cross(shading.corner(triangle, 2) - a).normalized();
}

// The surface point behind a pixel.
FollowedPoint point_behind(const ShadingMesh& shading, const PixelSurface& seen) {
  const ShadingTriangle& triangle = shading.triangles[static_cast<std::size_t>(seen.triangle)];
  FollowedPoint point{Vec3d::Zero(), face_normal(shading, triangle), triangle.component};
  for (std::size_t c = 0; c < 3; ++c)
    point.position_mm += seen.barycentric[static_cast<Eigen::Index>(c)] * shading.corner(triangle, c);
  return point;
}

// Skin pixels of a view: all of them, or so many, drawn without repetition.
std::vector<FollowedPoint> followed_points(const PreparedScene& scene, const FrameImages& images,
                                           const StabilitySpec& spec) {
  std::vector<const PixelSurface*> skin;
  for (int y = 0; y < images.mask.height(); ++y) {
    for (int x = 0; x < images.mask.width(); ++x) {
      if (images.mask.at(x, y, 0) > 0.0F && images.surface_at(x, y).triangle >= 0)
        skin.push_back(&images.surface_at(x, y));
    }
  }
  if (spec.points > 0 && static_cast<std::size_t>(spec.points) < skin.size()) {
    std::mt19937_64 generator(spec.seed);
    std::shuffle(skin.begin(), skin.end(), generator);
    skin.resize(static_cast<std::size_t>(spec.points));
  }
  std::vector<FollowedPoint> points;
  for (const PixelSurface* pixel : skin) points.push_back(point_behind(scene.shading, *pixel));
  return points;
}

FrameImages only_at(FrameImages images, const std::vector<SeenPoint>& seen) {
  std::fill(images.mask.data().begin(), images.mask.data().end(), 0.0F);
  for (const SeenPoint& at : seen) images.mask.at(at.x, at.y, 0) = 1.0F;
  return images;
}

// The errors of one method under one profile, over the views of one kind.
struct Followed {
  std::array<ErrorSpread, kQuantities.size()> errors;
  std::array<double, kQuantities.size()> truth_squares = {};
  std::size_t samples = 0;

  explicit Followed(std::size_t points)
      : errors{ErrorSpread(points), ErrorSpread(points), ErrorSpread(points), ErrorSpread(points)} {}

  void add(const Image& exitance, const TruthImage& truth, const std::vector<SeenPoint>& seen) {
    for (const SeenPoint& at : seen) {
      if (truth.smallest_mass.at(at.x, at.y, 0) < static_cast<float>(kSmallMass)) continue;
      ++samples;
      for (std::size_t q = 0; q < kQuantities.size(); ++q) {
        const double value = value_of(truth.rgb, at.x, at.y, kQuantities[q]);
        errors[q].add(at.point, value_of(exitance, at.x, at.y, kQuantities[q]) - value);
        truth_squares[q] += value * value;
      }
    }
  }
};

json spread_json(const Followed& followed, std::size_t quantity, double largest_irradiance) {
  const std::string unseen = "no point is seen by two of the views";
  const SpreadStats stats = followed.errors[quantity].stats();
  const double truth_rms =
      std::sqrt(followed.truth_squares[quantity] / static_cast<double>(followed.samples));
  json object = {{"points", stats.points}};
  const auto put = [&](const std::string& name, double value) {
    put_number(object, name, value / largest_irradiance, unseen);
    put_number(object, "rel_" + name, value / truth_rms,
               stats.points == 0 ? unseen : "the truth is 0 at every pixel");
  };
  put("rms", stats.rms);
  put("p95", stats.p95);
  put("max", stats.max);
  return object;
}

class StabilityRunner {
 public:
  StabilityRunner(const Setup& setup, const ViewSpec& view) : setup_(setup), view_(view) {
    const FrameImages images = read_frame(setup.context, frame_of(camera_of(view)));
    points_ = followed_points(setup.scene, images, *setup.spec.stability);
  }

  json run() {
    for (const Profile& profile : setup_.plan.profiles) {
      for (const PlannedMethod& planned : setup_.plan.methods)
        runs_.push_back({{"profile", profile.name}, {"label", planned.label}});
    }
    for (const DerivedViews& derived : derived_views(view_, *setup_.spec.stability)) follow(derived);
    return {{"stability", kinds_}, {"runs", runs_}};
  }

 private:
  Frame frame_of(const Camera& camera) const {
    return render_frame(setup_.context, setup_.surface, setup_.scene.shading, camera);
  }

  void follow(const DerivedViews& derived) {
    followed_.assign(setup_.plan.profiles.size() * setup_.plan.methods.size(), Followed(points_.size()));
    done_ = {{"view", view_.name},
             {"kind", derived.kind},
             {"views", derived.cameras.size()},
             {"followed", points_.size()},
             {"seen", json::array()},
             {"audited", 0},
             {"max_error", 0.0},
             {"tolerance", setup_.spec.truth.tolerance}};
    Progress progress(fmt::format("view {}: {}", view_.name, derived.kind), derived.cameras.size());
    for (const Camera& camera : derived.cameras) {
      measure(camera);
      progress.advance();
    }
    for (std::size_t r = 0; r < runs_.size(); ++r)
      put(setup_.plan.methods[r % setup_.plan.methods.size()], derived.kind, followed_[r], runs_[r]);
    kinds_.push_back(done_);
  }

  Followed& of(std::size_t profile, std::size_t method) {
    return followed_[profile * setup_.plan.methods.size() + method];
  }

  void measure(const Camera& camera) {
    const Frame frame = frame_of(camera);
    const FrameImages images = read_frame(setup_.context, frame);
    const std::vector<SeenPoint> seen = seen_points(points_, setup_.scene, images, camera);
    done_["seen"].push_back(seen.size());
    if (seen.empty()) return;
    const FrameImages measured = setup_.spec.stability->points == 0 ? images : only_at(images, seen);
    ViewTruth truth(setup_.scene, measured);
    std::vector<ViewTruth::Request> requests;
    for (const Profile& profile : setup_.plan.profiles) requests.push_back({&profile, OwnTarget{}});
    truth.compute(
        requests, setup_.spec.truth,
        [&](LayerKind kind, const ViewPoints& points) { return setup_.truths.source(kind, points); },
        nullptr);
    const double median_depth_mm = median_skin_depth_mm(images);
    for (std::size_t p = 0; p < setup_.plan.profiles.size(); ++p) {
      const Profile& profile = setup_.plan.profiles[p];
      const TruthImage wanted = truth.image({&profile, OwnTarget{}});
      note(wanted.certificate);
      for (std::size_t m = 0; m < setup_.plan.methods.size(); ++m) {
        const PlannedMethod& planned = setup_.plan.methods[m];
        if (!missing(planned).empty()) continue;
        const Image exitance = draw_method(*planned.method, {setup_.context, frame, setup_.surface,
                                                             median_depth_mm, profile, planned.settings});
        of(p, m).add(exitance, wanted, seen);
      }
    }
  }

  // The worst of all audits.
  void note(const Certificate& certificate) {
    done_["audited"] = done_["audited"].get<std::size_t>() + certificate.audited;
    done_["max_error"] = std::max(done_["max_error"].get<double>(), certificate.max_error);
  }

  // Why a method has no stability.
  std::string missing(const PlannedMethod& planned) const {
    if (planned.pictures != nullptr) return "a picture made elsewhere: there is none of other views";
    return is_skipped(planned, setup_.surface.has_uvs()) ? "this method needs UVs" : "";
  }

  void put(const PlannedMethod& planned, const std::string& kind, const Followed& followed, json& run) const {
    if (const std::string reason = missing(planned); !reason.empty()) {
      run["metrics"] = {{"stability", nullptr}, {"stability_reason", reason}};
      return;
    }
    const auto spread = [&](std::size_t quantity) {
      return spread_json(followed, quantity, setup_.scene.largest_irradiance);
    };
    run["metrics"]["stability"][kind] = spread(0);
    for (std::size_t q = 1; q < kQuantities.size(); ++q)
      run["metrics"]["channels"][std::string(name_of(kQuantities[q]))]["stability"][kind] = spread(q);
  }

  const Setup& setup_;
  const ViewSpec& view_;
  std::vector<FollowedPoint> points_;
  std::vector<Followed> followed_;  // of the current kind, by profile and method
  json kinds_ = json::array();
  json runs_ = json::array();  // by profile and method
  json done_;
};

}  // namespace

std::vector<DerivedViews> derived_views(const ViewSpec& view, const StabilitySpec& spec) {
  const Camera base = camera_of(view);
  std::vector<DerivedViews> all;
  if (spec.orbit_views > 0) {
    const bool closed = spec.orbit_deg == 360.0;
    const double step = spec.orbit_deg / (closed ? spec.orbit_views : spec.orbit_views - 1);
    all.push_back({"orbit", {}});
    for (int i = 0; i < spec.orbit_views; ++i)
      all.back().cameras.push_back(turned(base, (closed ? 0.0 : -0.5 * spec.orbit_deg) + i * step));
  }
  if (!spec.dolly_factors.empty()) {
    all.push_back({"dolly", {}});
    for (const double factor : spec.dolly_factors) {
      all.back().cameras.push_back(base);
      all.back().cameras.back().eye_mm = base.target_mm + factor * (base.eye_mm - base.target_mm);
    }
  }
  if (spec.jitter_views > 0) {
    all.push_back({"jitter", {}});
    for (int i = 1; i <= spec.jitter_views; ++i) {
      all.back().cameras.push_back(base);
      all.back().cameras.back().shift_px = Vec2d(halton(i, 2) - 0.5, halton(i, 3) - 0.5);
    }
  }
  return all;
}

std::vector<SeenPoint> seen_points(const std::vector<FollowedPoint>& points, const PreparedScene& scene,
                                   const FrameImages& images, const Camera& camera) {
  const Mat4d view = camera.view_matrix();
  std::vector<SeenPoint> seen;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const FollowedPoint& point = points[i];
    const Vec3d in_view = (view * point.position_mm.homogeneous()).head<3>();
    if (!(in_view.z() < 0.0)) continue;
    const Vec2d at = camera.image_point_px(in_view);
    const bool in_image = at.minCoeff() >= 0.0 && at.x() < camera.width_px && at.y() < camera.height_px;
    if (!in_image) continue;
    const SeenPoint pixel{i, static_cast<int>(at.x()), static_cast<int>(at.y())};
    const PixelSurface& surface = images.surface_at(pixel.x, pixel.y);
    if (surface.triangle < 0 || images.mask.at(pixel.x, pixel.y, 0) == 0.0F) continue;
    const FollowedPoint behind = point_behind(scene.shading, surface);
    const Vec3d to_eye = camera.eye_mm - point.position_mm;
    const bool same_side = (to_eye.dot(point.normal) > 0.0) == (to_eye.dot(behind.normal) > 0.0);
    if (behind.component != point.component || !same_side) continue;
    const Vec3d apart = point.position_mm - behind.position_mm;
    const double off_plane_mm =
        std::min(std::abs(apart.dot(point.normal)), std::abs(apart.dot(behind.normal)));
    if (off_plane_mm <= 0.5 * -in_view.z() / camera.focal_px()) seen.push_back(pixel);
  }
  return seen;
}

json measure_stability(const Setup& setup, const ViewSpec& view) {
  return StabilityRunner(setup, view).run();
}

}  // namespace truescatter
