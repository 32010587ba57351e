#pragma once

#include <memory>
#include <vector>

#include "composite/specular.h"
#include "composite/tone.h"
#include "core/image.h"
#include "gpu/context.h"
#include "irradiance/lighting.h"

namespace truescatter {

// A light as a view sees what it lights.
struct SeenLight {
  Light light;
  // Of a light without size, its irradiance behind every pixel, without albedo; of an environment, the share
  // of its irradiance that occlusion leaves. Three channels.
  Image map;
};

// What reflection off a view's surfaces depends on. Images of one size, row 0 at the top.
struct SpecularInputs {
  Mat4d world_to_view;
  const Image& position;  // 4: view space, mm; the last 1 where a surface is seen
  const Image& normal;    // 3: the mapped unit normal, view space
  const Image& gloss;     // 2: intensity rho_s (0 on what is not skin), roughness m
  const std::vector<SeenLight>& lights;
};

// What a picture is made of beside a method's exitance. Images of its size, RGB.
struct CompositeInputs {
  const Image& albedo;    // what of it comes after the scattering
  const Image& specular;  // as Compositor::specular_light gives it
  double exposure;
};

struct CompositorSettings {
  double f0 = kSkinF0;
  BeckmannEncoding encoding = BeckmannEncoding::logarithm;
  ToneCurve curve = ToneCurve::filmic;
};

// Draws the picture that a person sees. Holds its programs and tables: one serves all views and methods.
class Compositor {
 public:
  Compositor(const gpu::Context& context, const CompositorSettings& settings);
  ~Compositor();
  Compositor(const Compositor&) = delete;
  Compositor& operator=(const Compositor&) = delete;

  // The specular light of a view by specular.frag: pi times the reflected radiance, in units of irradiance;
  // RGB.
  Image specular_light(const SpecularInputs& inputs) const;

  // tone(exposure (exitance albedo + specular)) by composite.frag, linear RGB in [0, 1].
  Image picture(const CompositeInputs& inputs, const Image& exitance) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace truescatter
