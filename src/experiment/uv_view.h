#pragma once

#include <array>
#include <vector>

#include "methods/frame.h"
#include "metrics/seam.h"
#include "scene/mesh.h"

namespace truescatter {

// An edge that two triangles of a mesh share and at an end of which their UVs differ: the surface goes on
// there, its UV map does not.
using SeamEdge = std::array<Vec3d, 2>;  // its ends, mm

// Of the scene's mesh, which has UVs; in no particular order. UVs that differ by rounding (1e-9) are the
// same.
std::vector<SeamEdge> uv_seams(const Mesh& mesh);

// 1 on the skin's pixels that a seam passes through in front of the viewer's eye: where it lies within 0.5 mm
// of the facet that the pixel sees, or of its point (a seam on the back of a sheet thinner than that shows
// through). Seams are followed in steps of a quarter of a pixel.
Image seam_pixels(const std::vector<SeamEdge>& seams, const Camera& camera, const FrameImages& images);

// Seams and stretch as a view sees them. `shading` is of `mesh`, which has UVs.
UvView uv_view(const Mesh& mesh, const ShadingMesh& shading, const Camera& camera, const FrameImages& images);

}  // namespace truescatter
