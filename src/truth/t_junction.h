#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

#include "core/vec.h"

namespace truescatter {

// An edge with one triangle only.
struct OpenEdge {
  int from = 0;  // vertices
  int to = 0;
  std::size_t triangle = 0;
};

// A vertex in the middle of an open edge, to 1e-9 of the edge's length: the end of another open edge.
struct TJunction {
  int vertex = 0;
  std::size_t triangle_at_vertex = 0;
  std::size_t triangle_at_edge = 0;
};

// The first one between two triangles that `matters` accepts (the vertex', the edge's).
std::optional<TJunction> find_t_junction(
    std::span<const Vec3d> positions_mm, std::span<const OpenEdge> edges,
    const std::function<bool(std::size_t at_vertex, std::size_t at_edge)>& matters);

}  // namespace truescatter
