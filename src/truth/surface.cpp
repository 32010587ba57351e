#include "truth/surface.h"

#include <algorithm>

namespace truescatter {

double Surface::largest_irradiance() const {
  double largest = std::numeric_limits<double>::min();
  for (const SurfaceTriangle& triangle : triangles) {
    for (const Vec3d& value : triangle.irradiance) largest = std::max(largest, value.cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace truescatter
