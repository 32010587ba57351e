#include "experiment/view_composite.h"

#include <cassert>

namespace truescatter {
namespace {

Image with_alpha(const Image& rgb, const std::vector<PixelSurface>& surface) {
  Image image(rgb.width(), rgb.height(), 4);
  for (std::size_t i = 0; i < surface.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) image.data()[4 * i + c] = rgb.data()[3 * i + c];
    image.data()[4 * i + 3] = surface[i].triangle < 0 ? 0.0F : 1.0F;
  }
  return image;
}

Image specular_of(const CompositeSpec& spec, const Compositor& compositor, const Frame& frame,
                  const FrameImages& images, const ReflectionPictures* reflected) {
  if (!spec.specular) return {images.mask.width(), images.mask.height(), 3};
  assert(reflected != nullptr && !reflected->gloss.empty());
  const Image position = with_alpha(images.position, images.surface);
  return compositor.specular_light(
      {frame.view, position, reflected->normal, reflected->gloss, reflected->lights});
}

Image albedo_of(const CompositeSpec& spec, const FrameImages& images, const Image& after) {
  Image albedo(images.mask.width(), images.mask.height(), 3, 1.0F);
  for (std::size_t i = 0; i < albedo.data().size(); ++i) {
    if (!after.empty()) albedo.data()[i] = after.data()[i];
    if (images.mask.data()[i / 3] != 0.0F)
      albedo.data()[i] *= static_cast<float>(spec.albedo[static_cast<Eigen::Index>(i % 3)]);
  }
  return albedo;
}

}  // namespace

CompositorSettings compositor_settings(const CompositeSpec& spec) {
  return {spec.f0, spec.beckmann == "power" ? BeckmannEncoding::power : BeckmannEncoding::logarithm,
          spec.tone == "linear" ? ToneCurve::linear : ToneCurve::filmic};
}

ViewComposite::ViewComposite(const CompositeSpec& spec, double largest_irradiance,
                             const Compositor& compositor, const Frame& frame, const FrameImages& images,
                             const ReflectionPictures* reflected, const Image& albedo)
    : compositor_(compositor),
      images_(images),
      exposure_(spec.exposure / largest_irradiance),
      albedo_(albedo_of(spec, images, albedo)),
      specular_(specular_of(spec, compositor, frame, images, reflected)) {}

Image ViewComposite::picture(const Image& exitance) const {
  Image scattered = exitance;
  for (std::size_t i = 0; i < scattered.data().size(); ++i) {
    if (images_.mask.data()[i / 3] == 0.0F) scattered.data()[i] = images_.irradiance.data()[i];
  }
  return compositor_.picture({albedo_, specular_, exposure_}, scattered);
}

}  // namespace truescatter
