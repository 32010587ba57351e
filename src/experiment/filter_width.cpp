#include "experiment/filter_width.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "core/progress.h"
#include "experiment/result_json.h"
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

// A plane lit by 1, by the square of the distance along x and by that along y, in red, green and blue:
// methods treat channels alike and apart. Distances are in standard deviations, and along the plane.
ShadingMesh lit_plane(double std_dev_mm, double slope_deg, double mm_per_uv_unit) {
  const Mesh mesh = turned_plane(kPlaneStdDevs * std_dev_mm, slope_deg, mm_per_uv_unit);
  Light light;
  light.shadows = false;
  ShadingMesh plane =
      make_shading_mesh(mesh, Lighting(mesh, {light}), SkinMask(), {1e6, kPlaneStdDevs * std_dev_mm});
  const Eigen::AngleAxisd turn = turned_by(slope_deg);
  const Vec3d x = turn * Vec3d::UnitX(), y = turn * Vec3d::UnitY();
  for (ShadingTriangle& triangle : plane.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d p = plane.corner(triangle, c) / std_dev_mm;
      triangle.irradiance[c] = Vec3d(1.0, std::pow(x.dot(p), 2), std::pow(y.dot(p), 2));
    }
  }
  return plane;
}

// What is left of the variance along x and y, by the middle pixel of the plane's exitance.
Vec2d shares_of(const Image& exitance) {
  const int middle_px = exitance.width() / 2;
  const Vec3d middle = exitance.rgb(middle_px, middle_px);
  const double cell_std_devs = kPlaneStdDevs / kCells;
  return (middle.tail<2>() / middle.x()).array() - cell_std_devs * cell_std_devs / 6.0;
}

}  // namespace

FilterWidthProbe::FilterWidthProbe(const gpu::Context& context, const Profile& profile, double mm_per_uv_unit)
    : context_(context), std_dev_mm_(profile.widest_std_dev_mm()), mm_per_uv_unit_(mm_per_uv_unit) {
  gaussian_.name = "widest-gaussian";
  gaussian_.terms = {{Vec3d::Constant(std_dev_mm_ * std_dev_mm_), Vec3d::Ones()}};
  gaussian_.r_max_mm = profile.r_max_mm;
}

const FilterWidthProbe::Plane& FilterWidthProbe::plane_at(double slope_deg) {
  assert(std_dev_mm_ > 0.0);
  const auto found = planes_.find(slope_deg);
  if (found != planes_.end()) return found->second;
  return planes_.try_emplace(slope_deg, context_, lit_plane(std_dev_mm_, slope_deg, mm_per_uv_unit_))
      .first->second;
}

Vec2d FilterWidthProbe::shares(const Method& method, const Settings& settings, double slope_deg) {
  const Plane& plane = plane_at(slope_deg);
  const double half_std_devs = std::max(4.5, gaussian_.r_max_mm / std_dev_mm_);
  double reads_per_pixel = 0.0;
  const auto shares_at = [&](double pixels_per_std_dev, bool count_reads) {
    const Frame frame = render_frame(context_, plane.buffers, plane.mesh,
                                     parallel_camera(std_dev_mm_, pixels_per_std_dev, half_std_devs));
    const PreparedMethod prepared =
        method.prepare({context_, frame, plane.buffers, kDistanceStdDevs * std_dev_mm_, gaussian_, settings});
    Passes passes(context_);
    if (count_reads) {
      const double pixels = static_cast<double>(frame.camera.width_px) * frame.camera.height_px;
      reads_per_pixel = passes.count([&] { prepared.render(passes); }).texels_read / pixels;
    }
    prepared.render(passes);
    return shares_of(gpu::read_texture(context_, *prepared.output, 3));
  };
  const Vec2d coarse = shares_at(kPixelsPerStdDev, !method.needs_uvs);
  // What is filtered in texture space does not know of pixels.
  if (method.needs_uvs || reads_per_pixel > kMostReadsOfTaps) return coarse;
  const Eigen::Array2d change = (shares_at(kOtherPixelsPerStdDev, false) - coarse).array().abs();
  if ((change <= kAgreement).all()) return coarse;
  return (change <= kAgreement).select(coarse, shares_at(kPixelsPerStdDevForTaps, false));
}

FilterWidth FilterWidthProbe::measure(const Method& method, const Settings& settings) {
  const double facing = shares(method, settings, 0.0).x();
  if (method.needs_uvs) return {facing, facing, facing};
  const Vec2d sloping = shares(method, settings, kSlopeDeg);
  return {facing, sloping.x(), sloping.y()};
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

FilterWidth width_of(FilterWidthProbe& probe, const Profile& profile, const PlannedMethod& planned,
                     double mm_per_uv_unit, KnownWidths& known) {
  // UVs matter to what filters in texture space alone.
  const json key = {planned.label, settings_json(planned.settings), profile_json(profile),
                    planned.method->needs_uvs ? mm_per_uv_unit : 0.0};
  const std::string name = key.dump();
  if (const auto found = known.find(name); found != known.end()) return found->second;
  const FilterWidth width = probe.measure(*planned.method, planned.settings);
  known.emplace(name, width);
  return width;
}

}  // namespace

json measure_filter_widths(const gpu::Context& context, const Plan& plan, const SurfaceBuffers& scene,
                           KnownWidths& known) {
  const auto width_of_rung = [&](FilterWidthProbe& probe, const Profile& profile,
                                 const std::string& rung) -> json {
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
    return filter_width_json(width_of(probe, profile, *method, scene.mean_mm_per_uv_unit(), known));
  };
  std::set<std::string> rungs;
  for (const LadderSpec& ladder : plan.ladders) {
    for (const LadderSpec::Rung& rung : ladder.rungs) rungs.insert(rung.name());
  }
  Progress progress("ladders: what is left of a Gaussian's variance", plan.profiles.size() * rungs.size());
  json widths = json::array();
  for (const Profile& profile : plan.profiles) {
    FilterWidthProbe probe(context, profile, scene.mean_mm_per_uv_unit());
    for (const std::string& rung : rungs) {
      widths.push_back(
          {{"profile", profile.name}, {"rung", rung}, {"filter_width", width_of_rung(probe, profile, rung)}});
      progress.advance();
    }
  }
  return widths;
}

}  // namespace truescatter
