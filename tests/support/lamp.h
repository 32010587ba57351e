#pragma once

#include "irradiance/lighting.h"

namespace truescatter::test {

// White light from far away, from this direction.
inline Light lamp(const Vec3d& direction, bool shadows = false) {
  Light light;
  light.direction = direction.normalized();
  light.shadows = shadows;
  return light;
}

}  // namespace truescatter::test
