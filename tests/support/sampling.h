#pragma once

#include <random>

#include "irradiance/mesh_point.h"

namespace truescatter::test {

// In [0, 1), the same on every platform.
inline double uniform(std::mt19937_64& generator) {
  return static_cast<double>(generator() >> 11U) * 0x1.0p-53;
}

inline Vec3d random_barycentric(std::mt19937_64& generator) {
  Vec3d b;
  for (double& share : b) share = uniform(generator);
  return b / b.sum();
}

}  // namespace truescatter::test
