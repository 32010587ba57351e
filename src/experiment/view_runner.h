#pragma once

#include <filesystem>

#include "composite/compositor.h"
#include "core/image_io.h"
#include "experiment/pieces.h"
#include "experiment/plan.h"
#include "experiment/scene_setup.h"
#include "experiment/scene_truths.h"
#include "gpu/context.h"
#include "methods/frame.h"

namespace truescatter {

// What stays the same for all runs of a scene.
struct Setup {
  const ExperimentSpec& spec;
  const Plan& plan;
  const PreparedScene& scene;
  const gpu::Context& context;
  const SurfaceBuffers& surface;
  const SceneTruths& truths;
  const PieceStore& pieces;
  const ImageTexts& origin;                // of pictures (see picture_origin)
  std::filesystem::path inputs = {};       // the folder for what methods are given; empty: it is not written
  std::filesystem::path passes = {};       // the folder for the textures that methods name; the same
  bool buffers = false;                    // what a view has before any method draws is written there too
  const Compositor* compositor = nullptr;  // with [composite]
  bool times_shared = false;               // with other work on the machine

  double exposure() const { return 1.0 / scene.largest_irradiance; }
};

// Renders a view, computes its truths, draws, times and measures every method under every profile, and keeps
// each piece as it is finished; those that are kept already are not computed again.
// Throws Error: input for a view that sees no skin or a user's shader that gives no number, run for a failed
// audit, the driver or the disk.
void run_view(const Setup& setup, const ViewSpec& view);

}  // namespace truescatter
