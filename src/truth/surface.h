#pragma once

#include <array>
#include <limits>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// A triangle that gives and receives light, with irradiance linear between its corners.
struct SurfaceTriangle {
  std::array<Vec3d, 3> corners_mm;
  std::array<Vec3d, 3> irradiance;  // RGB at the corners
  int component = 0;                // light does not cross from one component to another

  Vec3d centroid_mm() const { return (corners_mm[0] + corners_mm[1] + corners_mm[2]) / 3.0; }
  double area_mm2() const {
    return 0.5 * (corners_mm[1] - corners_mm[0]).cross(corners_mm[2] - corners_mm[0]).norm();
  }
};

// The surface S of README, Definitions: the skin of the shading mesh, or all of it, as a soup; all that the
// truth needs to know.
struct Surface {
  std::vector<SurfaceTriangle> triangles;

  // The largest irradiance of any channel at any corner: the unit of every tolerance. At least the smallest
  // positive number, so that a dark scene divides by something.
  double largest_irradiance() const;
};

// Where the truth is wanted: a point of the surface and the component that it lies on.
struct SurfacePoint {
  Vec3d position_mm = Vec3d::Zero();
  int component = 0;
};

// One Gaussian of standard deviation `std_dev_mm`, cut off at the distance r_max_mm (infinite: not cut).
struct TruthLayer {
  double std_dev_mm = 0.0;
  double r_max_mm = std::numeric_limits<double>::infinity();

  bool operator==(const TruthLayer&) const = default;
};

// For each layer and point: the raw convolution M_s of RGB in the first three entries, the mass m_s in the
// fourth (README, Definitions).
using TruthValues = std::vector<std::vector<Vec4d>>;

}  // namespace truescatter
