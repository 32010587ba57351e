#pragma once

#include <span>
#include <string_view>

#include "core/vec.h"

namespace truescatter {

// How skin reflects: the lobe's intensity rho_s and roughness m (Kelemen & Szirmay-Kalos, see
// composite/specular.h).
struct SkinGloss {
  double intensity = 0.0;
  double roughness = 0.0;
};

// A region of the built-in head's face.
struct GlossRegion {
  std::string_view name;
  SkinGloss gloss;
};

// Ten regions, as Weyrich et al. 2006 measured as many: cheeks, temples, forehead, around the mouth, chin,
// lips, eyelids, nose, neck and scalp, ears. Their values are chosen, not measured: within the walkthrough's
// ranges (m 0.23 to 0.32, rho_s 0.18 to 0.34), the nose and the lips the smoothest and brightest, the neck
// the dullest.
std::span<const GlossRegion> head_gloss_regions();

// The gloss at a point of the built-in head, in its own coordinates: one region passes into the next over 6
// mm.
SkinGloss head_gloss(const Vec3d& p_mm);

}  // namespace truescatter
