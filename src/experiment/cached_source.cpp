#include "experiment/cached_source.h"

#include <optional>
#include <utility>

#include "core/content_hash.h"

namespace truescatter {
namespace {

void append(ContentHash& hash, const TruthLayer& layer) {
  hash.append(layer.std_dev_mm);
  hash.append(layer.r_max_mm);
}

class CachedSource : public LayerSource {
 public:
  CachedSource(std::unique_ptr<LayerSource> source, TruthCache& cache, KeptValues shared)
      : source_(std::move(source)),
        cache_(cache),
        shared_(std::move(shared)),
        content_key_(source_->content_key()) {}

  std::vector<ComputedLayer> compute(std::span<const TruthLayer> layers,
                                     const std::function<void(std::size_t)>& advance) const override {
    return computes_together() ? compute_all(layers, advance) : compute_each(layers, advance);
  }
  void keep(std::span<const TruthLayer> layers, std::size_t l, const ComputedLayer& computed) const override {
    if (!computed.cached) cache_.store(key_of(layers, l), {computed.values, computed.seconds});
  }
  void forget(std::span<const TruthLayer> layers) const override {
    for (std::size_t l = 0; l < layers.size(); ++l) cache_.forget(key_of(layers, l));
  }
  bool are_kept(std::span<const TruthLayer> layers) const override {
    for (std::size_t l = 0; l < layers.size(); ++l) {
      if (!cache_.has(key_of(layers, l), point_count())) return false;
    }
    return true;
  }
  CacheClaim claim(std::size_t layers) const override {
    return cache_.claim(content_key_, layers, point_count());
  }
  TruthValues audit_values(std::span<const std::uint32_t> chosen,
                           std::span<const TruthLayer> layers) const override {
    return shared_.truth_values(audit_content(chosen, layers), layers.size(), chosen.size(),
                                [&] { return source_->audit_values(chosen, layers); });
  }
  double tail_bound() const override { return source_->tail_bound(); }
  double largest_irradiance() const override { return source_->largest_irradiance(); }
  std::size_t point_count() const override { return source_->point_count(); }
  bool computes_together() const override { return source_->computes_together(); }
  std::string content_key() const override { return content_key_; }

 private:
  std::string key_of(std::span<const TruthLayer> layers, std::size_t l) const {
    ContentHash hash;
    hash.append(content_key_);
    append(hash, layers[l]);
    if (computes_together()) {
      for (const TruthLayer& layer : layers) append(hash, layer);
    }
    return hash.hex();
  }

  std::string audit_content(std::span<const std::uint32_t> chosen, std::span<const TruthLayer> layers) const {
    ContentHash hash;
    hash.append(std::string("exact"));
    hash.append(content_key_);
    for (const std::uint32_t point : chosen) hash.append(point);
    for (const TruthLayer& layer : layers) append(hash, layer);
    return hash.hex();
  }

  std::optional<ComputedLayer> find(std::span<const TruthLayer> layers, std::size_t l) const {
    std::optional<CachedLayer> found = cache_.find(key_of(layers, l), point_count());
    if (!found) return std::nullopt;
    return ComputedLayer{std::move(found->values), found->seconds, true};
  }

  std::vector<ComputedLayer> compute_each(std::span<const TruthLayer> layers,
                                          const std::function<void(std::size_t)>& advance) const {
    std::vector<ComputedLayer> computed;
    for (std::size_t l = 0; l < layers.size(); ++l) {
      if (std::optional<ComputedLayer> found = find(layers, l)) {
        advance(point_count());
        computed.push_back(std::move(*found));
      } else {
        computed.push_back(std::move(source_->compute(layers.subspan(l, 1), advance).front()));
      }
    }
    return computed;
  }

  std::vector<ComputedLayer> compute_all(std::span<const TruthLayer> layers,
                                         const std::function<void(std::size_t)>& advance) const {
    std::vector<ComputedLayer> computed;
    for (std::size_t l = 0; l < layers.size(); ++l) {
      std::optional<ComputedLayer> found = find(layers, l);
      if (!found) return source_->compute(layers, advance);
      computed.push_back(std::move(*found));
    }
    advance(point_count() * layers.size());
    return computed;
  }

  std::unique_ptr<LayerSource> source_;
  TruthCache& cache_;
  KeptValues shared_;
  std::string content_key_;
};

}  // namespace

std::unique_ptr<LayerSource> cached_source(std::unique_ptr<LayerSource> source, TruthCache& cache,
                                           KeptValues shared) {
  return std::make_unique<CachedSource>(std::move(source), cache, std::move(shared));
}

}  // namespace truescatter
