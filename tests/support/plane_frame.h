#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "support/render.h"

namespace truescatter::test {

// An endless plane of skin through the point (0, 0, -distance_mm) of view space, as a frame without a mesh:
// every pixel's point and light are the plane's own, to single precision.
struct PlaneView {
  double distance_mm = 600.0;
  double mm_per_px = 0.15;  // at the middle of the picture, facing
  int px = 96;
  double tilt_deg = 0.0;
  Vec3d tilt_axis = Vec3d::UnitY();  // in the XY plane
  double shading_tilt_deg = 0.0;     // by how much more the interpolated normal is turned than the plane

  Eigen::AngleAxisd turn() const { return {tilt_deg * kPi / 180.0, tilt_axis.normalized()}; }
  Vec3d normal() const { return turn() * Vec3d::UnitZ(); }
  Vec3d shading_normal() const {
    return Eigen::AngleAxisd((tilt_deg + shading_tilt_deg) * kPi / 180.0, tilt_axis.normalized()) *
           Vec3d::UnitZ();
  }
  Camera camera() const { return camera_at(distance_mm, mm_per_px * px, px); }
  // The plane's point behind a pixel's centre, row 0 at the top.
  Vec3d point(int x, int y) const {
    const Vec3d ray((x + 0.5 - 0.5 * px) * mm_per_px / distance_mm,
                    (0.5 * px - y - 0.5) * mm_per_px / distance_mm, -1.0);
    return ray * (-distance_mm * normal().z() / normal().dot(ray));
  }
  // Its coordinate in the plane along the direction that x has before the plane is turned.
  double along(int x, int y) const {
    return (turn() * Vec3d::UnitX()).dot(point(x, y) - Vec3d(0.0, 0.0, -distance_mm));
  }
};

class PlaneFrame {
 public:
  // `light` gives irradiance by PlaneView::along, the same in all channels.
  PlaneFrame(const PlaneView& view, const std::function<double(double)>& light)
      : view_(view), frame_{view.camera(),
                            Mat4d::Identity(),
                            Mat4d::Identity(),
                            texture(),
                            texture(),
                            texture(),
                            texture(),
                            {},
                            {}} {
    Image position(view.px, view.px, 4, 1.0F);
    Image face_normal(view.px, view.px, 4, 0.0F);
    Image normal(view.px, view.px, 4, 0.0F);
    Image irradiance(view.px, view.px, 4, 1.0F);
    for (int y = 0; y < view.px; ++y) {
      for (int x = 0; x < view.px; ++x) {
        position.set_rgb(x, y, view.point(x, y));
        face_normal.set_rgb(x, y, view.normal());
        normal.set_rgb(x, y, view.shading_normal());
        irradiance.set_rgb(x, y, Vec3d::Constant(light(view.along(x, y))));
      }
    }
    frame_.position.upload(position);
    frame_.face_normal.upload(face_normal);
    frame_.normal.upload(normal);
    frame_.irradiance.upload(irradiance);
  }

  Image run(const Method& method, const Profile& profile,
            const std::map<std::string, SettingValue>& given) const {
    // For methods that draw no geometry: a mesh that none of them reads.
    static const ShadingMesh unused = shade(make_builtin("plane"), lamp(Vec3d::UnitZ()));
    static const SurfaceBuffers buffers(Scene::context(), unused);
    const Settings settings(method.name, method.settings, given);
    const PreparedMethod prepared =
        method.prepare({Scene::context(), frame_, buffers, view_.distance_mm, profile, settings});
    Passes passes(Scene::context());
    prepared.render(passes);
    return gpu::read_texture(Scene::context(), *prepared.output, 3);
  }

 private:
  gpu::Texture texture() const { return {Scene::context(), view_.px, view_.px, gpu::Format::rgba32f}; }

  PlaneView view_;
  Frame frame_;
};

// One Gaussian of variance s^2 in all channels, without a spike.
inline Profile one_gaussian(double std_dev_mm, double r_max_mm) {
  Profile profile;
  profile.name = "one-gaussian";
  profile.terms = {{Vec3d::Constant(std_dev_mm * std_dev_mm), Vec3d::Ones()}};
  profile.r_max_mm = r_max_mm;
  return profile;
}

// On a plane under the light cos(2 pi x / wavelength) the convolution with a Gaussian cut off at r_max is
// that light times int_0^r_max (r / s^2) exp(-r^2 / 2 s^2) J_0(2 pi r / wavelength) dr: what its
// two-dimensional Fourier transform is. By Simpson's rule on 4000 intervals, whose error (r_max / 4000)^4 /
// 180 is below 1e-12 of it. Wavelength infinity gives the mass.
inline double plane_transfer(double std_dev_mm, double r_max_mm, double wavelength_mm) {
  constexpr int kIntervals = 4000;
  const double v = std_dev_mm * std_dev_mm;
  const double step_mm = r_max_mm / kIntervals;
  double sum = 0.0;
  for (int i = 0; i <= kIntervals; ++i) {
    const double r = i * step_mm;
    const double weight = i == 0 || i == kIntervals ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum +=
        weight * r / v * std::exp(-0.5 * r * r / v) * std::cyl_bessel_j(0.0, 2.0 * kPi * r / wavelength_mm);
  }
  return sum * step_mm / 3.0;
}

}  // namespace truescatter::test
