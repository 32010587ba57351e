#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "experiment/view_points.h"
#include "methods/method.h"
#include "truth/fast.h"
#include "truth/geodesic_surface.h"
#include "truth/surface.h"

namespace truescatter {

// What a layer's distances are measured along.
enum class LayerKind { euclidean, geodesic };

LayerKind kind_of(const OwnTarget& target);

// A layer at every point of a view.
struct ComputedLayer {
  std::vector<Vec4d> values;  // as TruthValues
  double seconds = 0.0;       // that the computation took
};

// Convolutions at the points of one view: by the engine that a run uses, and by the one that audits it. A
// source refers to the scene and the points, which outlive it.
class LayerSource {
 public:
  LayerSource() = default;
  virtual ~LayerSource() = default;
  LayerSource(const LayerSource&) = delete;
  LayerSource& operator=(const LayerSource&) = delete;

  // `advance` is told how many of the points x layers are newly done; it is called from any thread.
  virtual std::vector<ComputedLayer> compute(std::span<const TruthLayer> layers,
                                             const std::function<void(std::size_t)>& advance) const = 0;
  // The exact engine's values at some of the points, to what an audit needs: [layer][chosen point].
  virtual TruthValues audit_values(std::span<const std::uint32_t> chosen,
                                   std::span<const TruthLayer> layers) const = 0;
  // Of the engine that `compute` uses, in units of the largest irradiance.
  virtual double tail_bound() const = 0;
  virtual double largest_irradiance() const = 0;
};

// Each layer by itself: the engine shares nothing between layers.
std::unique_ptr<LayerSource> euclidean_source(const Surface& surface, const FastEngine& engine,
                                              const ViewPoints& points);

// All layers at once, for they share the propagation; each reports an equal part of the seconds.
std::unique_ptr<LayerSource> geodesic_source(const GeodesicSurface& surface, double tolerance,
                                             const ViewPoints& points);

}  // namespace truescatter
