#include "experiment/scene_truths.h"

#include <cassert>
#include <cstdlib>
#include <utility>

#include "experiment/cached_source.h"

namespace truescatter {

SceneTruths::SceneTruths(const PreparedScene& scene, const TruthSpec& spec, bool geodesic, TruthCache* cache,
                         SourceWrapper wrap, KeptValues shared)
    : tolerance_(spec.tolerance),
      surface_(scattering_surface(scene.shading)),
      largest_irradiance_(surface_.largest_irradiance()),
      cache_(cache),
      wrap_(std::move(wrap)),
      shared_(std::move(shared)) {
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
  return target.follows_surface() ? no_geodesics_ : "";
}

std::unique_ptr<LayerSource> SceneTruths::plain_source(LayerKind kind, const ViewPoints& points,
                                                       const VisibleSurface* visible) const {
  const auto over = [&](const Surface& surface) {
    return euclidean_source(surface, tolerance_, largest_irradiance_, points);
  };
  switch (kind) {
    case LayerKind::euclidean:
      return over(surface_);
    case LayerKind::geodesic:
      assert(geodesic_);
      return geodesic_source(*geodesic_, tolerance_, points);
    case LayerKind::visible:
      assert(visible != nullptr);
      return over(visible->seen);
    case LayerKind::unsure:
      assert(visible != nullptr);
      return over(visible->unsure);
  }
  std::abort();
}

std::unique_ptr<LayerSource> SceneTruths::source(LayerKind kind, const ViewPoints& points,
                                                 const VisibleSurface* visible) const {
  std::unique_ptr<LayerSource> source = plain_source(kind, points, visible);
  if (wrap_) source = wrap_(kind, std::move(source));
  return cache_ != nullptr ? cached_source(std::move(source), *cache_, shared_) : std::move(source);
}

}  // namespace truescatter
