#pragma once

#include <vector>

#include "composite/compositor.h"
#include "config/experiment_spec.h"
#include "experiment/scene_setup.h"
#include "methods/frame.h"

namespace truescatter {

// What reflection off a view's surfaces depends on, behind every pixel where one is seen.
struct ReflectionPictures {
  std::vector<SeenLight> lights;  // in the experiment's order
  Image normal;                   // the mapped unit normal, view space
  // Intensity and roughness; intensity 0 off the skin and where a face is seen from behind. Empty where it
  // was not asked for.
  Image gloss;
};

// A light without size is lit anew at every pixel's point, with its shadow; what occlusion leaves of an
// environment is interpolated between the shading mesh's vertices, as irradiance is. `gloss`: where it comes
// from; null: none is made.
ReflectionPictures reflection_pictures(const PreparedScene& scene, const SceneReflection& reflection,
                                       const FrameImages& images, const Mat4d& world_to_view,
                                       const CompositeSpec* gloss);

}  // namespace truescatter
