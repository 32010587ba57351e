#pragma once

#include <array>
#include <functional>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/image.h"
#include "core/vec.h"

namespace truescatter {

// The spherical harmonics of degree 0 to 2 at a unit direction, entry i = l (l + 1) + m (Yang et al.
// equations 7 to 9): real and orthonormal, z the axis.
using ShBasis = std::array<double, 9>;
ShBasis spherical_harmonics(const Vec3d& direction);

// Radiance from everywhere as nine coefficients for each channel, L(w) = sum_i L_i y_i(w) (Yang et al.
// equation 11): this nine-term light is the light, whatever it was projected from, and may be negative
// somewhere.
using EnvironmentSh = std::array<Vec3d, 9>;
EnvironmentSh dark_environment();
Vec3d radiance(const EnvironmentSh& environment, const Vec3d& direction);

// Nine coefficients L_i = integral over the sphere of L(w) y_i(w) dw (equation 10) of a map of radiance by
// longitude and latitude: row 0 is the zenith (+y), the middle column looks along +z, and columns further
// right turn towards -x, so that the map looks as it does from inside. Each pixel counts with its own solid
// angle and its centre's direction. The map is then turned about +y by `rotation_deg`, from +z towards +x.
// The image has three channels or more.
EnvironmentSh project_environment(const Image& lat_long, double rotation_deg);

// An environment that is generated, so that nothing has to be downloaded.
struct BuiltinEnvironment {
  std::string_view name;
  std::string_view summary;
  std::function<Vec3d(const Vec3d& direction)> radiance;
};

// uniform, overcast, sky-ground, side-key, sunset. A surface under uniform has irradiance 1.
const std::vector<BuiltinEnvironment>& builtin_environments();

// A built-in environment as a map like those that project_environment takes. Throws Error (input) at `where`
// for an unknown name.
Image builtin_environment_map(std::string_view name, const SourceLocation& where = {});

// The irradiance that an environment gives, with the occlusion V of the surface (Yang et al. section III B):
//   E = integral of L(w) V(w) max(0, n.w) dw = sum_i L_i g_i       (equations 12 and 13)
//   g_i = integral of V(w) max(0, n.w) y_i(w) dw                   the directional occlusion
// Unoccluded, g_i = A_l y_i(n) with A = pi, 2 pi / 3, pi / 4 (Ramamoorthi & Hanrahan 2001). What is hidden is
// taken from that by a sum over `rays` directions, a Fibonacci lattice on the sphere, the same everywhere, so
// that a point that sees all has no error. A direction that is hidden or seen wrongly at the border of what
// is hidden counts 4 pi / rays: the error is about 0.3 sqrt(b) times that, b the directions along the border.
// E is not below 0, in any channel: where the nine terms give less, there is no light.
class EnvironmentIrradiance {
 public:
  // `rays` > 0 where occlusion will be asked for.
  EnvironmentIrradiance(const EnvironmentSh& environment, int rays);

  // g_i; `hidden(w)` says whether the surface hides the direction w, and is asked for those with n.w > 0.
  using Hidden = std::function<bool(const Vec3d& direction)>;
  ShBasis directional_occlusion(const Vec3d& normal, const Hidden& hidden) const;
  Vec3d irradiance(const Vec3d& normal, const Hidden& hidden) const;
  Vec3d unoccluded(const Vec3d& normal) const;

  // An upper bound of any irradiance, for each channel: that of the light where it is positive, and of what
  // is unoccluded; the largest over 1000 normals and a hundredth more. (It is a convex function of n, so that
  // between normals 0.1 apart it is larger by 1 / cos 0.1 at most.)
  Vec3d largest_possible() const;

 private:
  Vec3d sum(const ShBasis& occlusion) const;

  EnvironmentSh environment_;
  std::vector<Vec3d> directions_;
  std::vector<ShBasis> basis_;  // at the directions
};

}  // namespace truescatter
