#pragma once

#include <memory>

#include "core/image.h"

namespace truescatter {

// The difference that a person sees between two pictures when flipping between them: LDR-FLIP of Andersson,
// Nilsson, Akenine-Moeller, Oskarsson, Astrom & Fairchild 2020. Both pictures are linear RGB with values for
// the display in [0, 1] (clipped outside). Per pixel in [0, 1]:
//
//   FLIP = dEc^(1 - dEf)
//
// dEc: HyAB distance of Hunt-adjusted L*a*b* after contrast-sensitivity filters, remapped; dEf: difference of
// edges and points in luminance. `pixels_per_degree`: 67 is a 0.7 m wide 3840-pixel display seen from 0.7 m.
Image flip_map(const Image& reference, const Image& test, double pixels_per_degree = 67.0206);

// The same for many pictures against one reference, whose filters then run once.
class FlipReference {
 public:
  explicit FlipReference(const Image& reference, double pixels_per_degree = 67.0206);
  ~FlipReference();
  FlipReference(FlipReference&&) noexcept;
  FlipReference& operator=(FlipReference&&) noexcept;

  Image map(const Image& test) const;

 private:
  struct Perception;
  std::unique_ptr<Perception> perception_;
};

// The mean of a map over the pixels where the mask is not 0; NaN without one.
double mean_inside(const Image& map, const Image& mask);

}  // namespace truescatter
