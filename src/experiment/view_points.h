#pragma once

#include <vector>

#include "core/vec.h"
#include "experiment/scene_setup.h"
#include "methods/frame.h"
#include "truth/geodesic_surface.h"
#include "truth/surface.h"

namespace truescatter {

// The skin pixels of one view, row by row, with the surface point behind each.
struct ViewPoints {
  struct Pixel {
    int x;
    int y;
  };

  std::vector<Pixel> pixels;
  std::vector<int> triangles;            // of the shading mesh
  std::vector<SurfacePoint> on_surface;  // as the Euclidean engines want them
  std::vector<GeodesicTarget> on_mesh;   // the same as the geodesic ones do: on the unrefined mesh
  std::vector<Vec3d> irradiance;

  std::size_t size() const { return pixels.size(); }
};

ViewPoints view_points(const PreparedScene& scene, const FrameImages& images);

}  // namespace truescatter
