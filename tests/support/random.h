#pragma once

#include <random>

#include "core/vec.h"

namespace truescatter::test {

// In [0, 1), the same on every platform.
inline double uniform(std::mt19937_64& generator) {
  return static_cast<double>(generator() >> 11U) * 0x1.0p-53;
}

inline double uniform(std::mt19937_64& generator, double low, double high) {
  return low + (high - low) * uniform(generator);
}

// In the cube [-size, size)^3.
inline Vec3d random_vec(std::mt19937_64& generator, double size) {
  return {uniform(generator, -size, size), uniform(generator, -size, size), uniform(generator, -size, size)};
}

inline Vec3d random_barycentric(std::mt19937_64& generator) {
  Vec3d b;
  for (double& share : b) share = uniform(generator);
  return b / b.sum();
}

}  // namespace truescatter::test
