#pragma once

#include "config/experiment_spec.h"
#include "experiment/kept_values.h"
#include "scene/builtin.h"
#include "scene/mesh.h"

namespace truescatter {

// make_builtin; what takes seconds (BuiltinScene::is_sculpted) is kept. Throws Error (input): see
// make_builtin.
Mesh builtin_mesh(std::string_view name, const BuiltinParameters& given, const BuiltinLocations& where,
                  const KeptValues& kept);

// A mesh as KeptValues keep it, bit for bit. Throws Error (run) where values are no mesh's.
std::vector<Vec4d> values_of_mesh(const Mesh& mesh);
Mesh mesh_of_values(const std::vector<Vec4d>& values);

}  // namespace truescatter
