#pragma once

#include "composite/compositor.h"
#include "config/experiment_spec.h"
#include "experiment/reflection_pictures.h"
#include "methods/frame.h"

namespace truescatter {

CompositorSettings compositor_settings(const CompositeSpec& spec);

// Makes the picture that a person sees of one view, out of any exitance ([composite]).
class ViewComposite {
 public:
  // `reflected`: with gloss, where specular light is asked for; not kept. `albedo`: what of the scene's comes
  // after the scattering, behind every pixel; empty: 1.
  ViewComposite(const CompositeSpec& spec, double largest_irradiance, const Compositor& compositor,
                const Frame& frame, const FrameImages& images, const ReflectionPictures* reflected,
                const Image& albedo);

  // tone(exposure (exitance albedo + specular)), linear RGB in [0, 1] of the display. What is not skin shows
  // its irradiance, whatever the exitance says there; the background is black.
  Image picture(const Image& exitance) const;
  // Pi times the reflected radiance, in units of irradiance; 0 without specular light.
  const Image& specular() const { return specular_; }
  const Image& albedo() const { return albedo_; }  // what multiplies the exitance

 private:
  const Compositor& compositor_;
  const FrameImages& images_;
  double exposure_;
  Image albedo_;
  Image specular_;
};

}  // namespace truescatter
