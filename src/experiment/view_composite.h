#pragma once

#include "composite/compositor.h"
#include "config/experiment_spec.h"
#include "experiment/scene_setup.h"
#include "gpu/context.h"
#include "methods/frame.h"

namespace truescatter {

// Makes the picture that a person sees of one view, out of any exitance ([composite]).
class ViewComposite {
 public:
  // `albedo` is what of the scene's comes after the scattering, behind every pixel; empty: 1. The scene was
  // prepared for an experiment with [composite].
  ViewComposite(const CompositeSpec& spec, const PreparedScene& scene, const gpu::Context& context,
                const Frame& frame, const FrameImages& images, const Image& albedo);

  // tone(exposure (exitance albedo + specular)), linear RGB in [0, 1] of the display. What is not skin shows
  // its irradiance, whatever the exitance says there; the background is black.
  Image picture(const Image& exitance) const;
  // Pi times the reflected radiance, in units of irradiance; 0 without specular light.
  const Image& specular() const { return specular_; }
  const Image& albedo() const { return albedo_; }  // what multiplies the exitance

 private:
  const CompositeSpec& spec_;
  const gpu::Context& context_;
  const FrameImages& images_;
  double exposure_;
  Image albedo_;
  Image specular_;
};

}  // namespace truescatter
