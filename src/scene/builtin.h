#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scene/mesh.h"

namespace truescatter {

// A number that shapes a built-in scene.
struct BuiltinParameter {
  std::string_view name;  // with its unit
  double default_value;
  double minimum;
  double maximum;
  std::string_view help;
};

using BuiltinParameters = std::map<std::string, double, std::less<>>;

// A generated scene, so that nothing has to be downloaded.
struct BuiltinScene {
  std::string_view name;
  std::string_view summary;
  std::vector<BuiltinParameter> parameters;
  std::function<Mesh(const BuiltinParameters&)> generate;  // all parameters are set and in range
};

// The table of built-in scenes: head, sphere, plane, wedge, slab, tube, cards.
const std::vector<BuiltinScene>& builtin_scenes();

// A scene's parameters with defaults for those that are not given, checked without generating it.
// Throws Error (input) for an unknown name or parameter, a value out of its range, or too many triangles.
BuiltinParameters complete_parameters(std::string_view name, const BuiltinParameters& given);

// Generates a scene by name; parameters that are not given take their defaults.
// Throws Error (input): see complete_parameters.
Mesh make_builtin(std::string_view name, const BuiltinParameters& parameters = {});

// The bust: about 200 mm from chin-and-neck to crown, y up, looking along +z, closed, one UV atlas.
// `edge_mm`: target edge length of its triangles.
Mesh make_head(double edge_mm);

}  // namespace truescatter
