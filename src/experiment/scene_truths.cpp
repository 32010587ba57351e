#include "experiment/scene_truths.h"

#include <cassert>
#include <utility>

namespace truescatter {

SceneTruths::SceneTruths(const PreparedScene& scene, const TruthSpec& spec, bool geodesic, SourceWrapper wrap)
    : tolerance_(spec.tolerance),
      skin_(skin_surface(scene.shading)),
      engine_(skin_, spec.tolerance),
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
  return wrap_ ? wrap_(kind, std::move(source)) : std::move(source);
}

}  // namespace truescatter
