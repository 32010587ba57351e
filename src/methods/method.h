#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "methods/frame.h"
#include "methods/passes.h"
#include "methods/settings.h"
#include "profile/profile.h"

namespace truescatter {

// What a method aims at (README, Definitions): its error against this is the filter's own, the rest is the
// model's.
struct OwnTarget {
  bool geodesic = false;
  bool normalised = true;
  std::optional<double> r_max_mm = std::nullopt;  // none: not cut off
  bool visible_only = false;  // what the view does not see gives no light; not with geodesics
  // And what comes through the body: raw light from beyond r_max (the profile's if not cut off) along the
  // surface whose straight way lies inside. What is normalised is the local part, within r_max along the
  // surface where it is cut off, by either distance; nothing is counted twice. LightPathSample has the
  // formulas.
  bool transmittance = false;

  bool follows_surface() const { return geodesic || transmittance; }
  bool operator==(const OwnTarget&) const = default;
};

// What a method is given. All of it outlives the prepared method.
struct MethodInputs {
  const gpu::Context& context;
  const Frame& frame;
  const SurfaceBuffers& surface;
  double median_skin_depth_mm;
  const Profile& profile;
  const Settings& settings;
};

// A method with its programs compiled and its textures made, ready to draw a frame again and again.
struct PreparedMethod {
  std::function<void(Passes&)> render;   // every pass that the method adds to the shared G-buffer
  const gpu::Texture* output = nullptr;  // exitance in rgb, of the frame's size; lives as long as `render`
};

// How exactly a method keeps constant light constant, is the identity as its widths go to 0, and maps a
// mirrored frame to the mirrored result; each derived in the method's manual. In units of the largest
// irradiance.
struct NumericLimits {
  double rounding = 0.0;  // of all three: what single precision adds
  // Of the identity, times the widths of all levels in pixels times irradiance's largest step between
  // neighbouring pixels.
  double identity_per_px = 0.0;
  // Of the identity, times irradiance's largest change along a texel's edge.
  double identity_per_texel = 0.0;
  // Of both, where the method's own target is raw, so that they are held against a plane's mass,
  // w_0 + sum w_i (1 - exp(-r_max^2 / 2 v_i)): times sum w_i G_i(r_max) r_max min(h, s_i / 2), the light on
  // the cut-off's rim that is as wide as h, a pixel's longer edge on the surface, in mm.
  double raw_rim = 0.0;
  // Of the same: times the largest (r_max / D)^2 / cos^2(theta) + sin^2(theta) tan(theta) tan(rho) / 2, with
  // D the distance of a pixel's point, theta the angle of its face's normal with the view axis and rho its
  // own.
  double raw_perspective = 0.0;
};

// What a method's textures, and what it gathers from them, hold at once while it draws; the frame is not its
// own.
struct MethodMemory {
  double bytes_per_pixel =
      64.0;                      // four targets of 16 bytes, the screen-space methods' (ScreenResult) and one
  double bytes_per_texel = 0.0;  // of its maps, which have its setting `texture_size` squared texels
};

// A technique. To add one: a folder with its GLSL and a file that defines `Method <folder>_method()`, and the
// folder's name in methods/CMakeLists.txt.
struct Method {
  std::string name;
  std::string title;
  std::string source;
  bool needs_uvs = false;
  bool masks_its_taps = true;  // takes no light from what is not skin
  bool reads_all_within_r_max = false;  // every pixel of a disc, which tells seconds from minutes
  NumericLimits limits;
  MethodMemory memory;
  std::vector<SettingSpec> settings;
  std::function<OwnTarget(const Profile&, const Settings&)> own_target;
  // Throws Error (input) if a shader does not compile. Empty: its exitance comes from elsewhere.
  std::function<PreparedMethod(const MethodInputs&)> prepare;
  // Where a user wrote the shaders: compiles them and holds them against their settings, before anything is
  // computed. Throws Error (input).
  std::function<void(const gpu::Context&, const Profile&, const Settings&)> check = {};
};

// Every method that there is, in the order of the table in README, What it does.
const std::vector<Method>& all_methods();

// Throws Error (input) at `where` for an unknown name.
const Method& find_method(std::string_view name, const SourceLocation& where = {});

}  // namespace truescatter
