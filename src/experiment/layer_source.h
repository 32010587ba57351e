#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/content_hash.h"
#include "experiment/view_points.h"
#include "methods/method.h"
#include "truth/cache.h"
#include "truth/geodesic_surface.h"
#include "truth/surface.h"

namespace truescatter {

// What a layer is a convolution over, and along what its distances are measured.
enum class LayerKind {
  euclidean,  // S, through the air
  geodesic,   // S, along the surface
  visible,    // what the view sees of S, through the air
  unsure,     // VisibleSurface::unsure: its masses bound what is doubtful about `visible`
};

LayerKind kind_of(const OwnTarget& target);

// A layer at every point of a view.
struct ComputedLayer {
  std::vector<Vec4d> values;  // as TruthValues
  double seconds = 0.0;       // that the computation took, whenever that was
  bool cached = false;        // that was in an earlier run
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
  virtual std::size_t point_count() const = 0;
  // Whether a layer's values may depend, within the tolerance, on which others are computed with it.
  virtual bool computes_together() const = 0;
  // A hash of all that the values depend on, but for the layers: surface, irradiance, points, kind of
  // distance, tolerance, and the engine's version and build.
  virtual std::string content_key() const = 0;

  // After an audit: it was passed, so the values may be kept for later runs; or it was not, and those that an
  // earlier run kept are to be forgotten.
  // `computed` is the l-th of layers that were computed at once.
  virtual void keep(std::span<const TruthLayer> /*layers*/, std::size_t /*l*/,
                    const ComputedLayer& /*computed*/) const {}
  virtual void forget(std::span<const TruthLayer> /*layers*/) const {}
  // Whether all of these layers are kept; if not, what is to be held until they are, so that no other process
  // computes them too.
  virtual bool are_kept(std::span<const TruthLayer> /*layers*/) const { return true; }
  virtual CacheClaim claim(std::size_t /*layers*/) const { return {}; }
};

// Each layer by itself: the engine shares nothing between layers. `largest_irradiance`: of the scene. A
// surface without triangles has values of 0.
std::unique_ptr<LayerSource> euclidean_source(const Surface& surface, double tolerance,
                                              double largest_irradiance, const ViewPoints& points);

// All layers at once, for they share the propagation; each reports an equal part of the seconds.
std::unique_ptr<LayerSource> geodesic_source(const GeodesicSurface& surface, double tolerance,
                                             const ViewPoints& points);

// What geodesic convolutions at these places depend on, but for engine and layers.
void append_content(ContentHash& hash, const GeodesicSurface& surface,
                    std::span<const GeodesicTarget> targets);

}  // namespace truescatter
