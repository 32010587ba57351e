#include "scene/head_gloss.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/head_shape.h"

namespace truescatter {
namespace {

constexpr double kBorder_mm = 3.0;  // from a region's border to where it alone counts

enum Region : std::size_t {
  cheeks,
  temples,
  forehead,
  perioral,
  chin,
  lips,
  eyelids,
  nose,
  neck,
  ears,
  count
};

constexpr std::array<GlossRegion, Region::count> kRegions = {{{"cheeks", {0.25, 0.29}},
                                                              {"temples", {0.22, 0.28}},
                                                              {"forehead", {0.28, 0.25}},
                                                              {"around the mouth", {0.26, 0.27}},
                                                              {"chin", {0.26, 0.26}},
                                                              {"lips", {0.33, 0.24}},
                                                              {"eyelids", {0.24, 0.30}},
                                                              {"nose", {0.34, 0.23}},
                                                              {"neck and scalp", {0.18, 0.32}},
                                                              {"ears", {0.20, 0.31}}}};

// About the distance to an ellipse's outline as seen from the front, positive inside.
double inside_ellipse_mm(const Vec3d& p, double x_mm, double y_mm, double half_width_mm,
                         double half_height_mm) {
  const double norm = std::hypot((p.x() - x_mm) / half_width_mm, (p.y() - y_mm) / half_height_mm);
  return (1.0 - norm) * std::min(half_width_mm, half_height_mm);
}

// The same of the band between two heights, |x| up to a half width.
double inside_band_mm(const Vec3d& p, double low_mm, double high_mm, double half_width_mm) {
  return std::min({p.y() - low_mm, high_mm - p.y(), half_width_mm - p.x()});
}

// How far a point of the right half lies inside a region, laid over those before it; negative outside.
double inside_mm(Region region, const Vec3d& p) {
  switch (region) {
    case cheeks:
    case ears:
    case count:
      return kBorder_mm;
    case temples:
      return std::min(p.x() - 36.0, p.y() - 2.0);
    case forehead:
      return std::min(p.y() - 21.0, 38.0 - p.x());
    case perioral:
      return inside_band_mm(p, -48.0, -27.0, 21.0);
    case chin:
      return inside_ellipse_mm(p, 0.0, -59.0, 20.0, 12.0);
    case lips:
      return inside_ellipse_mm(p, 0.0, -38.5, 19.0, 6.5);
    case eyelids:
      return inside_ellipse_mm(p, 22.0, 7.0, 15.0, 10.0);
    case nose: {
      // From its root between the eyes to its wings it grows wider.
      const double half_width_mm = 6.0 + 10.0 * std::clamp((14.0 - p.y()) / 34.0, 0.0, 1.0);
      return std::min(inside_band_mm(p, -26.0, 16.0, half_width_mm), p.z() - 45.0);
    }
    case neck:
      // Behind the ears and above the hairline, and under the line of the jaw.
      return std::max({-22.0 - p.z(), p.y() - 58.0, -(p.y() + 38.0) - 0.55 * p.z()});
  }
  return -kBorder_mm;
}

}  // namespace

std::span<const GlossRegion> head_gloss_regions() { return kRegions; }

SkinGloss head_gloss(const Vec3d& p_mm) {
  const HeadPart part = head_part(p_mm);
  if (part == HeadPart::ear_front || part == HeadPart::ear_back) return kRegions[ears].gloss;
  const Vec3d half(std::abs(p_mm.x()), p_mm.y(), p_mm.z());
  SkinGloss gloss = kRegions[cheeks].gloss;
  for (const Region region : {temples, forehead, perioral, chin, lips, eyelids, nose, neck}) {
    const double t = std::clamp(0.5 + 0.5 * inside_mm(region, half) / kBorder_mm, 0.0, 1.0);
    const double share = t * t * (3.0 - 2.0 * t);
    gloss.intensity += share * (kRegions[region].gloss.intensity - gloss.intensity);
    gloss.roughness += share * (kRegions[region].gloss.roughness - gloss.roughness);
  }
  return gloss;
}

}  // namespace truescatter
