#pragma once

#include "scene/mesh.h"

namespace truescatter {

// Cuts the bust into charts, flattens each without overlap, and packs them into the unit square.
// A few edges at the charts' corners are turned for that.
void lay_out_head_atlas(Mesh& mesh);

}  // namespace truescatter
