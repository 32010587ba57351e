#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/image.h"
#include "core/vec.h"

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

  // What one keeps of a reference of so many pixels.
  static double kept_bytes(double pixels);

 private:
  friend class HdrFlipReference;
  // With another display than the one that clips; it maps light to [0, 1].
  FlipReference(const Image& reference, double pixels_per_degree, std::function<Vec3d(const Vec3d&)> display);

  struct Perception;
  std::unique_ptr<Perception> perception_;
};

// How many stops of light a picture is looked at through by HDR-FLIP, in powers of two.
struct ExposureRange {
  double start = 0.0;
  double stop = 0.0;
  int count = 0;  // max(2, ceil(stop - start)), evenly spaced from start to stop
};

// The curve by which HDR-FLIP brings light to a display, y = (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5), clipped
// to [0, 1]: Narkowicz's fit of ACES without its pre-exposure of 0.6. Negative light counts as none.
double hdr_flip_tone(double x);

// The exposures of HDR-FLIP for a reference: at the first its largest luminance maps to 0.85, at the last its
// median, both over the pixels where the mask is not 0 (the published definition has no mask: over all). A
// median below `least_light`, what the reference itself is known to, counts as that: at longer exposures its
// uncertainty would be what is seen; nor does it count as less than a single float's epsilon times the
// largest (the authors' program: the epsilon). Without light: from 0 to 0.
ExposureRange hdr_flip_exposures(const Image& reference, const Image& mask, double least_light = 0.0);

// The difference that a person sees between two pictures of high dynamic range at the exposure that shows it
// most: HDR-FLIP of Andersson, Nilsson, Shirley & Akenine-Moeller 2021. Per pixel the largest LDR-FLIP over
// exposures c of hdr_flip_tone(2^c reference) and hdr_flip_tone(2^c test). A factor on both pictures changes
// nothing. What depends on the reference is computed once for as many exposures as `most_bytes` holds, one at
// least, and for the others again for each map.
class HdrFlipReference {
 public:
  static constexpr double kMostBytes = 1024.0 * 1024.0 * 1024.0;

  HdrFlipReference(const Image& reference, const Image& mask, double least_light = 0.0,
                   double pixels_per_degree = 67.0206, double most_bytes = kMostBytes);

  Image map(const Image& test) const;
  const ExposureRange& exposures() const { return exposures_; }

  // What one takes for a reference of so many pixels under so many exposures, a map of one included.
  static double kept_bytes(double pixels, int exposures);

 private:
  static int kept_exposures(double pixels, int exposures, double most_bytes);
  FlipReference at_exposure(int index) const;

  ExposureRange exposures_;
  Image reference_;  // empty where every exposure is kept
  double pixels_per_degree_;
  std::vector<FlipReference> kept_;  // of the first exposures
};

// How far a difference is visible, of a FLIP map over the pixels where the mask is not 0; NaN without one.
struct VisibleDifference {
  double mean = 0.0;
  double p95 = 0.0;        // 95 % quantile (error_stats.h)
  double above_005 = 0.0;  // share of pixels above 0.05
  double above_01 = 0.0;   // and above 0.1
};
VisibleDifference visible_difference(const Image& flip_map, const Image& mask);

// The mean of a map over the pixels where the mask is not 0; NaN without one.
double mean_inside(const Image& map, const Image& mask);

}  // namespace truescatter
