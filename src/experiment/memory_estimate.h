#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/plan.h"
#include "experiment/scene_setup.h"

namespace truescatter {

// What a part of a run's memory grows with.
enum class MemoryOf { program, pixels, triangles, texels };

struct MemoryPart {
  std::string name;
  MemoryOf of;
  std::uint64_t bytes;
};

// The parts that are there at once when a run of one view holds the most.
struct MemoryEstimate {
  std::string stage;              // when that is
  std::vector<MemoryPart> parts;  // largest first

  std::uint64_t bytes() const;
  std::uint64_t bytes_of(MemoryOf of) const;
};

// How large a scene is; what is not known is 0, and what follows from it is not counted.
struct SceneSize {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;          // of the scene's mesh
  std::uint64_t shading_triangles = 0;  // of the shading mesh; before it is refined, those of the mesh
  bool has_uvs = false;
};
// Before the shading mesh is made, and with it.
SceneSize size_of(const SceneOutline& outline);
SceneSize size_of(const Mesh& mesh);
SceneSize size_of(const PreparedScene& scene);

// The largest memory that a run of this view holds at any time, every pixel taken for skin: what its
// structures take by their sizes, times what they hold one of (memory_estimate.cpp names each), and what the
// libraries' own take by measurement. Refinement at shadow edges is not foreseen: it shows in
// `shading_triangles` once it is done. Of a mesh with tens of thousands of triangles or more, or a frame of a
// million pixels, measured runs (README, Limits) held 0.5 to 1 times as much.
//
// `jobs`: how many pictures are written at once. Sums are of 64 bits: 2^14 x 2^14 pixels, the most that a
// view may have, and the 2^31 triangles that an index can name take less than 2^50.
MemoryEstimate estimate_memory(const ExperimentSpec& spec, const Plan& plan, const ViewSpec& view,
                               const SceneSize& scene, int jobs);

// The most that a run may take unless it is told otherwise: 16 GiB, or what the machine has where that is
// less.
std::uint64_t default_memory_limit();

// Throws Error (input) for the first view that needs more than `limit_bytes`: names file, scene and view, the
// estimate with its largest parts, and what would lower it.
void refuse_beyond_memory(const ExperimentSpec& spec, const Plan& plan, const SceneSize& scene,
                          std::uint64_t limit_bytes);

// For --dry-run, a line for each view: its estimate, when that is and its largest parts.
std::string describe_memory(const ExperimentSpec& spec, const Plan& plan, const SceneSize& scene);

// The largest resident memory that this process has had so far; 0 where the system does not tell.
std::uint64_t peak_memory();

// "1.5 GiB", "340 MiB".
std::string memory_text(std::uint64_t bytes);

}  // namespace truescatter
