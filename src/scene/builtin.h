#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "scene/mesh.h"

namespace truescatter {

// A number that shapes a built-in scene.
struct BuiltinParameter {
  std::string_view name;  // with its unit
  double default_value;
  double minimum;
  double maximum;
  std::string_view help;
  bool whole = false;  // a whole number
};

using BuiltinParameters = std::map<std::string, double, std::less<>>;

// A generated scene, so that nothing has to be downloaded.
struct BuiltinScene {
  std::string_view name;
  std::string_view summary;
  std::vector<BuiltinParameter> parameters;
  std::function<Mesh(const BuiltinParameters&)> generate;  // all parameters are set and in range
  bool sculpted = false;                                   // generating it takes seconds
};

// The table of built-in scenes: head, sphere, plane, wedge, slab, tube, cards.
const std::vector<BuiltinScene>& builtin_scenes();

// Where a scene's name and its parameters stand in the user's input, for messages.
struct BuiltinLocations {
  SourceLocation name;
  std::map<std::string, SourceLocation> parameters;
};

// A scene's parameters with defaults for those that are not given, checked without generating it.
// Throws Error (input) for an unknown name, at the name, and for an unknown parameter or a value out of its
// range, at the parameter. Too many triangles are edge_mm's fault, or the name's where that is not given.
BuiltinParameters complete_parameters(std::string_view name, const BuiltinParameters& given,
                                      const BuiltinLocations& where = {});

// BuiltinScene::sculpted. Throws Error (input) for an unknown name.
bool is_sculpted(std::string_view name);

// About how many triangles a scene has with these parameters, all of which are given.
double expected_triangles(std::string_view name, const BuiltinParameters& parameters);

// Generates a scene by name; parameters that are not given take their defaults.
// Throws Error (input): see complete_parameters.
Mesh make_builtin(std::string_view name, const BuiltinParameters& parameters = {},
                  const BuiltinLocations& where = {});

// The bust: about 200 mm from chin-and-neck to crown, y up, looking along +z, closed, one UV atlas.
// `edge_mm`: target edge length of its triangles.
Mesh make_head(double edge_mm);

}  // namespace truescatter
