#pragma once

#include "config/experiment_spec.h"
#include "experiment/pieces.h"
#include "experiment/plan.h"

namespace truescatter {

// About how long a piece takes, in seconds on two cores at 2.3 GHz with the software rasteriser, by the
// experiment's own numbers alone: the same on every machine. Within a factor of three for the pieces of
// quickstart.toml, where a view's truths, which are computed together, count as one; it balances parts, and
// tells hours from minutes. What the pieces of a scene share is in none of them: loading, lighting and
// refining its mesh.
double piece_cost_s(const ExperimentSpec& spec, const Plan& plan, const Piece& piece);

}  // namespace truescatter
