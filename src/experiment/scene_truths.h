#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/experiment_spec.h"
#include "experiment/kept_values.h"
#include "experiment/layer_source.h"
#include "experiment/scene_setup.h"
#include "experiment/visible_surface.h"
#include "truth/cache.h"

namespace truescatter {

// Puts something in the place of a source: a test's doubtful engine.
using SourceWrapper = std::function<std::unique_ptr<LayerSource>(LayerKind, std::unique_ptr<LayerSource>)>;

// The surfaces of a scene that truths are computed over, which all its views share.
class SceneTruths {
 public:
  // `geodesic`: whether any truth is. `cache`: null for none. Scene and cache outlive it. `shared`: what
  // other parts of the experiment need too.
  SceneTruths(const PreparedScene& scene, const TruthSpec& spec, bool geodesic, TruthCache* cache = nullptr,
              SourceWrapper wrap = {}, KeptValues shared = {});
  SceneTruths(const SceneTruths&) = delete;
  SceneTruths& operator=(const SceneTruths&) = delete;

  // Why the mesh cannot carry truths of this target; empty: it can.
  std::string obstacle(const OwnTarget& target) const;
  // Null where the mesh carries no geodesics, or nobody asked for them.
  const GeodesicSurface* geodesic() const { return geodesic_ ? &*geodesic_ : nullptr; }
  const Surface& surface() const { return surface_; }
  const KeptValues& shared() const { return shared_; }
  // Points and `visible` outlive the source; the kind has no obstacle. `visible`: of the points' view, where
  // the kind asks for it.
  std::unique_ptr<LayerSource> source(LayerKind kind, const ViewPoints& points,
                                      const VisibleSurface* visible = nullptr) const;

 private:
  std::unique_ptr<LayerSource> plain_source(LayerKind kind, const ViewPoints& points,
                                            const VisibleSurface* visible) const;

  double tolerance_;
  Surface surface_;
  double largest_irradiance_;
  std::optional<GeodesicSurface> geodesic_;
  std::string no_geodesics_;  // why
  TruthCache* cache_;
  SourceWrapper wrap_;
  KeptValues shared_;
};

}  // namespace truescatter
