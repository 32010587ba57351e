#pragma once

#include "core/vec.h"

namespace truescatter {

// A pinhole camera. View space: x right, y up, z towards the viewer; the camera looks along -z.
struct Camera {
  Vec3d eye_mm = Vec3d(0.0, 0.0, 500.0);
  Vec3d target_mm = Vec3d::Zero();
  Vec3d up = Vec3d::UnitY();
  double fov_y_deg = 30.0;  // full vertical angle
  int width_px = 640;
  int height_px = 640;
  // The image plane's shift: everything is seen so many pixels farther right and up. For sub-pixel jitter;
  // contours and the visible surface are found of views without one.
  Vec2d shift_px = Vec2d::Zero();

  // Pixels per unit of x/-z: half the height over the tangent of half the angle.
  double focal_px() const;
  // World to view space: a rotation and a translation.
  Mat4d view_matrix() const;
  // Column and row, from the left and the top, at which a point of view space is seen; pixel (x, y) has its
  // centre at (x + 1/2, y + 1/2).
  Vec2d image_point_px(const Vec3d& in_view) const;
  // View space to OpenGL clip space.
  Mat4d projection_matrix(double near_mm, double far_mm) const;
};

}  // namespace truescatter
