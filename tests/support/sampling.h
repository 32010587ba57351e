#pragma once

#include "irradiance/mesh_point.h"
#include "support/random.h"
#include "truth/surface.h"

namespace truescatter::test {

// Corners in that cube, irradiance in [0, 1).
inline SurfaceTriangle random_triangle(std::mt19937_64& generator, double size) {
  SurfaceTriangle triangle;
  for (std::size_t c = 0; c < 3; ++c) {
    triangle.corners_mm[c] = random_vec(generator, size);
    triangle.irradiance[c] = random_vec(generator, 1.0).cwiseAbs();
  }
  return triangle;
}

}  // namespace truescatter::test
