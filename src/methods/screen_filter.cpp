#include "methods/screen_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace truescatter {
namespace {

constexpr double kReachStdDevs = 5.5;
constexpr double kLargestRatio = 3.0;

void add_term(std::vector<DenseTerm>& terms, const GaussianTerm& term, const Vec3d& weight, double r_max_mm) {
  DenseTerm dense{weight, term.std_dev_mm(), 0.0};
  double narrowest_mm = std::numeric_limits<double>::infinity();
  double widest_mm = 0.0;
  for (int c = 0; c < 3; ++c) {
    if (weight[c] == 0.0) continue;
    narrowest_mm = std::min(narrowest_mm, dense.std_dev_mm[c]);
    widest_mm = std::max(widest_mm, dense.std_dev_mm[c]);
  }
  if (widest_mm == 0.0) return;
  if (widest_mm > kLargestRatio * narrowest_mm) {
    for (int c = 0; c < 3; ++c) add_term(terms, term, weight[c] * Vec3d::Unit(c), r_max_mm);
    return;
  }
  dense.std_dev_mm = dense.std_dev_mm.cwiseMax(narrowest_mm).cwiseMin(widest_mm);
  dense.reach_mm = std::min(r_max_mm, kReachStdDevs * widest_mm);
  terms.push_back(dense);
}

// How far a ball reaches across the screen along one axis, with a pixel at each end: d_a of
// filter_geometry.glsl, tan(alpha + beta) - tan(alpha - beta) = 2 r sqrt(x_a^2 + z^2 - r^2) / (z^2 - r^2).
double extent_px(double along_mm, double z_mm, double radius_mm, double focal_px) {
  const double r2 = radius_mm * radius_mm;
  const double z2 = z_mm * z_mm;
  if (z2 <= r2) return std::numeric_limits<double>::infinity();
  return focal_px * 2.0 * radius_mm * std::sqrt(along_mm * along_mm + z2 - r2) / (z2 - r2) + 3.0;
}

}  // namespace

SettingSpec r_max_setting() {
  return {"r_max_mm", "radius beyond which light is left out; 0: the profile's", 0.0, 0.0, 1000.0};
}

double r_max_mm(const Profile& profile, const Settings& settings) {
  const double given_mm = settings.number("r_max_mm");
  return given_mm > 0.0 ? given_mm : profile.r_max_mm;
}

Vec3d DenseTerm::raw_scale() const { return weight.cwiseQuotient(2.0 * kPi * std_dev_mm.cwiseAbs2()); }

void DenseTerm::set(const gpu::Program& program, double r_max_mm) const {
  program.set("exponent", Vec3d(-0.5 * std_dev_mm.cwiseAbs2().cwiseInverse()));
  program.set("narrowest_mm", std_dev_mm.minCoeff());
  program.set("reach_mm", reach_mm);
  program.set("r_max_mm", r_max_mm);
}

std::vector<DenseTerm> dense_terms(const Profile& profile, double r_max_mm) {
  std::vector<DenseTerm> terms;
  for (const GaussianTerm& term : profile.terms) add_term(terms, term, term.weight, r_max_mm);
  return terms;
}

WeightedLight::WeightedLight(const MethodInputs& inputs, const std::vector<std::string>& defines)
    : program_(
          PassProgram::of_pieces(inputs.context, {}, {"filter_geometry.glsl", "weighted.frag"}, defines)),
      target_(inputs.context, inputs.frame.camera.width_px, inputs.frame.camera.height_px,
              gpu::Format::rgba32f) {}

void WeightedLight::draw(Passes& passes, const Frame& frame) const {
  passes.draw(program_, target_, [&](const gpu::Program& program) {
    program.set("irradiance", frame.irradiance, 0);
    program.set("position", frame.position, 1);
    program.set("face_normal", frame.face_normal, 2);
  });
}

LinearSum::LinearSum(const gpu::Context& context, const std::string& fragment,
                     const std::vector<std::string>& defines)
    : program_(PassProgram::of_pieces(
          context, {}, {"filter_geometry.glsl", "pixel_mean.glsl", "linear_sum.glsl", fragment}, defines)) {}

void LinearSum::add(Passes& passes, const Frame& frame, const LightLayer& layer, const DenseTerm& term,
                    const Vec3d& scale, double r_max_mm, const Target& to,
                    const Passes::SetUniforms& more) const {
  passes.draw(
      program_, to,
      [&](const gpu::Program& program) {
        program.set("position", frame.position, 0);
        program.set("normal", frame.normal, 1);
        program.set("face_normal", frame.face_normal, 2);
        program.set("tap_position", layer.position, 3);
        program.set("light", layer.light, 4);
        program.set("focal_px", frame.camera.focal_px());
        program.set("scale", scale);
        term.set(program, r_max_mm);
        more(program);
      },
      true);
}

void show_filter_geometry(Passes& passes, const Frame& frame, double r_max_mm) {
  if (!passes.recording()) return;
  const Target target(passes.context(), frame.camera.width_px, frame.camera.height_px, gpu::Format::rg32f);
  const auto show = [&](const std::vector<std::string>& defines, const char* name, const char* shows) {
    passes.draw(PassProgram::of_pieces(passes.context(), {}, {"filter_geometry.glsl", "filter_geometry.frag"},
                                       defines),
                target, [&](const gpu::Program& program) {
                  program.set("position", frame.position, 0);
                  program.set("normal", frame.normal, 1);
                  program.set("irradiance", frame.irradiance, 2);
                  program.set("r_max_mm", r_max_mm);
                  program.set("focal_px", frame.camera.focal_px());
                });
    passes.show(target.texture, name, "xy", shows);
  };
  show({}, "extent", "d', the extent of the filter's disc along x and y, px");
  show({"SCALE"}, "scale", "K along x and y, mm per px");
}

void check_reach(const MethodInputs& inputs, std::string_view method, const std::vector<DenseTerm>& terms) {
  double reach_mm = 0.0;
  for (const DenseTerm& term : terms) reach_mm = std::max(reach_mm, term.reach_mm);
  const Image positions = gpu::read_texture(inputs.context, inputs.frame.position, 3);
  const Image light = gpu::read_texture(inputs.context, inputs.frame.irradiance, 4);
  const double focal_px = inputs.frame.camera.focal_px();
  for (int y = 0; y < positions.height(); ++y) {
    for (int x = 0; x < positions.width(); ++x) {
      if (light.at(x, y, 3) == 0.0F) continue;
      const Vec3d at = positions.rgb(x, y);
      const double width_px =
          std::min(extent_px(at.x(), at.z(), reach_mm, focal_px), positions.width() + 0.0);
      const double height_px =
          std::min(extent_px(at.y(), at.z(), reach_mm, focal_px), positions.height() + 0.0);
      if (width_px * height_px <= kMostPixels) continue;
      throw_input_error(
          {},
          "method '{}': its reach of {:.3g} mm spans {:.0f} x {:.0f} pixels around skin {:.3g} mm "
          "away, and a sum over all pixels can take {:.0f}: lower its setting 'r_max_mm' or the "
          "view's resolution",
          method, reach_mm, width_px, height_px, -at.z(), kMostPixels);
    }
  }
}

}  // namespace truescatter
