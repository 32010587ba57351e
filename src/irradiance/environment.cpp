#include "irradiance/environment.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace truescatter {
namespace {

constexpr int kBuiltinHeight = 128;

// Directions that share the sphere's area evenly (Gonzalez 2010, the spherical Fibonacci lattice).
std::vector<Vec3d> fibonacci_directions(int count) {
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0));
  std::vector<Vec3d> directions;
  directions.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count;
    const double radius = std::sqrt(1.0 - z * z);
    directions.emplace_back(radius * std::cos(golden_angle * i), radius * std::sin(golden_angle * i), z);
  }
  return directions;
}

// The direction of longitude and latitude in units of the map's width and height.
Vec3d lat_long_direction(double u, double v) {
  const double longitude = 2.0 * kPi * (u - 0.5);
  const double polar = kPi * v;
  return {-std::sin(polar) * std::sin(longitude), std::cos(polar), std::sin(polar) * std::cos(longitude)};
}

ShBasis unoccluded_transfer(const Vec3d& normal) {
  constexpr std::array<double, 3> kClampedCosine = {kPi, 2.0 * kPi / 3.0, kPi / 4.0};
  ShBasis transfer = spherical_harmonics(normal);
  for (std::size_t i = 0; i < transfer.size(); ++i) transfer[i] *= kClampedCosine[i == 0 ? 0 : i < 4 ? 1 : 2];
  return transfer;
}

// From 0 to 1 as x goes from `low` to `high`, smoothly.
double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace

ShBasis spherical_harmonics(const Vec3d& d) {
  static const double k0 = 0.5 / std::sqrt(kPi);
  static const double k1 = 0.5 * std::sqrt(3.0 / kPi);
  static const double k2 = 0.5 * std::sqrt(15.0 / kPi);
  static const double k20 = 0.25 * std::sqrt(5.0 / kPi);
  return {k0,
          k1 * d.y(),
          k1 * d.z(),
          k1 * d.x(),
          k2 * d.x() * d.y(),
          k2 * d.y() * d.z(),
          k20 * (3.0 * d.z() * d.z() - 1.0),
          k2 * d.x() * d.z(),
          0.5 * k2 * (d.x() * d.x() - d.y() * d.y())};
}

EnvironmentSh dark_environment() {
  EnvironmentSh dark;
  dark.fill(Vec3d::Zero());
  return dark;
}

Vec3d radiance(const EnvironmentSh& environment, const Vec3d& direction) {
  const ShBasis basis = spherical_harmonics(direction);
  Vec3d sum = Vec3d::Zero();
  for (std::size_t i = 0; i < basis.size(); ++i) sum += basis[i] * environment[i];
  return sum;
}

EnvironmentSh project_environment(const Image& lat_long, double rotation_deg) {
  assert(!lat_long.empty() && lat_long.channels() >= 3);
  const Mat3d turn = Eigen::AngleAxisd(rotation_deg * kPi / 180.0, Vec3d::UnitY()).toRotationMatrix();
  EnvironmentSh sum = dark_environment();
  for (int y = 0; y < lat_long.height(); ++y) {
    const double top = std::cos(kPi * y / lat_long.height());
    const double bottom = std::cos(kPi * (y + 1.0) / lat_long.height());
    const double solid_angle = 2.0 * kPi / lat_long.width() * (top - bottom);
    for (int x = 0; x < lat_long.width(); ++x) {
      const Vec3d direction =
          turn * lat_long_direction((x + 0.5) / lat_long.width(), (y + 0.5) / lat_long.height());
      const ShBasis basis = spherical_harmonics(direction);
      for (std::size_t i = 0; i < basis.size(); ++i) sum[i] += solid_angle * basis[i] * lat_long.rgb(x, y);
    }
  }
  return sum;
}

const std::vector<BuiltinEnvironment>& builtin_environments() {
  static const std::vector<BuiltinEnvironment> environments{
      {"uniform", "the same radiance from everywhere",
       [](const Vec3d&) -> Vec3d { return Vec3d::Constant(1.0 / kPi); }},
      {"overcast", "a grey sky three times as bright at the zenith as at the horizon (CIE), over dark ground",
       [](const Vec3d& d) -> Vec3d {
         const double sky = 0.45 * (1.0 + 2.0 * std::max(0.0, d.y())) / 3.0;
         return Vec3d::Constant(d.y() >= 0.0 ? sky : 0.03);
       }},
      {"sky-ground", "a blue sky that fades to a pale horizon, over warm ground",
       [](const Vec3d& d) -> Vec3d {
         const Vec3d zenith(0.15, 0.28, 0.55);
         const Vec3d horizon(0.42, 0.44, 0.46);
         const Vec3d ground(0.12, 0.08, 0.05);
         const Vec3d sky = horizon + (zenith - horizon) * smooth_step(0.0, 0.8, d.y());
         return ground + (sky - ground) * smooth_step(-0.15, 0.05, d.y());
       }},
      {"side-key", "one soft warm key from the side of +x, and a dim cool fill",
       [](const Vec3d& d) -> Vec3d {
         const double toward = d.dot(Vec3d(1.0, 0.3, 0.15).normalized());
         return Vec3d(0.015, 0.018, 0.025) + std::exp(4.0 * (toward - 1.0)) * Vec3d(0.95, 0.85, 0.7);
       }},
      {"sunset", "a red glow low in front, under a violet sky",
       [](const Vec3d& d) -> Vec3d {
         const double glow = std::exp(3.0 * (d.dot(Vec3d(0.25, 0.1, 1.0).normalized()) - 1.0));
         const double sky = smooth_step(-0.3, 0.6, d.y());
         return Vec3d(0.06, 0.04, 0.05) + sky * Vec3d(0.08, 0.07, 0.16) + glow * Vec3d(0.9, 0.42, 0.18);
       }},
  };
  return environments;
}

Image builtin_environment_map(std::string_view name, const SourceLocation& where) {
  std::vector<std::string_view> names;
  for (const BuiltinEnvironment& environment : builtin_environments()) {
    names.push_back(environment.name);
    if (environment.name != name) continue;
    Image map(2 * kBuiltinHeight, kBuiltinHeight, 3);
    for (int y = 0; y < map.height(); ++y) {
      for (int x = 0; x < map.width(); ++x) {
        map.set_rgb(
            x, y,
            environment.radiance(lat_long_direction((x + 0.5) / map.width(), (y + 0.5) / map.height())));
      }
    }
    return map;
  }
  throw_input_error(where, "\"{}\" is not a built-in environment: {}", name, fmt::join(names, ", "));
}

EnvironmentIrradiance::EnvironmentIrradiance(const EnvironmentSh& environment, int rays)
    : environment_(environment), directions_(fibonacci_directions(rays)) {
  for (const Vec3d& direction : directions_) basis_.push_back(spherical_harmonics(direction));
}

ShBasis EnvironmentIrradiance::directional_occlusion(const Vec3d& normal, const Hidden& hidden) const {
  ShBasis transfer = unoccluded_transfer(normal);
  const double solid_angle = 4.0 * kPi / static_cast<double>(directions_.size());
  for (std::size_t d = 0; d < directions_.size(); ++d) {
    const double cosine = normal.dot(directions_[d]);
    if (cosine <= 0.0 || !hidden(directions_[d])) continue;
    for (std::size_t i = 0; i < transfer.size(); ++i) transfer[i] -= solid_angle * cosine * basis_[d][i];
  }
  return transfer;
}

Vec3d EnvironmentIrradiance::irradiance(const Vec3d& normal, const Hidden& hidden) const {
  return sum(directional_occlusion(normal, hidden));
}

Vec3d EnvironmentIrradiance::unoccluded(const Vec3d& normal) const {
  return sum(unoccluded_transfer(normal));
}

Vec3d EnvironmentIrradiance::sum(const ShBasis& occlusion) const {
  Vec3d irradiance = Vec3d::Zero();
  for (std::size_t i = 0; i < occlusion.size(); ++i) irradiance += occlusion[i] * environment_[i];
  return irradiance.cwiseMax(0.0);
}

Vec3d EnvironmentIrradiance::largest_possible() const {
  constexpr int kNormals = 1000;
  constexpr int kDirections = 2000;
  const std::vector<Vec3d> directions = fibonacci_directions(kDirections);
  std::vector<Vec3d> light;
  light.reserve(directions.size());
  for (const Vec3d& direction : directions) light.push_back(radiance(environment_, direction).cwiseMax(0.0));
  Vec3d largest = Vec3d::Zero();
  for (const Vec3d& normal : fibonacci_directions(kNormals)) {
    Vec3d irradiance = Vec3d::Zero();
    for (std::size_t d = 0; d < directions.size(); ++d)
      irradiance += std::max(0.0, normal.dot(directions[d])) * light[d];
    largest = largest.cwiseMax(4.0 * kPi / kDirections * irradiance);
  }
  return 1.01 * largest;
}

}  // namespace truescatter
