#include "experiment/filter_width.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "core/progress.h"
#include "experiment/result_json.h"
#include "irradiance/shading_mesh.h"
#include "methods/frame.h"
#include "methods/passes.h"
#include "scene/builtin.h"

namespace truescatter {

using nlohmann::json;

namespace {

constexpr double kPlaneStdDevs = 15.0;
constexpr double kCells =
    260.0;  // along the plane's edge: pixels meet their vertices nowhere but in the middle
constexpr double kDistanceStdDevs = 2000.0;
constexpr double kPixelsPerStdDev = 8.0;
constexpr double kPixelsPerStdDevForTaps = 96.0;
constexpr double kOtherPixelsPerStdDev =
    9.7;                                    // shares no ratio with kPixelsPerStdDev that taps could fall into
constexpr double kAgreement = 2e-3;         // of dense sums at both
constexpr double kMostReadsOfTaps = 300.0;  // a pixel

Eigen::AngleAxisd turned_by(double slope_deg) { return {slope_deg * kPi / 180.0, Vec3d::UnitY()}; }

Mesh turned_plane(double size_mm, double slope_deg, double mm_per_uv_unit) {
  // Built-in scenes bound their lengths; a plane is scaled to any.
  constexpr double kBuiltMm = 100.0;
  Mesh plane = make_builtin("plane", {{"size_mm", kBuiltMm}, {"edge_mm", kBuiltMm / kCells}});
  const Eigen::AngleAxisd turn = turned_by(slope_deg);
  if (mm_per_uv_unit > 0.0) {
    for (auto& corners : *plane.corner_uvs) {
      for (Vec2d& uv : corners)
        uv = Vec2d(0.5, 0.5) + (uv - Vec2d(0.5, 0.5)) * (size_mm / std::max(mm_per_uv_unit, size_mm));
    }
  }
  for (Vec3d& p : plane.positions_mm) p = turn * p * (size_mm / kBuiltMm);
  for (auto& corners : plane.corner_normals) {
    for (Vec3d& n : corners) n = turn * n;
  }
  return plane;
}

// The middle pixel's centre looks along the axis.
Camera parallel_camera(double std_dev_mm, double pixels_per_std_dev, double half_std_devs) {
  const int half_px = static_cast<int>(std::ceil(half_std_devs * pixels_per_std_dev)) + 2;
  Camera camera;
  camera.width_px = 2 * half_px + 1;
  camera.height_px = camera.width_px;
  camera.eye_mm = Vec3d(0.0, 0.0, kDistanceStdDevs * std_dev_mm);
  const double half_height_std_devs = 0.5 * camera.height_px / pixels_per_std_dev;
  camera.fov_y_deg = 2.0 * std::atan(half_height_std_devs / kDistanceStdDevs) * 180.0 / kPi;
  return camera;
}

struct MiddlePixel {
  double exitance;
  double reads_per_pixel;
};

}  // namespace

FilterWidthProbe::FilterWidthProbe(const gpu::Context& context, const Profile& profile, double mm_per_uv_unit)
    : context_(context), std_dev_mm_(profile.widest_std_dev_mm()), mm_per_uv_unit_(mm_per_uv_unit) {
  assert(std_dev_mm_ > 0.0);
  gaussian_.name = "widest-gaussian";
  gaussian_.terms = {{Vec3d::Constant(std_dev_mm_ * std_dev_mm_), Vec3d::Ones()}};
  gaussian_.r_max_mm = profile.r_max_mm;
}

double FilterWidthProbe::share(const Method& method, const Settings& settings, double slope_deg,
                               const Vec2d& along) const {
  const Mesh mesh = turned_plane(kPlaneStdDevs * std_dev_mm_, slope_deg, mm_per_uv_unit_);
  Light light;
  light.shadows = false;
  ShadingMesh shading =
      make_shading_mesh(mesh, Lighting(mesh, {light}), SkinMask(), {1e6, kPlaneStdDevs * std_dev_mm_});
  const Vec3d direction = turned_by(slope_deg) * Vec3d(along.x(), along.y(), 0.0);
  const auto lit = [&](const std::function<double(double)>& irradiance) {
    for (ShadingTriangle& triangle : shading.triangles) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double u = direction.dot(shading.corner(triangle, c)) / std_dev_mm_;
        triangle.irradiance[c] = Vec3d::Constant(irradiance(u));
      }
    }
    return SurfaceBuffers(context_, shading);
  };
  const SurfaceBuffers evenly_lit = lit([](double) { return 1.0; });
  const SurfaceBuffers lit_by_square = lit([](double u) { return u * u; });
  const double half_std_devs = std::max(4.5, gaussian_.r_max_mm / std_dev_mm_);
  const auto middle = [&](const SurfaceBuffers& buffers, double pixels_per_std_dev) {
    const Frame frame = render_frame(context_, buffers, shading,
                                     parallel_camera(std_dev_mm_, pixels_per_std_dev, half_std_devs));
    const PreparedMethod prepared =
        method.prepare({context_, frame, buffers, kDistanceStdDevs * std_dev_mm_, gaussian_, settings});
    Passes passes(context_);
    const double reads = method.needs_uvs ? 0.0 : passes.count([&] { prepared.render(passes); }).texels_read;
    prepared.render(passes);
    const Image exitance = gpu::read_texture(context_, *prepared.output, 3);
    const int half_px = exitance.width() / 2;
    const double pixels = static_cast<double>(exitance.width()) * exitance.height();
    return MiddlePixel{exitance.at(half_px, half_px, 0), reads / pixels};
  };
  const auto share_at = [&](double pixels_per_std_dev) {
    const MiddlePixel even = middle(evenly_lit, pixels_per_std_dev);
    const double cell_std_devs = kPlaneStdDevs / kCells;
    const double share = middle(lit_by_square, pixels_per_std_dev).exitance / even.exitance;
    return std::pair(share - cell_std_devs * cell_std_devs / 6.0, even.reads_per_pixel);
  };
  const auto [coarse, reads] = share_at(kPixelsPerStdDev);
  // What is filtered in texture space does not know of pixels.
  if (method.needs_uvs || reads > kMostReadsOfTaps) return coarse;
  if (std::abs(share_at(kOtherPixelsPerStdDev).first - coarse) <= kAgreement) return coarse;
  return share_at(kPixelsPerStdDevForTaps).first;
}

FilterWidth FilterWidthProbe::measure(const Method& method, const Settings& settings) const {
  if (method.needs_uvs) {
    const double in_texture_space = share(method, settings, 0.0, Vec2d::UnitX());
    return {in_texture_space, in_texture_space, in_texture_space};
  }
  return {share(method, settings, 0.0, Vec2d::UnitX()), share(method, settings, kSlopeDeg, Vec2d::UnitX()),
          share(method, settings, kSlopeDeg, Vec2d::UnitY())};
}

json filter_width_json(const FilterWidth& width) {
  return {{"facing", width.facing},
          {"along_slope", width.along_slope},
          {"across_slope", width.across_slope},
          {"slope_deg", kSlopeDeg}};
}

double cut_variance_share(double variance_mm2, double r_max_mm) {
  const double x = 0.5 * r_max_mm * r_max_mm / variance_mm2;
  return 1.0 - x / std::expm1(x);
}

namespace {

FilterWidth width_of(const gpu::Context& context, const Profile& profile, const PlannedMethod& planned,
                     const SurfaceBuffers& scene, KnownWidths& known) {
  // UVs matter to what filters in texture space alone.
  const double mm_per_uv_unit = planned.method->needs_uvs ? scene.mean_mm_per_uv_unit() : 0.0;
  const json key = {planned.label, settings_json(planned.settings), profile_json(profile), mm_per_uv_unit};
  const std::string name = key.dump();
  if (const auto found = known.find(name); found != known.end()) return found->second;
  const FilterWidth width =
      FilterWidthProbe(context, profile, mm_per_uv_unit).measure(*planned.method, planned.settings);
  known.emplace(name, width);
  return width;
}

}  // namespace

json measure_filter_widths(const gpu::Context& context, const Plan& plan, const SurfaceBuffers& scene,
                           KnownWidths& known) {
  const auto width_of_rung = [&](const Profile& profile, const std::string& rung) -> json {
    if (profile.terms.empty()) return nullptr;
    const double v = std::pow(profile.widest_std_dev_mm(), 2);
    if (rung.starts_with("truth-")) {
      const double share =
          rung.find("cut") != std::string::npos ? cut_variance_share(v, profile.r_max_mm) : 1.0;
      return filter_width_json({share, share, share});
    }
    const auto method = std::find_if(plan.methods.begin(), plan.methods.end(),
                                     [&](const PlannedMethod& m) { return m.label == rung; });
    if (method == plan.methods.end() || method->pictures != nullptr || is_skipped(*method, scene.has_uvs()))
      return nullptr;
    return filter_width_json(width_of(context, profile, *method, scene, known));
  };
  std::set<std::string> rungs;
  for (const LadderSpec& ladder : plan.ladders) {
    for (const LadderSpec::Rung& rung : ladder.rungs) rungs.insert(rung.name());
  }
  Progress progress("ladders: what is left of a Gaussian's variance", plan.profiles.size() * rungs.size());
  json widths = json::array();
  for (const Profile& profile : plan.profiles) {
    for (const std::string& rung : rungs) {
      widths.push_back(
          {{"profile", profile.name}, {"rung", rung}, {"filter_width", width_of_rung(profile, rung)}});
      progress.advance();
    }
  }
  return widths;
}

}  // namespace truescatter
