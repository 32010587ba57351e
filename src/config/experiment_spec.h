#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace truescatter {

// An experiment as its file states it, every key checked for type and range. Names of methods, profiles and
// built-in scenes are resolved by the modules that know them; `where` lets them name the line.

// What comes before the name of a scene, a map or a shader library that the program has itself, where else a
// file's path stands.
inline constexpr std::string_view kBuiltinPrefix = "builtin:";

// A copy of the scene's mesh, turned about its own +y axis, from +z towards +x, then moved.
struct CharacterSpec {
  Vec3d position_mm = Vec3d::Zero();
  double rotation_deg = 0.0;
};

struct SceneSpec {
  std::string mesh;  // "builtin:NAME", or a file's path (relative to the experiment's file)
  SourceLocation mesh_where;
  std::map<std::string, double> parameters;  // of a built-in scene
  std::map<std::string, SourceLocation> parameters_where;
  double unit_mm = 1.0;
  std::string normals = "automatic";  // automatic | file | angle-weighted
  int loop_subdivisions = 0;
  bool flip_v = false;    // for files that break their format's convention for v
  std::string skin_mask;  // path of a UV texture; empty: all is skin
  SourceLocation skin_mask_where;
  std::string transmitter_mask;  // path of a UV texture; empty: all skin transmits
  SourceLocation transmitter_mask_where;
  std::string normal_map;  // path of a tangent-space map in UV; empty: none
  SourceLocation normal_map_where;
  double normal_map_strength = 1.0;     // multiplies its slope
  std::string normal_map_green = "up";  // up: along v | down: against it
  // Path of a colour texture in UV, a; empty: white. a^m multiplies the irradiance before the scattering, for
  // the truth and every method alike; a^(1 - m) multiplies light after it, in pictures for the eye and in the
  // `textured` errors: exitance, maps, all other errors and FLIP are without that part.
  std::string albedo;
  SourceLocation albedo_where;
  std::string texturing = "after";  // after: m = 0 | before: m = 1 | mix: m = texturing_mix
  double texturing_mix = 0.5;

  // m: the share of the albedo, as an exponent, that comes before the scattering.
  double albedo_exponent_before() const {
    return texturing == "before" ? 1.0 : texturing == "mix" ? texturing_mix : 0.0;
  }
  std::vector<CharacterSpec> characters;  // empty: one, where its file has it
  std::string obtain;                     // where the data can be had; told when a file is missing
};

struct LightSpec {
  std::string type = "directional";  // directional | point | environment
  Vec3d direction = Vec3d::UnitZ();  // directional: towards the light, unit length
  Vec3d position_mm = Vec3d::Zero();
  double reference_mm = 1000.0;  // point: where its irradiance is `color`
  Vec3d color = Vec3d::Ones();
  bool shadows = true;  // directional, point
  // environment: "builtin:NAME", or the path of a map of radiance by longitude and latitude
  std::string map;
  SourceLocation map_where;
  double rotation_deg = 0.0;  // about +y, from +z towards +x
  bool occlusion = true;      // by the mesh, along directions; else every surface sees all of it
  int occlusion_rays = 1024;
};

struct ShadingSpec {
  double tolerance = 0.02;  // of the largest irradiance
  double floor_mm = 0.4;
  double normal_map_edge_mm = 0.4;  // with a normal map: longest edge of visible skin; by default the floor
  double albedo_edge_mm = 0.4;      // the same with an albedo before the scattering
};

struct ViewSpec {
  std::string name;
  Vec3d eye_mm = Vec3d::Zero();
  Vec3d target_mm = Vec3d::Zero();
  Vec3d up = Vec3d::UnitY();
  double fov_deg = 30.0;
  int width_px = 640;
  int height_px = 640;
};

// A diffusion profile of three channels that Gaussians stand for.
struct ProfileModelSpec {
  std::string model;  // classical-dipole | better-dipole | multipole (what the lit side sends back) | burley
                      // | table
  std::string material;  // a name; empty: the coefficients below
  Vec3d sigma_a_per_mm = Vec3d::Zero();
  Vec3d sigma_s_prime_per_mm = Vec3d::Zero();
  double eta = 1.3;
  double thickness_mm = 0.0;            // multipole: of its one slab; 0: it is a stack of layers
  std::string layers;                   // multipole: a CSV of them; empty: the material's
  std::string table;                    // table: a CSV
  std::string scaling = "searchlight";  // burley: or diffuse | diffuse-free-path
  double tolerance = 1e-5;  // of the mixture of Gaussians that its truth is computed by, in the area norm
  bool truth = true;        // its own truth is computed
  SourceLocation where;     // the model's
  SourceLocation material_where;
  SourceLocation file_where;  // of `layers` or `table`
};

// How Gaussians are fitted to a model, or the file of a fit that was made before.
struct FitSpec {
  std::string file;              // a FIT.json; empty: the following
  int gaussians = 0;             // 0: the fewest that keep to the tolerance
  double tolerance = 0.0;        // of the worst channel in the norm
  std::string norm = "r";        // | area (the default for Burley, whose r is not finite) | r2
  bool nonnegative = true;       // weights
  bool keep_albedo = false;      // weights sum to the profile's albedo
  bool shared_variances = true;  // one set for all channels
  std::optional<double> min_variance_mm2;
  std::optional<double> max_variance_mm2;
  int seed = 1;
  SourceLocation where;  // and what else an error may be about
  SourceLocation norm_where;
  SourceLocation tolerance_where;
};

// A profile by its built-in name, spelled out, or fitted.
struct ProfileSpec {
  std::string name;
  SourceLocation where;
  bool builtin = true;  // neither spelled out nor fitted
  Vec3d delta_weight = Vec3d::Zero();
  struct Gaussian {
    Vec3d variance_mm2;
    Vec3d weight;
  };
  std::vector<Gaussian> gaussians;
  double r_max_mm = 0.0;
  std::optional<ProfileModelSpec> of;  // what it approximates
  std::optional<FitSpec> fit;          // of what it approximates, or from a file
};

// A method that the user brings: GLSL passes, or pictures made elsewhere.
struct OwnMethodSpec {
  struct Pass {
    std::string shader;               // a fragment shader's path
    std::vector<std::string> inputs;  // of the frame's textures, or "previous"
    std::map<std::string, double> settings;
    SourceLocation shader_where;
    SourceLocation inputs_where;
    std::map<std::string, SourceLocation> settings_where;
  };
  std::string title;
  std::string source;
  std::string run;                   // per-gaussian | per-term | once
  std::vector<std::string> include;  // GLSL that goes before every shader: paths, or "builtin:NAME"
  SourceLocation include_where;
  std::vector<Pass> passes;  // empty: a picture
  std::string image;         // path with {view} and {profile} in it
  SourceLocation image_where;
  std::string layer;  // of the picture; empty: its plain R, G, B
  // What it sets out to compute.
  bool geodesic = false;
  bool normalised = true;
  std::optional<double> r_max_mm;
  bool visible_only = false;
  bool transmittance = false;
};

struct MethodSpec {
  std::string name;
  std::string label;  // distinguishes two settings of one method; the name if not given
  SourceLocation where;
  std::map<std::string, std::variant<double, std::string>> settings;
  std::map<std::string, SourceLocation> settings_where;
  std::optional<OwnMethodSpec> own;  // none: a built-in method
};

struct TruthSpec {
  double tolerance = 1e-4;  // of the largest irradiance
  int audit_points = 256;
  std::uint64_t seed = 1;
  // What gives and receives light, in every truth: skin | all (what the skin's mask leaves out too).
  std::string mask_truth = "skin";
  // Geodesic truths: own (where a method aims at one) | extra (every method is measured against one too) |
  // off.
  std::string geodesic = "own";
  // Every method is measured against the Euclidean truth of the visible surface too.
  bool visible_only = false;
  // At how many pixels of each view Euclidean less geodesic truth is split by the ways that light takes; 0:
  // none. Methods with transmittance are measured against their own target at these, or at `audit_points`.
  int light_paths = 0;

  int transmittance_points() const { return light_paths > 0 ? light_paths : audit_points; }
  bool cache = true;  // truths are looked for in the user's cache, and kept there
};

// What is measured beyond what every run measures.
struct MetricsSpec {
  bool seam = false;  // errors against the distance to UV seams, and against the UV map's stretch
  bool leak = false;  // light that methods carry from one surface to another: each is lit alone once
};

// The picture that a person sees, of the truth and of every method: exitance times albedo, specular light,
// tone curve.
struct CompositeSpec {
  double exposure = 1.0;         // light is in units of the scene's largest irradiance
  std::string tone = "filmic";   // | linear: see composite/tone.h
  Vec3d albedo = Vec3d::Ones();  // of the skin, times the scene's texture where there is one
  bool specular = true;
  std::string regions;  // of intensity and roughness: a picture in UV, or "builtin:head"; empty: everywhere
                        // as follows
  SourceLocation regions_where;
  double intensity = 0.25;             // rho_s
  double roughness = 0.28;             // m
  double f0 = 0.028;                   // reflectance at normal incidence
  std::string beckmann = "log";        // | power: what the table of Beckmann's distribution holds
  double pixels_per_degree = 67.0206;  // of the display, where it is seen from
};

struct TimingSpec {
  int warm_up = 1;
  int repeats = 3;
};

// Views derived from the experiment's own, over which the spread of each method's error is measured (see
// experiment/stability.h). Each kind is left out where it has no views.
struct StabilitySpec {
  std::string view;                   // that they are derived from; empty: every view
  double orbit_deg = 0.0;             // from the first of the orbit's views to the last
  int orbit_views = 0;                // evenly about the view's target
  std::vector<double> dolly_factors;  // of the distance from the target
  int jitter_views = 0;               // shifted by less than half a pixel
  int points = 2000;                  // surface points, of the skin pixels of the view; 0: all of them
  std::uint64_t seed = 1;             // of their choice

  // Whether they are derived from this view too.
  bool of(const ViewSpec& from) const { return view.empty() || view == from.name; }
};

// A bound on a headline metric; exceeding it ends the run with exit code 1.
struct ThresholdSpec {
  std::string method;  // a method's label
  // bias, mae, rmse, rel_rmse, p50, p95, p99, max; with [composite] visible_mean, _p95, _above_005, _above_01
  std::string metric;
  double maximum = 0.0;
  SourceLocation where;
};

// A chain of assumptions, each a rung: a truth or a method's result that differs from the rung above by one
// assumption. What each adds is measured under every profile in every view.
struct LadderSpec {
  struct Rung {
    // A truth: whole | cut (at the profile's r_max) | cut-visible (and of the visible surface alone) |
    // geodesic, all normalised; raw-cut | raw-cut-visible; empty: a method
    std::string truth;
    std::string method;  // a method's label
    std::string assumption;

    // As results name it.
    std::string name() const { return truth.empty() ? method : "truth-" + truth; }
  };
  std::string name;
  std::vector<Rung> rungs;
};

struct ExperimentSpec;

// One difficulty, taken from easy to hard: the experiment is run once for each value of a key, or of several
// keys that change together.
struct SweepSpec {
  std::vector<std::string> keys;                 // as an override names them
  std::vector<std::vector<std::string>> values;  // [value][key], as TOML
  std::vector<double> axis;  // what each value amounts to, strictly growing or falling; else the value itself
  std::string title;         // of the axis
  std::string unit;
  std::string difficulty = "up";      // down: the smallest of `axis` is the hardest
  std::string scale = "linear";       // of the axis, in charts and between its values; or log
  std::vector<ExperimentSpec> point;  // the experiment at each value; these have no sweep
  SourceLocation where;               // the key's
};

struct ExperimentSpec {
  std::filesystem::path file;
  std::string name;
  std::string question;
  std::string expectation;
  std::string source;
  SceneSpec scene;
  std::vector<LightSpec> lights;
  ShadingSpec shading;
  std::vector<ViewSpec> views;
  std::vector<ProfileSpec> profiles;
  std::vector<MethodSpec> methods;
  bool standard_methods = false;  // they are not the file's own
  TruthSpec truth;
  MetricsSpec metrics;
  std::optional<CompositeSpec> composite;
  TimingSpec timing;
  std::vector<ThresholdSpec> thresholds;
  std::vector<LadderSpec> ladders;
  std::optional<StabilitySpec> stability;
  std::optional<SweepSpec> sweep;
};

// Reads an experiment file and applies overrides "a.b=c" (an entry of an array is named by its `name` or its
// index). Throws Error (input) with file, line, column, the underlined value and the rule: syntax, unknown
// key, wrong type, out of range, missing key.
ExperimentSpec read_experiment(const std::filesystem::path& file,
                               const std::vector<std::string>& overrides = {});

// The same of an experiment that may do without alternatives: where it names no method, or `none` alone, its
// methods are those of standard_methods.toml.
ExperimentSpec read_experiment_or_standard(const std::filesystem::path& file);

// The experiment as TOML with every default written out; reading it gives the same experiment.
std::string to_toml(const ExperimentSpec& spec);

// A path of the experiment: environment variables expanded; relative to the experiment's file, or to the
// working folder where it starts with a variable. A variable that is not set is an Error (input) that repeats
// `obtain`.
std::filesystem::path expanded_path(const ExperimentSpec& spec, const std::string& path,
                                    const SourceLocation& where);

// The same of a file that must be there: if it is not, that is an Error (input) that repeats `obtain`.
std::filesystem::path resolve_path(const ExperimentSpec& spec, const std::string& path,
                                   const SourceLocation& where);

}  // namespace truescatter
