#pragma once

#include "methods/method.h"

namespace truescatter {

// What Mikkelsen's filters share: the radius r_max that bounds them, and Gaussians ready for a dense sum over
// pixels.

// The setting "r_max_mm": 0 takes the profile's own radius, so that a profile brings the radius that its
// source names (table 1: 4.5 mm) and scales with it.
SettingSpec r_max_setting();
double r_max_mm(const Profile& profile, const Settings& settings);

// A term of a profile for pixel_mean.glsl.
struct DenseTerm {
  Vec3d weight;      // per channel
  Vec3d std_dev_mm;  // per channel; where the weight is 0, that of another channel
  double reach_mm =
      0.0;  // min(r_max, 5.5 widest std_dev_mm): beyond it lie exp(-5.5^2 / 2) = 3e-7 of the light

  // weight / (2 pi s^2), per channel.
  Vec3d raw_scale() const;
  // The uniforms of pixel_mean.glsl; the program must be in use.
  void set(const gpu::Program& program, double r_max_mm) const;
};

// The terms with any weight, in their order. Channels whose standard deviations differ by more than a factor
// of 3 become terms of their own, for one lattice of samples cannot serve both.
std::vector<DenseTerm> dense_terms(const Profile& profile, double r_max_mm);

// Where light comes from: positions, and irradiance times a weight with the weight in alpha (0 off the skin).
struct LightLayer {
  const gpu::Texture& position;
  const gpu::Texture& light;
};

// The frame's irradiance times w(p), with w(p) in alpha (weighted.frag): drawn once, read by every term.
class WeightedLight {
 public:
  explicit WeightedLight(const MethodInputs& inputs, const std::vector<std::string>& defines = {});

  void draw(Passes& passes, const Frame& frame) const;
  const gpu::Texture& light() const { return target_.texture; }

 private:
  PassProgram program_;
  Target target_;
};

// A pass that adds linear_sum.glsl's sum around every pixel to a target, through a shader of the method's
// own.
class LinearSum {
 public:
  // `fragment`: path below src/methods/ of a shader that calls linear_sum and has the uniform vec3 `scale`.
  LinearSum(const gpu::Context& context, const std::string& fragment,
            const std::vector<std::string>& defines);

  // `more` sets what uniforms the method has besides; texture units from 5 are free.
  void add(
      Passes& passes, const Frame& frame, const LightLayer& layer, const DenseTerm& term, const Vec3d& scale,
      double r_max_mm, const Target& to, const Passes::SetUniforms& more = [](const gpu::Program&) {}) const;

 private:
  PassProgram program_;
};

// While recording, names what bounds a filter at every pixel of the frame: "extent", d' along x and y in
// pixels, and "scale", K in mm per pixel (filter_geometry.frag).
void show_filter_geometry(Passes& passes, const Frame& frame, double r_max_mm);

// How many pixels a dense sum can take: Mesa's software rasteriser leaves a shader's loops after 65535 turns
// in all, without a word. What is beyond this is for the loops over rows and cells.
inline constexpr double kMostPixels = 60000.0;

// Throws Error (input) where a ball as wide as the terms' reach around some skin of the view covers more
// pixels than that, by its bounds on the screen. Reads the frame's positions back.
void check_reach(const MethodInputs& inputs, std::string_view method, const std::vector<DenseTerm>& terms);

}  // namespace truescatter
