#pragma once

#include "experiment/scene_setup.h"
#include "scene/camera.h"
#include "truth/surface.h"

namespace truescatter {

// What a view sees of S, for truths of the visible surface only.
struct VisibleSurface {
  Surface seen;
  // The triangles that may be seen in part: their convolved mass bounds what taking them as a whole does.
  Surface unsure;
};

// Shading triangles of S are split in four until no edge is half a pixel long in the picture; such a piece
// is seen if its centroid lies inside the picture and nothing of the scene lies between it and the eye. Where
// that does not hold alike for its corners and its centroid it is split on, until no edge is an eighth of a
// pixel long; then it is unsure. Four pieces that are seen become one
// again. Irradiance is that of the shading triangle, linear still.
VisibleSurface visible_surface(const PreparedScene& scene, const Camera& camera);

}  // namespace truescatter
