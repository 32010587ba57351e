#pragma once

#include <cstddef>
#include <span>

#include "core/error.h"
#include "scene/mesh.h"

namespace truescatter {

// What leaves a truth without one answer is refused: throws Error (input) at `where`, the mesh's file, that
// names the faces (from 0). `triangles`: those that give light.

// Two triangles of the same corners in the same order would add the light of one place twice. In the opposite
// order they are the two sides of a sheet without thickness, and give twice the light of one as any thin
// sheet does. Triangles without area count for nothing.
void refuse_repeated_triangles(const Mesh& mesh, std::span<const std::size_t> triangles,
                               const SourceLocation& where);

// Light stays within a component (`components`, by triangle of the mesh), and components are told by shared
// edges: where one edge lies on two shorter ones, what looks like one surface is two.
void refuse_parted_surface(const Mesh& mesh, std::span<const std::size_t> triangles,
                           std::span<const int> components, const SourceLocation& where);

}  // namespace truescatter
