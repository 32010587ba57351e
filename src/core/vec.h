#pragma once

#include <Eigen/Dense>
#include <limits>

namespace truescatter {

// The one vector type of the project. Points are columns; millimetres unless a name says otherwise.
using Vec2d = Eigen::Vector2d;
using Vec3d = Eigen::Vector3d;
using Vec4d = Eigen::Vector4d;
using Vec2f = Eigen::Vector2f;
using Vec3f = Eigen::Vector3f;
using Mat3d = Eigen::Matrix3d;
using Mat4d = Eigen::Matrix4d;
using Vec3i = Eigen::Vector3i;

constexpr double kPi = 3.14159265358979323846;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// a x b: twice the signed area that they span, positive where b is to the left of a.
inline double cross(const Vec2d& a, const Vec2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Rec. 709 luminance of linear RGB: the weights of every "luminance" that the tool prints.
inline double luminance(const Vec3d& rgb) { return 0.2126 * rgb.x() + 0.7152 * rgb.y() + 0.0722 * rgb.z(); }

}  // namespace truescatter
