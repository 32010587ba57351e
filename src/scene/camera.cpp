#include "scene/camera.h"

#include <cmath>

namespace truescatter {

double Camera::focal_px() const { return 0.5 * height_px / std::tan(0.5 * fov_y_deg * kPi / 180.0); }

Mat4d Camera::view_matrix() const {
  const Vec3d back = (eye_mm - target_mm).normalized();
  const Vec3d right = up.cross(back).normalized();
  const Vec3d true_up = back.cross(right);
  Mat4d m = Mat4d::Identity();
  m.block<1, 3>(0, 0) = right.transpose();
  m.block<1, 3>(1, 0) = true_up.transpose();
  m.block<1, 3>(2, 0) = back.transpose();
  m.block<3, 1>(0, 3) = -m.block<3, 3>(0, 0) * eye_mm;
  return m;
}

Vec2d Camera::image_point_px(const Vec3d& in_view) const {
  const Vec2d from_axis = focal_px() / -in_view.z() * in_view.head<2>() + shift_px;
  return {0.5 * width_px + from_axis.x(), 0.5 * height_px - from_axis.y()};
}

Mat4d Camera::projection_matrix(double near_mm, double far_mm) const {
  Mat4d m = Mat4d::Zero();
  m(0, 0) = 2.0 * focal_px() / width_px;
  m(1, 1) = 2.0 * focal_px() / height_px;
  m(0, 2) = -2.0 * shift_px.x() / width_px;
  m(1, 2) = -2.0 * shift_px.y() / height_px;
  m(2, 2) = -(far_mm + near_mm) / (far_mm - near_mm);
  m(2, 3) = -2.0 * far_mm * near_mm / (far_mm - near_mm);
  m(3, 2) = -1.0;
  return m;
}

}  // namespace truescatter
