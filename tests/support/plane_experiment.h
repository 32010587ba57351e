#pragma once

#include <string>

namespace truescatter::test {

// The scene of an experiment file: 24 x 24 pixels of a square of 20 mm in even light, seen from the front.
inline const std::string kPlane = R"(
[scene]
mesh = "builtin:plane"
[scene.parameters]
size_mm = 20.0
edge_mm = 5.0
[[light]]
direction = [0.0, 0.5, 1.0]
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 100.0]
fov_deg = 10.0
width_px = 24
height_px = 24
)";

}  // namespace truescatter::test
