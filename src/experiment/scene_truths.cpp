#include "experiment/scene_truths.h"

#include <cassert>
#include <utility>

#include "experiment/cached_source.h"

namespace truescatter {

SceneTruths::SceneTruths(const PreparedScene& scene, const TruthSpec& spec, bool geodesic, TruthCache* cache,
                         SourceWrapper wrap)
    : tolerance_(spec.tolerance),
      skin_(skin_surface(scene.shading)),
      engine_(skin_, spec.tolerance),
      cache_(cache),
      wrap_(std::move(wrap)) {
  if (!geodesic) return;
  // The run goes on without them: everything else can be measured.
  try {
    geodesic_.emplace(geodesic_surface(scene));
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::input) throw;
    no_geodesics_ = std::string("the mesh carries no geodesics: ") + error.what();
  }
}

std::string SceneTruths::obstacle(const OwnTarget& target) const {
  return target.geodesic ? no_geodesics_ : "";
}

std::unique_ptr<LayerSource> SceneTruths::source(LayerKind kind, const ViewPoints& points) const {
  assert(kind != LayerKind::geodesic || geodesic_);
  std::unique_ptr<LayerSource> source = kind == LayerKind::geodesic
                                            ? geodesic_source(*geodesic_, tolerance_, points)
                                            : euclidean_source(skin_, engine_, points);
  if (wrap_) source = wrap_(kind, std::move(source));
  return cache_ != nullptr ? cached_source(std::move(source), *cache_) : std::move(source);
}

}  // namespace truescatter
