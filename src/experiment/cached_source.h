#pragma once

#include <memory>

#include "experiment/layer_source.h"
#include "experiment/kept_values.h"
#include "truth/cache.h"

namespace truescatter {

// A source that takes from the cache what is there, and puts there what `keep` tells it to. A layer's key is
// the source's content_key and the layer; where layers are computed together their values may depend on each
// other's, so the key has all of them, and they are taken from the cache all or none. Bitwise the same values
// with and without the cache. What audits compare with is computed each time, or `shared` with other parts.
std::unique_ptr<LayerSource> cached_source(std::unique_ptr<LayerSource> source, TruthCache& cache,
                                           KeptValues shared = {});

}  // namespace truescatter
